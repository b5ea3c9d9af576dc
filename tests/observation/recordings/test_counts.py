"""All messages that a recording says to hold are read, or it is refused: none is taken for not sent."""

from __future__ import annotations

import sqlite3
from contextlib import closing
from pathlib import Path

import pytest
from backports import zstd

from dineros.observation.recordings import Observed, Recording, RecordingError
from tests.support.programs.bags import STRING, write_bag

STORAGES = ("mcap", "sqlite3")
MESSAGES = [("/a", 10), ("/b", 20), ("/a", 30)]
EDITED = """offered_qos_profiles:
          - {history: keep_last, depth: 10, reliability: best_effort, durability: volatile,
             liveliness: automatic, deadline: {sec: 0, nsec: 0}, lifespan: {sec: 0, nsec: 0},
             liveliness_lease_duration: {sec: 0, nsec: 0}, avoid_ros_namespace_conventions: false}"""


def edited(bag: Path, before: str, after: str) -> Path:
    """Change the metadata of a recording."""
    file = bag / "metadata.yaml"
    text = file.read_text()
    assert before in text
    file.write_text(text.replace(before, after))
    return bag


def read(bag: Path) -> list[tuple[str, int]]:
    with Recording(bag) as recording:
        return [(topic, time) for topic, time, _ in recording.messages()]


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("offered_qos_profiles: []", EDITED),
        ("RIHS01_", "RIHS01_f"),
        ("version: 9", "version: 5"),
    ],
    ids=["quality", "hash", "version"],
)
def test_metadata_that_differs_from_the_files_hides_no_message(
    storage: str, before: str, after: str, tmp_path: Path
) -> None:
    bag = edited(write_bag(tmp_path / "bag", MESSAGES, storage=storage), before, after)
    assert read(bag) == MESSAGES


@pytest.mark.parametrize("storage", STORAGES)
def test_a_topic_that_only_the_files_know_is_read(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    (file,) = (file.name for file in bag.iterdir() if file.suffix != ".yaml")
    (bag / "metadata.yaml").write_text(
        "rosbag2_bagfile_information: {version: 5, message_count: 2, topics_with_message_count: [],\n"
        f"  storage_identifier: {storage}, relative_file_paths: [{file}]}}"
    )
    assert read(bag) == MESSAGES


@pytest.mark.parametrize("storage", STORAGES)
def test_a_topic_that_only_the_metadata_knows_is_refused(storage: str, tmp_path: Path) -> None:
    bag = edited(write_bag(tmp_path / "bag", MESSAGES, storage=storage), "name: /b", "name: /c")
    with pytest.raises(RecordingError, match="declares 1 message on '/c', but only 0 can be read"):
        read(bag)


@pytest.mark.parametrize("storage", STORAGES)
def test_fewer_messages_than_the_recording_says_are_refused(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    edited(bag, "message_count: 2", "message_count: 4")
    with pytest.raises(RecordingError, match="declares 4 messages on '/a', but only 2 can be read"):
        Recording(bag)


@pytest.mark.parametrize("storage", STORAGES)
def test_the_sum_of_messages_counts_as_well(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    edited(bag, "message_count: 3", "message_count: 7")
    with pytest.raises(RecordingError, match="declares 7 messages, but only 3 can be read"):
        Recording(bag)


@pytest.mark.parametrize("storage", STORAGES)
def test_a_file_that_the_metadata_does_not_name_is_not_ignored(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    (file,) = (file for file in bag.iterdir() if file.suffix != ".yaml")
    more = file.rename(bag / f"second{file.suffix}")
    file.write_bytes(more.read_bytes())
    with pytest.raises(
        RecordingError, match=rf"holds second\{file.suffix}, which metadata.yaml does not name"
    ):
        Recording(bag)
    more.rename(bag / f"{file.name}.zstd")  # the packed form of a file that was unpacked next to it
    assert read(bag) == MESSAGES


@pytest.mark.parametrize(
    "change", ["DELETE FROM topics WHERE name = '/b'", "UPDATE messages SET topic_id = 9"]
)
def test_messages_of_topics_that_a_database_does_not_describe_are_not_ignored(
    change: str, tmp_path: Path
) -> None:
    file = write_bag(tmp_path / "bag", MESSAGES, storage="sqlite3") / "bag.db3"
    with closing(sqlite3.connect(file)) as database, database:
        database.execute(change)
    with pytest.raises(RecordingError, match=r"holds 3 messages, but only \d on topics that it describes"):
        Recording(file)


def test_messages_missing_behind_a_count_are_noticed_at_the_end(tmp_path: Path) -> None:
    """The index of a file tells three messages; the chunk that it names holds two of them."""
    bag = write_bag(tmp_path / "bag", MESSAGES)
    file = bag / "bag.mcap"
    content = bytearray(file.read_bytes())
    # The last message becomes a record of a private kind, which readers pass over.
    record = b"\x05" + (22 + len(STRING)).to_bytes(8, "little")
    content[content.rindex(record)] = 0x80
    file.write_bytes(content)
    with Recording(bag) as recording:
        found = recording.messages()
        with pytest.raises(RecordingError, match="declares 2 messages on '/a', but only 1 can be read"):
            list(found)


@pytest.mark.parametrize("storage", STORAGES)
@pytest.mark.parametrize("times", [(0, 100), (100, 0), (0, 5)], ids=["in order", "reversed", "overlapping"])
def test_split_recordings_are_read_in_order_of_times(
    storage: str, times: tuple[int, int], tmp_path: Path
) -> None:
    files = []
    for number, start in enumerate(times):
        part = write_bag(
            tmp_path / f"part{number}", [("/a", start + 10 * n) for n in range(3)], storage=storage
        )
        files += [file for file in part.iterdir() if file.suffix != ".yaml"]
    bag = tmp_path / "part0"
    files[1].rename(bag / files[1].name)
    edited(bag, f"relative_file_paths:\n  - {files[0].name}",
           f"relative_file_paths:\n  - {files[0].name}\n  - {files[1].name}")  # fmt: skip
    edited(bag, "message_count: 3", "message_count: 6")
    assert [time for _, time in read(bag)] == sorted(start + 10 * n for start in times for n in range(3))


@pytest.mark.parametrize("storage", STORAGES)
def test_packed_recordings_are_read(storage: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    temporary = tmp_path / "temporary"
    temporary.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(temporary))
    bag = write_bag(tmp_path / "bag", MESSAGES, storage=storage)
    (file,) = (file for file in bag.iterdir() if file.suffix != ".yaml")
    (bag / f"{file.name}.zstd").write_bytes(zstd.compress(file.read_bytes()))
    file.unlink()
    edited(bag, f"- {file.name}", f"- {file.name}.zstd")
    edited(bag, "compression_mode: ''", "compression_mode: FILE")
    edited(bag, "compression_format: ''", "compression_format: zstd")
    with Recording(bag) as recording:
        assert [(topic, time) for topic, time, _ in recording.messages()] == MESSAGES
        assert list(temporary.iterdir()) == []


@pytest.mark.parametrize("storage", STORAGES)
def test_packed_messages_are_read(storage: str, tmp_path: Path) -> None:
    packed = [(topic, time, zstd.compress(STRING)) for topic, time in MESSAGES]
    bag = write_bag(tmp_path / "bag", packed, storage=storage)
    edited(bag, "compression_mode: ''", "compression_mode: MESSAGE")
    edited(bag, "compression_format: ''", "compression_format: zstd")
    with Recording(bag) as recording:
        assert {data for *_, data in recording.messages()} == {STRING}


@pytest.mark.parametrize("storage", STORAGES)
def test_a_topic_without_a_slash_is_read_by_its_name(storage: str, tmp_path: Path) -> None:
    bag = write_bag(tmp_path / "bag", [("scan", 1), ("/good", 2), ("scan", 3)], storage=storage)
    assert read(bag) == [("scan", 1), ("/good", 2), ("scan", 3)]
    with Recording(bag) as recording:
        assert recording.left_out == ()
        observed = Observed(recording)
        assert [topic.name for topic in observed.recorded] == ["/good", "/scan"]  # as models have it
        assert list(observed.messages()) == [("/scan", 1), ("/good", 2), ("/scan", 3)]


@pytest.mark.parametrize(
    ("topic", "kind", "why"),
    [
        ("a b", "std_msgs/msg/String", "topic 'a b' has a name that is not a valid topic name"),
        ("/a\x1b[2J", "std_msgs/msg/String", r"topic '/a\x1b[2J' has a name that is not a valid topic name"),
        ("/", "std_msgs/msg/String", "topic '/' has a name that is not a valid topic name"),
        (
            "good",
            "std_msgs/msg/String",
            "topic 'good' is the same as /good to a model, and both were recorded",
        ),
        ("/a", "foxglove.Log", "topic '/a' is of the unknown type 'foxglove.Log'; a type is like"),
    ],
)
def test_one_odd_topic_is_left_out_and_the_others_are_read(
    topic: str, kind: str, why: str, tmp_path: Path
) -> None:
    bag = write_bag(tmp_path / "bag", [("/good", 1), (topic, 2), ("/good", 3)], types={topic: kind})
    with Recording(bag) as recording:
        assert [each.name for each in recording.topics] == ["/good"]
        assert [(name, time) for name, time, _ in recording.messages()] == [("/good", 1), ("/good", 3)]
        (said,) = recording.left_out
        assert said.startswith(why)
        assert recording.count == 2
