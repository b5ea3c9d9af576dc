"""Recordings are read as they were written, and damaged ones end in one line."""

from __future__ import annotations

import os
import random
import shutil
from pathlib import Path

import pytest
from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.matching import Quality
from dineros.observation.recordings import Recording, RecordingError
from dineros.observation.systems import RecordedTopic
from tests.support.programs.bags import STRING, write_bag

STORAGES = ("mcap", "sqlite3")
ENDLESS = QosTime(2_147_483_647, 4_294_967_295)
MESSAGES = [("/a", 10), ("/b", 20), ("/a", 30)]


def best_effort(deadline: QosTime) -> Qos:
    return Qos(
        QosHistory.KEEP_LAST,
        5,
        QosReliability.BEST_EFFORT,
        QosDurability.VOLATILE,
        deadline,
        ENDLESS,
        QosLiveliness.AUTOMATIC,
        ENDLESS,
        False,
    )


@pytest.mark.parametrize("storage", STORAGES)
def test_what_was_written_is_read(storage: str, tmp_path: Path) -> None:
    offered = {"/b": [best_effort(QosTime(0, 500_000_000))]}
    bag = write_bag(tmp_path / "bag", MESSAGES, offered=offered, storage=storage)
    with Recording(bag) as recording:
        assert recording.topics == (
            RecordedTopic("/a", "std_msgs/msg/String", (), 2),
            RecordedTopic(
                "/b",
                "std_msgs/msg/String",
                (Quality("bestEffort", "volatile", "automatic", 0.5, None, None),),
                1,
            ),
        )
        assert (recording.count, recording.start) == (3, 10)
        assert [(topic, time) for topic, time, _ in recording.messages()] == MESSAGES
        assert {data for *_, data in recording.messages()} == {STRING}
        assert [time for _, time, _ in recording.messages({"/a", "/unknown"})] == [10, 30]
        assert list(recording.messages({"/unknown"})) == []
        assert recording.system().topics == recording.topics


@pytest.mark.parametrize("storage", STORAGES)
def test_a_single_file_is_a_recording(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    (file,) = (file for file in bag.iterdir() if file.suffix != ".yaml")
    with Recording(file) as recording:
        assert [(topic, time) for topic, time, _ in recording.messages()] == MESSAGES


def refusal(path: Path) -> str:
    with pytest.raises(DinerosError) as caught, Recording(path) as recording:
        list(recording.messages())
    text = str(caught.value)
    assert "\n" not in text and text.startswith(str(path))
    return text


def test_what_is_no_recording_is_said_in_one_line(tmp_path: Path) -> None:
    assert "this recording does not exist" in refusal(tmp_path / "missing")
    (tmp_path / "empty").mkdir()
    assert "holds no recording" in refusal(tmp_path / "empty")
    (tmp_path / "notes.txt").write_text("hello")
    assert "is not a recording of rosbag2" in refusal(tmp_path / "notes.txt")
    (tmp_path / "nothing.mcap").touch()
    assert "is empty" in refusal(tmp_path / "nothing.mcap")
    os.mkfifo(tmp_path / "pipe.mcap")
    assert "is not a plain file" in refusal(tmp_path / "pipe.mcap")


@pytest.mark.parametrize("storage", STORAGES)
def test_an_empty_recording_says_so(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", [], types={"/a": "std_msgs/msg/String"}, storage=storage)
    assert "holds no message" in refusal(bag)


def test_a_recorder_that_was_killed_is_told(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES)
    (bag / "metadata.yaml").unlink()
    assert "the recorder was not stopped properly" in refusal(bag)


def test_messages_that_are_not_in_the_database_yet_are_not_left_out(tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage="sqlite3")
    (bag / "bag.db3-wal").write_bytes(b"more")
    with pytest.raises(RecordingError, match=r"is not complete: bag\.db3-wal"):
        Recording(bag)


@pytest.mark.parametrize(("topic", "kind"), [("/a", "string"), ("/a", "../msg/String"), ("a b", "x/msg/Y")])
def test_names_are_data(topic: str, kind: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", [(topic, 1)], types={topic: kind})
    assert "unknown type" in refusal(bag) or "a name that is not a valid topic name" in refusal(bag)


@pytest.mark.long
@pytest.mark.parametrize("storage", STORAGES)
def test_damage_anywhere_ends_in_one_line_or_changes_nothing(storage: str, tmp_path: Path) -> None:
    """Cut off at many lengths, with bytes changed at many places: refused in one line, or read."""
    bag = write_bag(tmp_path / "bag", [(f"/t{n % 3}", n) for n in range(50)], storage=storage)
    whole = {file.name: file.read_bytes() for file in bag.iterdir()}
    drawn = random.Random(1)
    refused = 0
    for trial in range(150):
        copy = tmp_path / "copy"
        shutil.rmtree(copy, ignore_errors=True)
        shutil.copytree(bag, copy)
        name = drawn.choice(sorted(whole))
        content = bytearray(whole[name])
        if trial % 2:
            content = content[: drawn.randrange(len(content))]
        for _ in range(drawn.randrange(1, 4) if content else 0):
            content[drawn.randrange(len(content))] = drawn.randrange(256)
        (copy / name).write_bytes(content)
        try:
            with Recording(copy) as recording:
                for _ in recording.messages():
                    pass
        except DinerosError as error:
            assert "\n" not in str(error)
            refused += 1
    assert refused > 50
