"""Lines around lines: of source code within the roots, and of nothing else."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel.errors import Location
from dineros.views.reports.excerpts import Excerpts


def test_lines_around_a_line_and_at_the_ends_of_a_file(tmp_path: Path) -> None:
    file = tmp_path / "node.py"
    file.write_text("\n".join(f"line {number}" for number in range(1, 11)))
    first, middle, last = Excerpts([tmp_path]).of([Location(file, number) for number in (1, 5, 10)])
    assert [number for number, _, _ in first.lines] == [1, 2, 3, 4]
    assert [number for number, _, _ in middle.lines] == [2, 3, 4, 5, 6, 7, 8]
    assert [(number, text) for number, text, is_marked in last.lines if is_marked] == [(10, "line 10")]
    assert middle.place == f"{file}:5"


@pytest.mark.parametrize("name", ["../secret.py", "link.py", "inner/notes.txt", "key.pem", "no.py", "inner"])
def test_what_is_no_source_code_within_the_roots_is_not_read(tmp_path: Path, name: str) -> None:
    root = tmp_path / "root"
    (root / "inner").mkdir(parents=True)
    for path in (tmp_path / "secret.py", root / "inner" / "notes.txt", root / "key.pem", root / "seen.py"):
        path.write_text("secret\n")
    (root / "link.py").symlink_to(tmp_path / "secret.py")
    excerpts = Excerpts([root])
    assert excerpts.of([Location(root / name, 1)]) == []
    assert len(excerpts.of([Location(root / "seen.py", 1)])) == 1
    assert excerpts.of([Location(root / "seen.py", 7), Location(root / "seen.py")]) == []
