"""Traces from somebody else: links in their folder are not followed, references do not leave it."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import Start, StoredToken
from dineros.runtime.application.supervisor import ProcessPlan, Supervisor
from dineros.runtime.journal import JournalRecorder, resume_journal
from dineros.runtime.journal.outlined import Outlined
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import Ports


def _record(folder: Path) -> None:
    ports = cast("Ports", SimpleNamespace(model="m"))  # all that a recorder looks at
    JournalRecorder(folder, "a").open(ports, lambda: cast("SavedState", {}))


def _resume(folder: Path) -> None:
    resume_journal(folder, "a")


def _start(folder: Path) -> None:
    with Supervisor([ProcessPlan("a", ["true"], dict(os.environ), folder / "a.log")]):
        pass


@pytest.mark.parametrize(
    ("work", "name"), [(_record, ".a.jsonl.tmp"), (_resume, "a.jsonl"), (_start, "a.log")]
)
def test_links_are_not_written(tmp_path: Path, work: Callable[[Path], None], name: str) -> None:
    (tmp_path / "victim").write_text("precious")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / name).symlink_to("../victim")
    with pytest.raises(DinerosError, match="is a symbolic link, which is not followed here"):
        work(tmp_path / "run")
    assert (tmp_path / "victim").read_text() == "precious"


def test_a_reference_does_not_leave_the_folder(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.json")  # reading it would wait forever
    stored = {"$stored": "../pipe", "$bytes": 1, "$start": ""}
    record = Start(sequence=0, marking={"p": [StoredToken(1, {"value": stored})]})  # type: ignore[dict-item]
    assert Outlined(tmp_path, "a").inline(record) == record
