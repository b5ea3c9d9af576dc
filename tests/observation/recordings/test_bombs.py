"""Recordings of strangers: a few kilobytes take neither gigabytes nor hours, and stay in their folder."""

from __future__ import annotations

import gc
import os
import sqlite3
import struct
import time
from collections.abc import Callable
from pathlib import Path

import lz4.frame  # type: ignore[import-untyped]
import pytest
from backports import zstd

from dineros.analysis.nets.memory import peak_memory
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.limits import LIMITS, VARIABLE
from dineros.observation.recordings import Recording
from tests.support.programs.bags import write_bag

MIB = 1 << 20
MAGIC = b"\x89MCAP0\r\n"
STORAGES = ("mcap", "sqlite3")


def said(path: Path) -> str:
    """Return the one line by which a recording is refused, after all of it was read."""
    with pytest.raises(DinerosError) as caught, Recording(path) as recording:
        list(recording.messages())
    text = str(caught.value)
    assert "\n" not in text and text.startswith(str(path))
    return text


def taken(path: Path) -> int:
    """Return the bytes that refusing a recording takes at most."""
    gc.collect()
    Path("/proc/self/clear_refs").write_text("5")  # from here on, the peak is counted again
    before = peak_memory()
    said(path)
    return peak_memory() - before


# MCAP


def text(value: str | bytes) -> bytes:
    content = value if isinstance(value, bytes) else value.encode()
    return struct.pack("<I", len(content)) + content


def record(kind: int, body: bytes) -> bytes:
    return bytes([kind]) + struct.pack("<Q", len(body)) + body


def channel(quality: str = "", number: int = 1) -> bytes:
    schema = record(3, struct.pack("<H", 1) + text("std_msgs/msg/Empty") + text("ros2msg") + text(""))
    said = text(text("offered_qos_profiles") + text(quality))
    return schema + record(4, struct.pack("<HH", number, 1) + text(f"/a{number}") + text("cdr") + said)


def message(time: int) -> bytes:
    return record(5, struct.pack("<HIQQ", 1, 0, time, time) + b"\0\1\0\0\0")


def chunk(size: int, packing: str, data: bytes) -> bytes:
    return record(
        6, struct.pack("<QQQI", 1, 1, size, 0) + text(packing) + struct.pack("<Q", len(data)) + data
    )


def mcap(path: Path, body: bytes, summary: bytes = b"") -> Path:
    head = MAGIC + record(1, text("ros2") + text("x"))
    start = len(head) + len(body) if summary else 0
    path.write_bytes(head + body + summary + record(2, struct.pack("<QQI", start, 0, 0)) + MAGIC)
    return path


CONTENT = channel() + message(1)
PACK: dict[str, Callable[[bytes], bytes]] = {"zstd": zstd.compress, "lz4": lz4.frame.compress}


def filled(size: int) -> bytes:
    """Return records of so many bytes: a message, and one of a private kind that is all zeros."""
    return CONTENT + record(0x80, bytes(size - len(CONTENT) - 9))


@pytest.mark.long
@pytest.mark.parametrize("packing", PACK)
@pytest.mark.parametrize("is_true", [True, False], ids=["true size", "false size"])
@pytest.mark.parametrize("is_indexed", [True, False], ids=["indexed", "unindexed"])
def test_a_chunk_unpacks_to_no_more_than_it_may(
    packing: str, is_true: bool, is_indexed: bool, tmp_path: Path
) -> None:
    content = filled(80 * MIB)
    body = chunk(len(content) if is_true else 1000, packing, PACK[packing](content))
    summary = indexed(body, len(content) if is_true else 1000, packing) if is_indexed else b""
    del content
    told = said(mcap(tmp_path / "a.mcap", body, summary))
    assert ("--limit unpacking=NUMBER" in told) if is_true else ("size mismatch" in told)
    assert taken(tmp_path / "a.mcap") < 10 * MIB


def indexed(body: bytes, size: int, packing: str, times: int = 1) -> bytes:
    """Return a summary that names the chunk so many times; it stands behind the header."""
    start = len(MAGIC) + len(record(1, text("ros2") + text("x")))
    packed = len(body) - 9 - 40 - len(packing)
    index = record(
        8,
        struct.pack("<QQQQ", 1, 1, start, len(body)) + struct.pack("<I", 10) + struct.pack("<HQ", 1, start)
        + struct.pack("<Q", 0) + text(packing) + struct.pack("<QQ", packed, size),
    )  # fmt: skip
    return channel() + index * times


@pytest.mark.parametrize("packing", PACK)
def test_what_recorders_pack_well_is_read(packing: str, tmp_path: Path) -> None:
    content = filled(5 * MIB)
    body = chunk(len(content), packing, PACK[packing](content))
    with Recording(mcap(tmp_path / "a.mcap", body)) as recording:
        assert [time for _, time, _ in recording.messages()] == [1]


def test_many_chunks_count_together(tmp_path: Path) -> None:
    content = filled(30 * MIB)
    body = chunk(len(content), "zstd", zstd.compress(content))
    assert "unpacks to more than" in said(mcap(tmp_path / "a.mcap", 3 * body))


def test_an_index_names_each_chunk_once(tmp_path: Path) -> None:
    content = filled(MIB)
    body = chunk(len(content), "zstd", zstd.compress(content))
    told = said(mcap(tmp_path / "a.mcap", body, indexed(body, len(content), "zstd", times=1000)))
    assert "names a chunk twice" in told


def test_the_limit_can_be_raised(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    content = filled(70 * MIB)
    path = mcap(tmp_path / "a.mcap", chunk(len(content), "zstd", zstd.compress(content)))
    assert "unpacks to more than" in said(path)
    monkeypatch.setenv(VARIABLE, "unpacking=100000")
    with Recording(path) as recording:
        assert recording.count == 1


@pytest.mark.parametrize("length", [1 << 33, 1 << 62, (1 << 64) - 1])
def test_lengths_that_are_not_true_take_no_memory(length: int, tmp_path: Path) -> None:
    path = mcap(tmp_path / "a.mcap", b"\x03" + struct.pack("<Q", length))
    assert "is damaged or cut off" in said(path)
    assert taken(path) < 10 * MIB


@pytest.mark.parametrize(
    ("quality", "why"),
    [
        ("[" * 100_000, "is nested deeper"),
        ("- &a {}\n" + "- *a\n" * 100, "uses anchors or merge keys"),
        ("- &a {b: 1}\n- {<<: [*a, *a]}", "uses anchors or merge keys"),
        ("- '" + "a" * 2_000_000 + "'", "more than 1,048,576 characters"),
        ("- {a: }: b", "is damaged"),
    ],
)
def test_qualities_of_service_are_plain_and_short(quality: str, why: str, tmp_path: Path) -> None:
    assert why in said(mcap(tmp_path / "a.mcap", channel(quality) + message(1)))


def test_qualities_of_all_channels_count_together(tmp_path: Path) -> None:
    body = b"".join(channel(f"# {n}{' ' * 20_000}", n) for n in range(60))
    assert "more than 1,048,576 characters" in said(mcap(tmp_path / "a.mcap", body + message(1)))


# folders


def folder(path: Path, **changed: object) -> Path:
    """Return a folder with a recording of MCAP, whose metadata says what is given."""
    path.mkdir()
    mcap(path / "a.mcap", CONTENT)
    told = {
        "version": 5,
        "message_count": 1,
        "topics_with_message_count": "[]",
        "storage_identifier": "mcap",
        "relative_file_paths": "[a.mcap]",
        **changed,
    }
    lines = "".join(f"  {name}: {value}\n" for name, value in told.items())
    (path / "metadata.yaml").write_text(f"rosbag2_bagfile_information:\n{lines}")
    return path


def test_the_folder_of_these_tests_is_read(tmp_path: Path) -> None:
    with Recording(folder(tmp_path / "bag")) as recording:
        assert recording.count == 1


@pytest.mark.parametrize(
    ("changed", "why"),
    [
        ({"version": 10}, "the version 10 is not known"),
        ({"version": "x"}, "version is 'x', which is not a count"),
        ({"message_count": -1}, "which is not a count"),
        ({"storage_identifier": "python"}, "the storage 'python' is not known"),
        (
            {"compression_mode": "FILE", "compression_format": "gz"},
            "the compression format 'gz' is not known",
        ),
        ({"compression_mode": "ALL"}, "the compression mode 'all' is not known"),
        ({"relative_file_paths": "[a.mcap, a.mcap]"}, "names a file twice"),
        ({"relative_file_paths": "[b.mcap]"}, "b.mcap: is missing"),
        ({"relative_file_paths": "[1]"}, "1 is not a name"),
        ({"relative_file_paths": "[..]"}, "is a directory"),
        ({"relative_file_paths": "['']"}, "is a directory"),
        ({"topics_with_message_count": "7"}, "was not written by a recorder"),
        ({"topics_with_message_count": "[{topic_metadata: {}}]"}, "lacks 'serialization_format'"),
        ({"a": "&a {b: 1}"}, None),
        ({"a": "&a {b: 1}", "c": "*a"}, "uses anchors or merge keys"),
        ({"a": "[" * 30 + "]" * 30}, "is nested deeper than 20"),
        ({"a": "}"}, "is not YAML"),
    ],
)
def test_metadata_is_checked(changed: dict[str, object], why: str | None, tmp_path: Path) -> None:
    bag = folder(tmp_path / "bag", **changed)
    if why is None:
        with Recording(bag) as recording:
            assert recording.count == 1
    else:
        assert why in said(bag)


@pytest.mark.parametrize("name", ["p", "p.mcap", "p.db3"])
def test_pipes_are_not_waited_for(name: str, tmp_path: Path) -> None:
    bag = folder(tmp_path / "bag", relative_file_paths=f"[{name}]")
    os.mkfifo(bag / name)
    assert "is not a plain file" in said(bag)


def test_a_pipe_instead_of_metadata_is_not_waited_for(tmp_path: Path) -> None:
    bag = folder(tmp_path / "bag")
    (bag / "metadata.yaml").unlink()
    os.mkfifo(bag / "metadata.yaml")
    assert "is not a plain file" in said(bag)


def test_links_in_the_folder_are_not_followed(tmp_path: Path) -> None:
    bag = folder(tmp_path / "bag")
    outside = mcap(tmp_path / "outside.mcap", CONTENT)
    (bag / "a.mcap").unlink()
    (bag / "a.mcap").symlink_to(outside)
    assert "is a symbolic link" in said(bag)


@pytest.mark.parametrize("name", ["%2e%2e%2foutside%2edb3", "a?mode=rwc", "a#b", "%00", "é %25"])
def test_a_name_is_not_an_address(name: str, tmp_path: Path) -> None:
    """A database is opened by an address, in which some characters mean something else."""
    outside = write_bag(tmp_path / "outside", [("/outside", 1)], storage="sqlite3") / "outside.db3"
    outside.rename(tmp_path / "outside.db3")
    inside = write_bag(tmp_path / "inside", [("/a1", 1)], storage="sqlite3") / "inside.db3"
    bag = folder(tmp_path / "bag", relative_file_paths=f"['{name}']", storage_identifier="sqlite3")
    (bag / "a.mcap").rename(bag / f"{name}.zstd")  # a packed copy is not another file
    inside.rename(bag / name)
    with Recording(bag) as recording:
        assert [topic.name for topic in recording.topics] == ["/a1"]
        assert [topic for topic, *_ in recording.messages()] == ["/a1"]


def test_a_packed_file_does_not_fill_the_temporary_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    bag = folder(
        tmp_path / "bag",
        relative_file_paths="[a.mcap.zstd]",
        compression_mode="FILE",
        compression_format="zstd",
    )
    (bag / "a.mcap.zstd").write_bytes(zstd.compress(filled(80 * MIB)))
    assert "unpacks to more than 64 MiB" in said(bag)
    (bag / "a.mcap.zstd").write_bytes(zstd.compress(CONTENT * 100_000))

    class Full:
        f_bavail, f_frsize = 1000, 4096

    monkeypatch.setattr("os.statvfs", lambda _: Full())
    assert "more than half of what is free" in said(bag)


def test_a_pointer_of_git_lfs_is_named(tmp_path: Path) -> None:
    bag = folder(tmp_path / "bag")
    (bag / "a.mcap").write_text("version https://git-lfs.github.com/spec/v1\noid sha256:0\nsize 1\n")
    assert "is a pointer of Git LFS, not the recording (`git lfs pull` gets it)" in said(bag)


# SQLite


def database(path: Path, *statements: str) -> Path:
    with sqlite3.connect(path) as connection:
        connection.executescript(
            "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, serialization_format TEXT,"
            " offered_qos_profiles TEXT);"
            "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, data BLOB);"
            "INSERT INTO topics VALUES(1, '/a', 'std_msgs/msg/Empty', 'cdr', '');"
        )
        for statement in statements or ("INSERT INTO messages VALUES(1, 1, 5, X'00')",):
            connection.execute(statement)
    connection.close()
    return path


def test_the_database_of_these_tests_is_read(tmp_path: Path) -> None:
    with Recording(database(tmp_path / "a.db3")) as recording:
        assert [time for _, time, _ in recording.messages()] == [5]


ENDLESS = "WITH RECURSIVE c(x) AS (VALUES(1) UNION ALL SELECT x + 1 FROM c) SELECT"
REPLACED = (
    "UPDATE sqlite_master SET rootpage = 0, type = 'view', sql = 'CREATE VIEW messages AS {}'"
    " WHERE name = 'messages'"
)
WRITABLE = "PRAGMA writable_schema = ON"


@pytest.mark.parametrize(
    "statements",
    [
        [f"CREATE VIEW schema AS {ENDLESS} x AS schema_version FROM c WHERE x < 0"],
        ["CREATE VIEW schema AS SELECT hex(zeroblob(450000000)) AS schema_version"],
        [WRITABLE, REPLACED.format(f"{ENDLESS} x AS id, 1 AS topic_id, x AS timestamp, 0 AS data FROM c")],
        ["CREATE VIRTUAL TABLE schema USING fts5(schema_version)"],
        ["DROP TABLE messages", "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT,"
         " data BLOB AS (hex(zeroblob(400000000))))", "INSERT INTO messages VALUES(1, 1, 5)"],
    ],
    ids=["view", "large view", "messages", "virtual", "computed"],
)  # fmt: skip
def test_a_database_holds_tables_and_computes_nothing(statements: list[str], tmp_path: Path) -> None:
    assert taken(database(tmp_path / "a.db3", *statements)) < 10 * MIB


def test_conditions_of_a_table_are_not_computed(tmp_path: Path) -> None:
    path = database(
        tmp_path / "a.db3",
        "DROP TABLE messages",
        "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INT, timestamp INT,"
        " data BLOB, CHECK (data = 1))",
        "PRAGMA ignore_check_constraints = ON",
        "INSERT INTO messages VALUES(1, 1, 5, X'00')",
    )
    with Recording(path) as recording:
        assert [time for _, time, _ in recording.messages()] == [5]


def test_pages_that_are_used_twice_are_noticed(tmp_path: Path) -> None:
    """A tree whose branches all lead to the same page has rows without end in a small file."""
    path = database(
        tmp_path / "a.db3",
        "PRAGMA page_size = 512",
        f"INSERT INTO messages {ENDLESS} x, 1, x, zeroblob(100) FROM c LIMIT 2000",
    )
    with sqlite3.connect(path) as connection:
        ((root,),) = connection.execute(
            "SELECT rootpage FROM sqlite_master WHERE name = 'messages'"
        ).fetchall()
        ((size,),) = connection.execute("PRAGMA page_size").fetchall()
    connection.close()
    content = bytearray(path.read_bytes())
    page = size * (root - 1)
    assert content[page] == 5  # an interior page
    cells = [
        struct.unpack_from(">H", content, page + 12 + 2 * n)[0]
        for n in range(struct.unpack_from(">H", content, page + 3)[0])
    ]
    first = content[page + cells[0] : page + cells[0] + 4]
    for cell in cells:
        content[page + cell : page + cell + 4] = first
    path.write_bytes(content)
    assert "is damaged" in said(path)


@pytest.mark.parametrize("kind", ["file", "message", "chunk zstd", "chunk lz4"])
def test_frames_are_counted(kind: str, tmp_path: Path) -> None:
    """A frame without content takes nine bytes of the file and much more time than other bytes."""
    pack = lz4.frame.compress if kind == "chunk lz4" else zstd.compress
    content = CONTENT if kind != "message" else b"\0\1\0\0\0"
    for number, is_refused in ((10, False), (300_000, True)):
        bag = folder(
            tmp_path / f"{number}",
            relative_file_paths="[a.mcap.zstd]" if kind == "file" else "[a.mcap]",
            compression_mode=kind.upper() if "chunk" not in kind else "NONE",
            compression_format="zstd",
        )
        whole = (bag / "a.mcap").read_bytes() if kind == "file" else content
        packed = pack(b"") * number + pack(whole)
        if kind == "file":
            (bag / "a.mcap.zstd").write_bytes(packed)
            (bag / "a.mcap").unlink()
        elif kind == "message":
            mcap(bag / "a.mcap", channel() + record(5, struct.pack("<HIQQ", 1, 0, 1, 1) + packed))
        else:
            mcap(bag / "a.mcap", chunk(len(content), kind.split()[1], packed))
        before = time.process_time()
        if is_refused:
            assert "frames; recorders write one" in said(bag)
        else:
            with Recording(bag) as recording:
                assert len(list(recording.messages())) == 1
        assert time.process_time() - before < 2


def test_topics_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = mcap(tmp_path / "a.mcap", b"".join(channel(number=n) for n in range(1, 12)) + message(1))
    monkeypatch.setenv(VARIABLE, "topics=10")
    assert said(path) == (
        f"{path}: holds 11 topics, more than the limit of 10"
        " (make it smaller, or raise the limit: --limit topics=11)"
    )
    monkeypatch.setenv(VARIABLE, "topics=11")
    with Recording(path) as recording:
        assert len(recording.topics) == 11
    assert LIMITS["topics"].most == 10_000


def test_metadata_have_a_limited_size(tmp_path: Path) -> None:
    """The library takes seconds for a MiB, so the file has a limit."""
    topic = "{name: /b, type: std_msgs/msg/Empty, serialization_format: cdr}"
    row = f"\n    - {{topic_metadata: {topic}, message_count: 0}}"
    bag = folder(tmp_path / "long", topics_with_message_count=row * 25_000)
    assert "metadata.yaml: is larger than 2 MiB" in said(bag)


def test_metadata_have_a_limited_number_of_values(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.observation.recordings.plain_yaml.MOST", 1000)
    assert "has more than 1,000 values" in said(folder(tmp_path / "many", a=f"[{'a, ' * 1000}]"))
    with Recording(folder(tmp_path / "few", a=f"[{'a, ' * 900}]")) as recording:
        assert recording.count == 1
