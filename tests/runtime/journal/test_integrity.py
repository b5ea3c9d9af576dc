"""What is damaged is noticed, what is torn is cut, what is old is removed."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any, cast

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import RecordError, current_path, parts_of, read_trace
from dineros.metamodel.records.following import Follower
from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.journal import JournalError, JournalRecorder, rebuild_at, resume_journal
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker

STATE = cast("SavedState", {"marking": {"Words": [[1, {}]]}, "signals": {}})


def write(folder: Path, firings: int = 3, **options: Any) -> Path:
    """Write the journal of a talker."""
    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    recorder = JournalRecorder(folder, "talker", **options)
    node = Node(Net(part), LocalNetwork().transport(), recorder)
    node.open()
    for number in range(firings):
        node.net.signal("Button").set(number % 2 == 0)
        node.run_until_idle()
    node.close()
    return current_path(folder, "talker")


@pytest.mark.parametrize("line", [1, 3, -1])
def test_a_record_whose_content_has_changed_is_refused(tmp_path: Path, line: int) -> None:
    path = write(tmp_path)
    lines = path.read_bytes().splitlines(keepends=True)
    assert all(b',"crc":"' in each for each in lines)
    lines[line] = lines[line].replace(b'"node":"talker"', b'"node":"walker"')
    path.write_bytes(b"".join(lines))
    with pytest.raises(RecordError, match=r"checksum is wrong.*damaged \(restore") as caught:
        resume_journal(tmp_path, "talker")
    assert caught.value.location is not None
    assert caught.value.location.line == (line if line > 0 else len(lines) - 1) + 1


def test_records_without_checksums_are_read(tmp_path: Path) -> None:
    path = write(tmp_path)
    lines = [line.partition(b',"crc"')[0] + b"}\n" for line in path.read_bytes().splitlines()]
    path.write_bytes(b"".join(lines))
    _, checkpoint = resume_journal(tmp_path, "talker")
    assert checkpoint is not None
    assert checkpoint["marking"] == {}


def test_a_torn_tail_is_cut_and_said(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    path = write(tmp_path)
    size = path.stat().st_size
    os.truncate(path, size - 7)
    recorder, _ = resume_journal(tmp_path, "talker")
    recorder.close()
    assert "a crash has cut the last line after" in caplog.text
    assert path.read_bytes().endswith(b'"}\n')


def test_only_a_header_is_no_state(tmp_path: Path) -> None:
    path = write(tmp_path)
    path.write_bytes(path.read_bytes().splitlines(keepends=True)[0])
    with pytest.raises(JournalError, match=r"talker.jsonl: holds no state of its node.*restore it"):
        resume_journal(tmp_path, "talker")


def test_a_journal_that_is_missing_is_missed(tmp_path: Path) -> None:
    write(tmp_path).unlink()
    with pytest.raises(JournalError, match=r"talker.jsonl: is missing .restore it"):
        resume_journal(tmp_path, "talker")
    resume_journal(tmp_path, "listener")[0].close()  # has never begun


def test_an_interrupt_leaves_no_half_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorder = JournalRecorder(tmp_path, "talker")
    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    recorder.open(Net(part).structure.ports, lambda: STATE)
    true_write = os.write

    def half(file: int, content: bytes) -> int:
        monkeypatch.setattr(os, "write", broken)
        return true_write(file, content[:20])

    def broken(file: int, content: bytes) -> int:
        monkeypatch.setattr(os, "write", true_write)
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "write", half)
    with pytest.raises(KeyboardInterrupt):
        recorder.record("signal", signal="Button", value=True)
    recorder.record("stop", reason="interrupted")
    recorder.close()
    events = [record.event for record in read_trace(parts_of(tmp_path, "talker"))]
    assert events == ["header", "checkpoint", "stop"]


def test_old_parts_and_values_go(tmp_path: Path) -> None:
    """Disk stays constant, and the node continues from what is left."""
    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    recorder = JournalRecorder(tmp_path, "talker", part_bytes=4000, kept_parts=2)
    node = Node(Net(part), LocalNetwork().transport(), recorder)
    node.open()
    follower, followed = Follower(tmp_path), []
    sizes = []
    for number in range(1200):
        node.net.signal("Button").set(number % 2 == 0)
        node.run_until_idle()
        if number % 100 == 0:
            followed += [record.sequence for record in follower.new()]
            sizes.append(sum(path.stat().st_size for path in tmp_path.iterdir()))
    node.close()
    followed += [record.sequence for record in follower.new()]
    assert len(parts_of(tmp_path, "talker")) == 3
    assert max(sizes) < 3 * 4000 + 3000
    assert followed == sorted(set(followed))
    assert rebuild_at(tmp_path, "talker").signals == {"Button": False}
    _, checkpoint = resume_journal(tmp_path, "talker")
    assert checkpoint is not None
    with pytest.raises(DinerosError, match="no record 3"):
        rebuild_at(tmp_path, "talker", until=3)


def test_large_values_go_with_the_parts_that_refer_to_them(tmp_path: Path) -> None:
    recorder = JournalRecorder(tmp_path, "talker", part_bytes=1000, kept_parts=1, data_bytes=50)
    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    recorder.open(Net(part).structure.ports, lambda: STATE)
    recorder.record("take", channel="c", place="p", token=1, data={"word": "x" * 100})
    (value,) = (tmp_path / "talker.data").iterdir()
    os.utime(value, (1.0, 1.0))  # as if it had been long ago
    for number in range(40):
        recorder.record("signal", signal="Button", value=number % 2 == 0)
    assert not value.exists()
    recorder.record("take", channel="c", place="p", token=2, data={"word": "y" * 100})
    (value,) = (tmp_path / "talker.data").iterdir()
    os.utime(value, (1.0, 1.0))
    recorder.record("take", channel="c", place="p", token=3, data={"word": "y" * 100})
    for number in range(5):
        recorder.record("signal", signal="Button", value=number % 2 == 0)
    assert value.exists()
    recorder.close()
