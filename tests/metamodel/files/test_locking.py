"""A file is locked under the name that it has, whatever happens between its opening and its locking."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dineros.metamodel.editing import Document
from dineros.metamodel.editing.commands import Set
from dineros.metamodel.editing.journal import JournalError, journal_of
from dineros.metamodel.files import save
from dineros.metamodel.files.locking import open_locked
from tests.support.systems.talker import talker

FLAGS = os.O_RDWR | os.O_CREAT


def before_the_next_lock(monkeypatch: pytest.MonkeyPatch, action: Callable[[], Any]) -> None:
    """Do something after the next file is opened, and before it is locked."""
    real = fcntl.flock

    def later(file: int, operation: int) -> None:
        monkeypatch.setattr(fcntl, "flock", real)
        action()
        real(file, operation)

    monkeypatch.setattr(fcntl, "flock", later)


@pytest.mark.parametrize("event", ["removed", "replaced", "renamed"])
def test_the_locked_file_has_the_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, event: str) -> None:
    path, other = tmp_path / "file", tmp_path / "other"
    path.write_text("old")
    other.write_text("new")
    actions: dict[str, Callable[[], object]] = {
        "removed": path.unlink,
        "replaced": lambda: other.replace(path),
        "renamed": lambda: path.rename(tmp_path / "part"),
    }
    before_the_next_lock(monkeypatch, actions[event])
    file = open_locked(path, FLAGS)
    assert file is not None
    assert os.path.samestat(os.fstat(file), path.stat())
    assert os.read(file, 10) == (b"new" if event == "replaced" else b"")
    assert open_locked(path, FLAGS) is None
    os.close(file)


def test_an_editor_that_ends_leaves_the_next_one_its_journal(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    model = tmp_path / "talker.sym.xmi"
    save(talker(), model)
    first = Document(model)
    before_the_next_lock(monkeypatch, first.close)
    second = Document(model)
    root = second.handles.of(second.root)
    assert root is not None
    second.do([Set(root, "name", "confirmed")])
    assert b"confirmed" in journal_of(model).read_bytes()
    with pytest.raises(JournalError, match="another process"):
        Document(model)
    second.close()


@pytest.mark.parametrize("left", [None, 0o666])
def test_a_journal_is_for_its_owner_only(tmp_path: Path, left: int | None) -> None:
    model = tmp_path / "talker.sym.xmi"
    save(talker(), model)
    model.chmod(0o600)
    journal = journal_of(model)
    if left is not None:  # by an earlier version
        journal.touch()
        journal.chmod(left)
    umask = os.umask(0)
    try:
        document = Document(model)
    finally:
        os.umask(umask)
    assert journal.stat().st_mode & 0o777 == 0o600
    document.close()
