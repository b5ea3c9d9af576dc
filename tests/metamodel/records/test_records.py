"""Records: what is written is read again; what is wrong is refused, what a crash cut is passed over."""

from __future__ import annotations

import itertools
import json
import os
import time
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel.errors import Location
from dineros.metamodel.records import (
    EVENTS,
    Cancel,
    Checkpoint,
    Drop,
    Fire,
    GiveUp,
    Header,
    Outcome,
    Publish,
    Record,
    RecordDecoder,
    RecordError,
    Signal,
    Start,
    Stop,
    StoredToken,
    Take,
    current_path,
    decode_record,
    encode_fields,
    encode_record,
    node_traces,
    part_path,
    parts_of,
    read_records,
    read_trace,
    traces_of_runs,
    write_records,
)

NAMES = st.text("ab[]._/ö", min_size=1, max_size=4)
DATA = st.dictionaries(NAMES, st.one_of(st.text(max_size=3), st.integers(), st.booleans()), max_size=2)
TOKENS = st.lists(st.builds(StoredToken, st.integers(0, 99), DATA), max_size=2)
COMMON = {"sequence": st.integers(0, 10**6), "time": st.none() | st.floats(0, 2e9), "node": st.none() | NAMES}
RECORDS = st.one_of(
    st.builds(
        Header, **COMMON, kind=st.sampled_from(["run", "witness"]), model=NAMES, loop=st.none() | st.just(3)
    ),
    st.builds(
        Start, **COMMON, marking=st.dictionaries(NAMES, TOKENS), signals=st.dictionaries(NAMES, st.booleans())
    ),
    st.builds(Checkpoint, **COMMON, responses=st.dictionaries(NAMES, st.dictionaries(NAMES, DATA))),
    st.builds(
        Fire, **COMMON, transition=NAMES, made=st.dictionaries(NAMES, TOKENS), handlers=st.lists(NAMES)
    ),
    st.builds(Signal, **COMMON, signal=NAMES, value=st.booleans(), source=st.none() | NAMES),
    st.builds(Publish, **COMMON, channel=NAMES, place=NAMES, change=st.dictionaries(NAMES, st.integers())),
    st.builds(Take, **COMMON, channel=NAMES, place=NAMES, data=DATA, token=st.integers(0, 9), message=NAMES),
    st.builds(
        Drop, **COMMON, channel=NAMES, queue=st.sampled_from(["publisher", "subscriber"]), count=st.integers()
    ),
    st.builds(Outcome, **COMMON, channel=NAMES, outcome=st.sampled_from(["succeeded", "aborted"]), data=DATA),
    st.builds(Cancel, **COMMON, channel=NAMES, client=NAMES, place=NAMES, message=st.none() | NAMES),
    st.builds(GiveUp, **COMMON, channel=NAMES, client=NAMES, place=st.none() | NAMES, message=NAMES),
    st.builds(Stop, **COMMON, reason=st.none() | NAMES),
)


@given(RECORDS)
@settings(max_examples=60)
def test_what_is_written_is_read_again(record: Record) -> None:
    line = encode_record(record)
    assert "\n" not in line
    assert decode_record(line) == record
    assert json.loads(line)["event"] == record.event


@given(st.lists(RECORDS, max_size=4), st.lists(st.integers(0, 500), max_size=8))
@settings(max_examples=50)
def test_pieces_of_any_size_give_the_same_records(records: list[Record], cuts: list[int]) -> None:
    content = "".join(f"{encode_record(record)}\n" for record in records).encode()
    decoder = RecordDecoder()
    read: list[Record] = []
    for start, end in itertools.pairwise([0, *sorted(cuts), len(content) + 500]):
        read += decoder.feed(content[start:end])
    assert decoder.close() is None
    assert read == records
    assert decoder.line == len(records)


def test_every_event_is_known_by_its_name() -> None:
    assert all(kind.event == event for event, kind in EVENTS.items())
    assert len(EVENTS) == 32


def test_more_fields_than_known_are_passed_over() -> None:
    record = decode_record('{"sequence":1,"event":"stop","reason":"end","mood":"good"}')
    assert record == Stop(sequence=1, reason="end")


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("[1]", "no JSON object"),
        ('{"event":"stop",', "no JSON: "),
        ("[" * 100_000, "no JSON: "),
        ('{"sequence":1}', "no event (events are header, "),
        ('{"sequence":1,"event":7}', "unknown event 7"),
        ('{"sequence":1,"event":"fyre"}', "unknown event 'fyre' (did you mean 'fire'?)"),
        ('{"event":"stop"}', "stop record without 'sequence'"),
        ('{"sequence":true,"event":"stop"}', "'sequence' of a stop record is a whole number, not true"),
        ('{"sequence":1,"event":"fire"}', "fire record without 'transition'"),
        (
            '{"sequence":1,"event":"fire","transition":"t","change":{"a":"1"}}',
            "'change' of a fire record is a whole",
        ),
        ('{"sequence":1,"event":"fire","transition":"t","made":{"a":[[1]]}}', "a list of tokens [id, data]"),
        (
            '{"sequence":1,"event":"fire","transition":"t","handlers":"h"}',
            "'handlers' of a fire record is a list",
        ),
        (
            '{"sequence":1,"event":"drop","channel":"c","queue":"q"}',
            "is one of publisher, dispatcher, subscriber",
        ),
        (
            '{"sequence":0,"event":"header","kind":"run","model":"m","schema":2}',
            "schema 2 is newer than this",
        ),
    ],
)
def test_what_is_no_record_is_refused(line: str, says: str) -> None:
    with pytest.raises(RecordError) as caught:
        decode_record(line, Location("a.jsonl", 3))
    assert str(caught.value).startswith("a.jsonl:3: ")
    assert says in str(caught.value)


class TestFiles:
    def write(self, path: Path, content: bytes) -> Path:
        path.write_bytes(content)
        return path

    def test_a_line_that_a_crash_cut_is_passed_over(self, tmp_path: Path) -> None:
        whole = "".join(
            f"{encode_record(Stop(sequence=number, reason='ö'))}\n" for number in range(3)
        ).encode()
        one = len(whole) // 3
        for size in range(len(whole) + 1):
            records = list(read_records(self.write(tmp_path / "a.jsonl", whole[:size])))
            # A line whose line feed only is missing is complete.
            assert len(records) == (size + 1) // one

    def test_a_wrong_line_is_named(self, tmp_path: Path) -> None:
        path = self.write(tmp_path / "a.jsonl", b'{"sequence":0,"event":"stop"}\n\n{"event":\n')
        with pytest.raises(RecordError, match=r"a\.jsonl:3: no JSON"):
            list(read_records(path))
        path = self.write(tmp_path / "a.jsonl", b'{"sequence":0,"event":"stop"}\n\xff\n')
        with pytest.raises(RecordError, match=r"a\.jsonl:2: no UTF-8"):
            list(read_records(path))

    def test_a_complete_last_line_that_is_no_record_is_refused(self, tmp_path: Path) -> None:
        path = self.write(tmp_path / "a.jsonl", b'{"sequence":0,"event":"pause"}')
        with pytest.raises(RecordError, match="unknown event 'pause'"):
            list(read_records(path))

    def test_records_know_where_they_stand(self, tmp_path: Path) -> None:
        path = tmp_path / "a.jsonl"
        write_records(path, [Stop(sequence=0), Stop(sequence=1)])
        assert [record.location for record in read_records(path)] == [Location(path, 1), Location(path, 2)]

    def test_a_missing_file(self, tmp_path: Path) -> None:
        with pytest.raises(RecordError, match="No such file"):
            list(read_records(tmp_path / "a.jsonl"))

    def test_parts_are_found_in_order(self, tmp_path: Path) -> None:
        node = "a/b.0001"  # an id that looks like a part, and like a folder
        for path in (
            current_path(tmp_path, node),
            *(part_path(tmp_path, node, number) for number in (2, 10_000, 1)),
        ):
            path.touch()
        (tmp_path / "notes.txt").touch()
        assert list(node_traces(tmp_path)) == [node]
        names = [path.name for path in parts_of(tmp_path, node)]
        assert [name.split(".")[1] for name in names] == ["0001", "0002", "10000", "jsonl"]

    def test_a_missing_part_is_noticed(self, tmp_path: Path) -> None:
        for name, sequences in (("a", (0, 1)), ("b", (3, 4))):
            write_records(tmp_path / name, [Stop(sequence=sequence) for sequence in sequences])
        with pytest.raises(RecordError, match=r"b:1: sequence 3 follows 1 \(a part"):
            list(read_trace([tmp_path / "a", tmp_path / "b"]))

    def test_files_of_a_run_are_sorted_by_what_is_in_them(self, tmp_path: Path) -> None:
        def header(name: str, node: str, sequence: int, kind: str = "run") -> Path:
            record = Header(sequence=sequence, kind=kind, model="m", node=node)  # type: ignore[arg-type]
            write_records(tmp_path / name, [record])
            return tmp_path / name

        late, early, other = header("x", "n", 7), header("y", "n", 0), header("z", "o", 0)
        assert traces_of_runs([late, other, early, late]) == {"n": [early, late], "o": [other]}
        for path, says in (
            (header("w", "n", 0, "witness"), "w:1: is a witness, not a trace of a node's run"),
            (header("double", "n", 7), "double:1: begins at record 7 of node 'n', as "),
            (self.write(tmp_path / "empty", b""), "empty: is empty"),
            (tmp_path / "none", "No such file"),
        ):
            with pytest.raises(RecordError) as caught:
                traces_of_runs([late, early, path])
            assert says in str(caught.value)


def test_the_quick_encoder_writes_the_same(tmp_path: Path) -> None:
    record = Fire(sequence=4, time=2.5, node="n", transition="t", made={"a": [StoredToken(1, {"x": "ö"})]})
    values = {"time": 2.5, "node": "n", "transition": "t", "made": {"a": [[1, {"x": "ö"}]]}}
    assert encode_fields("fire", 4, values) == encode_record(record)


@pytest.mark.long
def test_the_time_for_a_line_does_not_grow_with_its_square() -> None:
    decoder = RecordDecoder("long.jsonl")
    pieces = [b'{"event":"', *[b"x" * 1000] * 20_000, b'"}\n']  # joined one by one: 200 GB
    begin = time.process_time()
    with pytest.raises(RecordError, match="unknown event"):
        for piece in pieces:
            list(decoder.feed(piece))
    assert time.process_time() - begin < 10


def test_a_line_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.metamodel.records.coding.LINE_LIMIT", 1 << 20)
    for pieces in ([b"x" * (1 << 19)] * 3, [b"x" * (1 << 21) + b"\n"]):
        decoder = RecordDecoder("long.jsonl")
        with pytest.raises(RecordError, match=r"long\.jsonl:1: is a line of more than 1 MiB"):
            for piece in pieces:
                list(decoder.feed(piece))


def test_after_a_line_that_is_no_record_the_next_is_read() -> None:
    good = b'{"sequence":1,"event":"fire","transition":"T","change":{}}\n'
    decoder = RecordDecoder()
    with pytest.raises(RecordError):
        list(decoder.feed(b"{}\n" + good + good[:9]))
    assert [record.location for record in decoder.feed(good[9:])] == [Location(None, 2), Location(None, 3)]


def test_a_trace_is_a_plain_file(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", Path("/dev/zero")):
        with pytest.raises(RecordError, match="is not a plain file"):
            list(read_records(path))


def test_equal_records_have_equal_fields_wherever_they_were_read() -> None:
    one, other = Stop(sequence=1, reason="end"), Stop(sequence=1, reason="end", location=Location("a", 3))
    assert (one, hash(one), repr(one)) == (other, hash(other), repr(other))
    assert one not in (
        Stop(sequence=2, reason="end"),
        Signal(sequence=1, signal="s", value=True),
        (1, None, None),
    )
    assert repr(one).startswith("Stop(sequence=1, time=None, node=None, reason='end'")
