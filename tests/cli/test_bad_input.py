"""No file makes a command print anything but one line, or end with a status other than 2."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import pytest

from tests.cli.conftest import Run

CORPUS = Path(__file__).resolve().parents[1] / "metamodel/bad_input"
FILES = sorted(path for path in CORPUS.rglob("*") if path.is_file() and path.suffix not in {".md", ".py"})


def refused(run: Run, path: Path, folder: Path) -> None:
    for arguments in (["validate", path], ["convert", path, "-o", folder / "out.pnml"]):
        result = run(*arguments)
        assert (result.exit_code, result.stdout) == (2, "")
        assert result.stderr.startswith(str(path))
        assert result.stderr.count("\n") == 1
        assert "please report it" not in result.stderr
    assert not (folder / "out.pnml").exists()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_a_file_of_the_corpus(run: Run, path: Path, tmp_path: Path) -> None:
    refused(run, path, tmp_path)


def test_the_corpus_is_there() -> None:
    assert len(FILES) >= 60


@pytest.mark.parametrize("suffix", ["xmi", "pnml", "net"])
def test_a_file_that_is_no_file(run: Run, tmp_path: Path, suffix: str) -> None:
    (tmp_path / f"folder.{suffix}").mkdir()
    refused(run, tmp_path / f"folder.{suffix}", tmp_path)
    refused(run, tmp_path / f"missing.{suffix}", tmp_path)
    refused(run, tmp_path / f"folder.{suffix}" / f"missing.{suffix}", tmp_path)


@pytest.mark.parametrize("content", [b"", b"\0\xff\xfe" * 1000, b"<" * 100_000, b"\n" * 10])
@pytest.mark.parametrize("name", ["m.xmi", "m.sym", "m.pnml", "m.txt", "m"])
def test_what_is_no_model(run: Run, tmp_path: Path, name: str, content: bytes) -> None:
    (tmp_path / name).write_bytes(content)
    refused(run, tmp_path / name, tmp_path)


def test_what_is_wrong_with_a_long_argument_is_said_in_short(run: Run, model: Path) -> None:
    for option in ("--set", "--limit"):
        result = run("validate", model, option, "x" * 100_000)
        assert result.exit_code == 2
        assert result.stderr.count("\n") == 1
        assert len(result.stderr) < 2100
        assert result.stderr.rstrip().endswith(")")  # what would fix it


def test_hints_quote_names_of_files_for_the_shell(run: Run, broken: Path) -> None:
    """What a hint says can be given to a shell as it is."""
    odd = broken.with_name("my $(model) 'x'" + "".join(broken.suffixes))
    broken.rename(odd)
    result = run("check", odd)
    assert result.exit_code == 2
    command = re.search(r"`(dineros validate .*)` says how to fix it", result.stderr)
    assert command is not None, result.stderr
    assert shlex.split(command[1]) == ["dineros", "validate", str(odd)]
