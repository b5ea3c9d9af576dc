"""Traces that grow while they are read."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel.files.reading import read_pieces
from dineros.metamodel.records import Fire, Header, RecordError, encode_record, following
from dineros.metamodel.records.following import Follower


def fire(sequence: int) -> str:
    return encode_record(Fire(sequence=sequence, transition="t")) + "\n"


HEADER = encode_record(Header(sequence=0, kind="run", model="m")) + "\n"


def sequences(follower: Follower) -> list[int]:
    return [record.sequence for record in follower.new()]


def append(path: Path, text: str) -> None:
    with path.open("a", encoding="utf-8") as file:
        file.write(text)


def test_a_folder_that_comes_later(tmp_path: Path) -> None:
    follower = Follower(tmp_path / "run")
    assert follower.new() == []
    (tmp_path / "run").mkdir()
    append(tmp_path / "run/a.jsonl", HEADER + fire(1))
    assert sequences(follower) == [0, 1]
    assert sequences(follower) == []


def test_a_line_is_read_when_it_is_complete(tmp_path: Path) -> None:
    follower = Follower(tmp_path)
    append(tmp_path / "a.jsonl", HEADER + fire(1)[:10])
    assert sequences(follower) == [0]
    append(tmp_path / "a.jsonl", fire(1)[10:] + fire(2))
    assert sequences(follower) == [1, 2]


def test_a_cut_line_that_the_resumed_node_removes(tmp_path: Path) -> None:
    follower = Follower(tmp_path)
    path = tmp_path / "a.jsonl"
    append(path, HEADER + fire(1)[:10])
    assert sequences(follower) == [0]
    path.write_bytes(HEADER.encode() + fire(1).encode() + fire(2).encode())  # same file, cut and grown
    assert sequences(follower) == [1, 2]


def test_rotated_parts_are_read_to_their_end_first(tmp_path: Path) -> None:
    follower = Follower(tmp_path)
    current = tmp_path / "a.jsonl"
    append(current, HEADER + fire(1))
    assert sequences(follower) == [0, 1]
    append(current, fire(2))
    current.rename(tmp_path / "a.0001.jsonl")
    append(current, fire(3))
    current.rename(tmp_path / "a.0002.jsonl")
    append(current, fire(4))
    assert sequences(follower) == [2, 3, 4]


def test_a_line_that_is_no_record_is_an_error_with_its_place(tmp_path: Path) -> None:
    append(tmp_path / "a.jsonl", HEADER + "{}\n")
    with pytest.raises(RecordError, match=r"a\.jsonl:2"):
        Follower(tmp_path).new()


def test_a_batch_at_a_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(following, "trace_pieces", lambda path, start: read_pieces(path, start, size=100))
    follower = Follower(tmp_path, batch=3)
    for node in ("a", "b"):
        append(tmp_path / f"{node}.jsonl", HEADER + "".join(map(fire, range(1, 20))))
        (tmp_path / f"{node}.jsonl").rename(tmp_path / f"{node}.0001.jsonl")
        append(tmp_path / f"{node}.jsonl", "".join(map(fire, range(20, 40))))
    batches = [sequences(follower)]
    while follower.is_behind:
        batches.append(sequences(follower))
    assert max(map(len, batches)) <= 20  # 300 bytes of two nodes
    assert sorted(each for batch in batches for each in batch) == sorted([*range(40), *range(40)])
    assert sequences(follower) == [] and not follower.is_behind


def test_a_line_longer_than_a_batch_is_read_whole(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(following, "trace_pieces", lambda path, start: read_pieces(path, start, size=10))
    follower = Follower(tmp_path, batch=2)
    append(tmp_path / "a.jsonl", HEADER + fire(1))
    assert sequences(follower) == [0] and follower.is_behind
    assert sequences(follower) == [1]
