"""Whatever stands in a file: a model or one line that says where and what; never another exception."""

from __future__ import annotations

import os
import time
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load

FOLDER = Path(__file__).resolve().parents[1] / "bad_input"
EXPECTED = tomllib.loads((FOLDER.parent / "bad_input.toml").read_text(encoding="utf-8"))
SUFFIXES = ("xmi", "pnml", "net", "xml")


def refusal(path: Path) -> DinerosError:
    """Return the error that a file is refused with; it is one line that names the file."""
    with pytest.raises(DinerosError) as caught:
        load(path)
    text = str(caught.value)
    assert text.startswith(str(path))
    assert "\n" not in text
    assert len(text) < 1000 + len(str(path))
    return caught.value


def test_the_corpus_and_its_table_agree() -> None:
    assert sorted(path.name for path in FOLDER.iterdir()) == sorted(EXPECTED)
    assert len(EXPECTED) >= 60


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_a_bad_file_is_refused_in_one_line(name: str) -> None:
    error = refusal(FOLDER / name)
    assert EXPECTED[name]["message"] in str(error).removeprefix(str(FOLDER))
    assert error.location is not None
    assert error.location.line == EXPECTED[name].get("line")


# Files that are too large or too special to be stored -----------------------------------------------------

NET = '<pn:Net xmlns:pn="http://dineros.org/pn/1.0" id="n">%s</pn:Net>'
PNML = (
    '<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n" '
    'type="http://www.pnml.org/version-2009/grammar/ptnet"><page id="g">%s</page></net></pnml>'
)
TOOL = '<toolspecific tool="de.tudresden.inf.st.pnml.distributedPN" version="0.1"><balloonMarking><tokens>'

LARGE: dict[str, Callable[[], str]] = {
    "nested_pages.xmi": lambda: NET % ('<pages id="a">' * 100_000 + "</pages>" * 100_000),
    "nested_pages.pnml": lambda: PNML % ('<page id="a">' * 100_000 + "</page>" * 100_000),
    "never_closed.xmi": lambda: "<a>" * 100_000,
    "never_closed.pnml": lambda: "<page>" * 100_000,
    "nested_braces.net": lambda: "{" * 100_000,
    "brackets.net": lambda: "tr a " + "[" * 100_000,
    "many_ids.xmi": lambda: NET % f'<pages id="a"><arcs id="b" source="{"t " * 4_900_000}"/></pages>',
    "many_objects.xmi": lambda: NET % ("<pages/>" * 6_000_000),
    "tokens.pnml": lambda: PNML % f'<place id="p">{TOOL}{"<token>{}</token>" * 3_000_000}',
    "token.pnml": lambda: PNML % f'<place id="p">{TOOL}<token>{"[" * 50_000_000}</token>',
    "marking.pnml": lambda: (
        PNML % f'<place id="p"><initialMarking><text>{"9" * 9_000_000}</text></initialMarking></place>'
    ),
    "marking.net": lambda: f"pl p ({'9' * 50_000_000})",
    "arcs.net": lambda: "tr t " + "p " * 25_000_000,
    "above_the_limit.xmi": lambda: " " * (65 * 1024 * 1024),
}


@pytest.mark.long
@pytest.mark.parametrize("name", LARGE)
def test_a_huge_or_deep_file_is_refused_within_seconds_of_the_processor(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    path.write_text(LARGE[name](), encoding="utf-8")
    start = time.process_time()
    refusal(path)
    assert time.process_time() - start < 30  # a few seconds; machines that run tests are slow
    path.unlink()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_path_that_is_no_file_is_refused(tmp_path: Path, suffix: str) -> None:
    folder, pipe = tmp_path / f"folder.{suffix}", tmp_path / f"pipe.{suffix}"
    folder.mkdir()
    os.mkfifo(pipe)
    (tmp_path / f"circle.{suffix}").symlink_to(f"circle.{suffix}")
    (tmp_path / f"device.{suffix}").symlink_to("/dev/zero")
    assert "is a directory" in refusal(folder).message
    assert "is not a plain file" in refusal(pipe).message
    assert "is not a plain file" in refusal(tmp_path / f"device.{suffix}").message
    assert "symbolic links" in refusal(tmp_path / f"circle.{suffix}").message
    assert "Not a directory" in refusal(pipe / f"a.{suffix}").message
    assert "No such file" in refusal(tmp_path / f"missing.{suffix}").message


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_without_permission_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, suffix: str
) -> None:
    path = tmp_path / f"secret.{suffix}"
    path.touch(mode=0)
    if os.geteuid() == 0:  # root may read every file; let the system say what it says to others

        def refuse(*_: object) -> int:
            raise PermissionError(13, "Permission denied")

        monkeypatch.setattr("dineros.metamodel.files.reading.os.open", refuse)
    assert "Permission denied" in refusal(path).message
