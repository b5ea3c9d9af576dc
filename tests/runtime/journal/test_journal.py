"""The journal: any point of it gives the node's state; crashes at any byte, rotation, large data, misuse."""

from __future__ import annotations

import dataclasses
import json
import os
import random
import re
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from dineros.metamodel.records import (
    EVENTS,
    Checkpoint,
    Fire,
    Header,
    RecordError,
    Start,
    current_path,
    parts_of,
    read_records,
    read_trace,
)
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import (
    JournalError,
    JournalRecorder,
    JournalState,
    rebuild,
    rebuild_at,
    resume_journal,
)
from dineros.runtime.journal.outlined import Outlined
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import Ports
from dineros.transformations.flattening.split import split
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.small_systems import small_system_models
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


class Witnessed(JournalRecorder):
    """Notes the node's own word on its state after every record."""

    def __init__(self, folder: Path, node: str, states: dict[int, str], **options: Any) -> None:
        super().__init__(folder, node, **options)
        self._states = states
        self._own: Callable[[], SavedState]

    def open(self, ports: Ports, checkpoint: Callable[[], SavedState]) -> None:
        self._own = checkpoint
        super().open(ports, checkpoint)

    def record(self, event: str, **fields: object) -> None:
        super().record(event, **fields)
        self._states[self._sequence - 1] = plain(self._own())


def plain(state: Any) -> str:
    """Return a state as text that equals that of an equal state.

    How old a request is, is left out: a record tells the time of day, not the simulated one.
    """
    requests = {
        client: [{**each, "age": None} for each in found] for client, found in state["requests"].items()
    }
    return json.dumps({**state, "requests": requests}, sort_keys=True)


def play(
    model: sym.SystemModel, folder: Path, seed: int, steps: int, **options: Any
) -> dict[str, dict[int, str]]:
    """Run a model with its signals set at random; return each node's states by sequence."""
    states: dict[str, dict[int, str]] = {}

    def recorder(node: str) -> JournalRecorder:
        return Witnessed(folder, node, states.setdefault(node, {}), **options)

    application = LocalApplication(split(model), seed=seed, recorder=recorder)
    application.open()
    draw = random.Random(seed)
    signals = [(net, name) for net in application.nets.values() for name in net.structure.signals]
    for _ in range(steps):
        if signals and draw.random() < 0.2:
            net, name = draw.choice(signals)
            net.signal(name).set(draw.random() < 0.5)
        application.step()
    application.close()
    return states


def same_everywhere(folder: Path, states: dict[str, dict[int, str]]) -> int:
    """Compare rebuilt states with the nodes' own; return how many were compared."""
    compared = 0
    for node, own in states.items():
        state, outlined = JournalState(), Outlined(folder, node)
        for record in read_trace(parts_of(folder, node)):
            state.apply(outlined.inline(record))
            if record.sequence in own and not isinstance(record, (Header, Checkpoint)):
                assert plain(state.checkpoint()) == own[record.sequence], record
                compared += 1
    return compared


@given(st.one_of(small_system_models(), chatty_systems(), calling_systems()), st.integers(0, 2**20))
@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_the_state_can_be_rebuilt_at_any_point(model: sym.SystemModel, seed: int) -> None:
    import tempfile

    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        states = play(model, folder, seed, 150, part_bytes=3000, kept_parts=None)
        assert same_everywhere(folder, states) >= len(states)


def test_the_case_study_can_be_rebuilt_at_any_point(tmp_path: Path) -> None:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    states = play(model, tmp_path, 3, 3000, part_bytes=5_000, data_bytes=20, kept_parts=None)
    assert len(parts_of(tmp_path, "executor")) > 3
    assert same_everywhere(tmp_path, states) > 300
    # Each part is enough for the points in it.
    own = states["executor"]
    for sequence in list(own)[:: len(own) // 25]:
        assert plain(rebuild_at(tmp_path, "executor", sequence).checkpoint()) == own[sequence]
    with pytest.raises(DinerosError, match=r"no record 999999 of node 'executor'"):
        rebuild_at(tmp_path, "executor", 999_999)
    with pytest.raises(DinerosError, match=r"no trace of node 'nobody'"):
        rebuild_at(tmp_path, "nobody")


class TestCrash:
    @pytest.mark.long
    def test_a_journal_cut_at_any_byte_goes_on(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr("dineros.runtime.journal.recorder.os.fsync", lambda _: None)  # slow, many times
        states = play(talker(), tmp_path / "whole", 1, 60)["talker"]
        whole = current_path(tmp_path / "whole", "talker").read_bytes()
        lines = whole.splitlines(keepends=True)
        begin = sum(map(len, lines[:2]))  # header and checkpoint are there before the file is
        for size in range(begin, len(whole) + 1):
            folder = tmp_path / "cut"
            folder.mkdir()
            path = current_path(folder, "talker")
            path.write_bytes(whole[:size])
            complete = (
                whole[: size + 1].count(b"\n")
                if whole[size : size + 1] == b"\n"
                else whole[:size].count(b"\n")
            )
            recorder, checkpoint = resume_journal(folder, "talker")
            assert path.read_bytes() == b"".join(lines[:complete])
            if complete > 2:
                assert plain(checkpoint) == states[complete - 1]
            recorder.close()
            shutil.rmtree(folder)

    def test_between_the_renames_of_a_rotation(self, tmp_path: Path) -> None:
        states = play(talker(), tmp_path, 1, 60)["talker"]
        path = current_path(tmp_path, "talker")
        path.rename(tmp_path / "talker.0001.jsonl")
        (tmp_path / ".talker.jsonl.tmp").write_text("half a hea")
        recorder, checkpoint = resume_journal(tmp_path, "talker")
        recorder.close()
        assert plain(checkpoint) == states[max(states)]
        assert {found.name for found in tmp_path.iterdir()} - {".journals"} == {
            "talker.jsonl",
            "listener.jsonl",
        }

    def test_a_journal_that_is_not_there_begins(self, tmp_path: Path) -> None:
        recorder, checkpoint = resume_journal(tmp_path / "new", "talker")
        assert checkpoint is None
        recorder.close()

    def test_a_spoilt_line_is_named(self, tmp_path: Path) -> None:
        play(talker(), tmp_path, 1, 60)
        path = current_path(tmp_path, "talker")
        lines = path.read_text("utf-8").splitlines(keepends=True)
        path.write_text("".join([*lines[:3], "what?\n", *lines[4:]]), "utf-8")
        with pytest.raises(RecordError, match=r"talker\.jsonl:4: no JSON"):
            resume_journal(tmp_path, "talker")
        path.write_text("".join([*lines[:4], *lines[5:]]), "utf-8")
        with pytest.raises(DinerosError):
            list(read_trace(path))


def resumed(folder: Path, model: sym.SystemModel, seed: int) -> LocalApplication:
    recorders, checkpoints = {}, {}
    for runtime_model in split(model):
        node = runtime_model.node.id
        recorders[node], checkpoint = resume_journal(folder, node, part_bytes=5000, kept_parts=None)
        if checkpoint is not None:
            checkpoints[node] = checkpoint
    return LocalApplication(split(model), seed=seed, recorder=recorders.__getitem__, resume=checkpoints)


def test_a_node_goes_on_where_it_was(tmp_path: Path) -> None:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    play(model, tmp_path, 5, 400)
    for seed in range(3):
        before = {
            node.id: rebuild_at(tmp_path, node.id) for node in model.pages if isinstance(node, sym.NodeNet)
        }
        application = resumed(tmp_path, model, seed)
        application.open()
        for id, node in application.nodes.items():
            assert plain(node.checkpoint()) == plain(before[id].checkpoint())
        for _ in range(100):
            application.step()
        application.close()
    starts = [record for record in read_trace(parts_of(tmp_path, "executor")) if type(record) is Start]
    assert [start.resumed for start in starts] == [False, True, True, True]


class TestMisuse:
    def test_a_folder_with_a_trace_is_not_overwritten(self, tmp_path: Path) -> None:
        play(talker(), tmp_path, 1, 10)
        before = current_path(tmp_path, "talker").read_bytes()
        with pytest.raises(JournalError, match=r"has a trace of node 'talker' already \(resume it"):
            JournalRecorder(tmp_path, "talker")
        assert current_path(tmp_path, "talker").read_bytes() == before

    def test_two_writers(self, tmp_path: Path) -> None:
        application = LocalApplication(
            split(talker()), seed=1, recorder=lambda node: JournalRecorder(tmp_path, node)
        )
        application.open()
        with pytest.raises(JournalError, match="is being written by another process"):
            resume_journal(tmp_path, "talker")
        application.close()
        resume_journal(tmp_path, "talker")[0].close()

    def test_another_model(self, tmp_path: Path) -> None:
        play(talker(), tmp_path, 1, 10)
        other = talker()
        other.id = "farewell"
        with pytest.raises(JournalError, match="is of model 'greeting', not of 'farewell'"):
            resumed(tmp_path, other, 1).open()

    def test_a_folder_that_cannot_be_made(self, tmp_path: Path) -> None:
        (tmp_path / "file").touch()
        with pytest.raises(JournalError, match="cannot be written"):
            JournalRecorder(tmp_path / "file" / "folder", "talker")

    def test_a_full_disk(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        application = LocalApplication(
            split(talker()), seed=1, recorder=lambda node: JournalRecorder(tmp_path, node)
        )
        application.open()

        def full(file: int, content: bytes) -> int:
            raise OSError(28, "No space left on device")

        monkeypatch.setattr("dineros.runtime.journal.recorder.os.write", full)
        with pytest.raises(JournalError, match=r"talker\.jsonl: cannot be written: No space left on device"):
            application.nets["talker"].signal("Button").set(True)
            for _ in range(20):
                application.step()
        monkeypatch.undo()
        for node in application.nodes.values():
            node.close()


def test_a_write_that_is_cut_short_is_completed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write = os.write
    monkeypatch.setattr(
        "dineros.runtime.journal.recorder.os.write", lambda file, content: write(file, content[:50])
    )
    states = play(talker(), tmp_path, 1, 60)
    assert same_everywhere(tmp_path, states) > 5


class TestLargeData:
    def model(self) -> sym.SystemModel:
        model = talker()
        fields = [
            sym.TokenField(name="text"),
            sym.TokenField(name="words", kind="list"),
            sym.TokenField(name="short"),
        ]
        model.tokenType = sym.TokenType(id="Word", name="Word", fields=fields)
        words = next(place for page in model.pages for place in page.objects if place.id == "Words")
        data = {"text": "long " * 1000, "words": ["word"] * 2000, "short": "x"}
        words.balloons.append(sym.BalloonToken(data=json.dumps(data)))  # type: ignore[attr-defined]
        return model

    def test_large_values_are_stored_once_beside(self, tmp_path: Path) -> None:
        states = play(self.model(), tmp_path, 1, 100)
        for node in states:
            lines = current_path(tmp_path, node).read_bytes().splitlines()
            assert max(map(len, lines)) < 4000
        stored = [path.name for path in (tmp_path / "talker.data").iterdir()]
        assert len(stored) == 2
        fire = next(
            record for record in read_records(current_path(tmp_path, "talker")) if isinstance(record, Fire)
        )
        (token,) = fire.made["Said"]
        assert token.data["short"] == "x"
        assert token.data["text"]["$bytes"] == 5002  # type: ignore[index, call-overload]
        assert token.data["text"]["$start"].startswith('"long long')  # type: ignore[index, call-overload, union-attr]

    @pytest.mark.parametrize(
        "event", [event for event, kind in EVENTS.items() if "data" in kind.__dataclass_fields__]
    )
    def test_they_are_there_again_in_each_record_with_data(self, tmp_path: Path, event: str) -> None:
        outlined = Outlined(tmp_path, "node", limit=10)
        values = outlined.outline({"data": {"text": "long " * 10, "short": "x"}})
        assert set(values["data"]["text"]) == {"$stored", "$bytes", "$start"}
        required = {
            field.name: "x"
            for field in dataclasses.fields(EVENTS[event])
            if field.default is dataclasses.MISSING and field.default_factory is dataclasses.MISSING
        }
        record = EVENTS[event](**{**required, "sequence": 1, **values})
        assert outlined.inline(record).data == {"text": "long " * 10, "short": "x"}  # type: ignore[attr-defined]

    def test_they_are_there_again_when_a_node_goes_on(self, tmp_path: Path) -> None:
        states = play(self.model(), tmp_path, 1, 100)
        for node, own in states.items():
            assert plain(rebuild_at(tmp_path, node).checkpoint()) == own[max(own)]
        path = next((tmp_path / "listener.data").iterdir())
        path.write_text('"other"')
        with pytest.raises(DinerosError, match="differs from what the trace stored"):
            rebuild_at(tmp_path, "listener")
        path.unlink()
        with pytest.raises(DinerosError, match="cannot be read: No such file"):
            rebuild_at(tmp_path, "listener")


def test_what_cannot_follow_is_refused() -> None:
    with pytest.raises(DinerosError, match="token 7 is not in place 'a'"):
        rebuild([Start(sequence=0), Fire(sequence=1, transition="t", taken={"a": [7]})])


def _large_state(places: dict[str, int], size: int) -> SavedState:
    """Return the state of a node with so many tokens in places, each with a text of a size."""
    data = {"text": "x" * size}
    state = JournalState().checkpoint()
    state["marking"] = {place: [[id, data] for id in range(count)] for place, count in places.items()}
    state["next_token"] = max(places.values())
    return state


class _Ports:
    model = "m"


def test_a_large_marking_is_written_rarely(tmp_path: Path) -> None:
    """A checkpoint larger than a part does not begin a new part with every record, and can be read back."""
    state = _large_state({"Many": 20_000, "Few": 3}, 300)
    recorder = JournalRecorder(tmp_path, "a", part_bytes=100_000)
    recorder.open(_Ports(), lambda: state)  # type: ignore[arg-type]
    written = sum(path.stat().st_size for path in tmp_path.rglob("*.js*"))
    assert written > 6_000_000
    for number in range(1000):
        recorder.record("signal", signal="S", value=bool(number % 2), source="outside")
    after = sum(path.stat().st_size for path in tmp_path.rglob("*.js*"))
    assert after - written < 200_000
    assert len(parts_of(tmp_path, "a")) == 1
    while len(parts_of(tmp_path, "a")) < 3:
        recorder.record("signal", signal="S", value=True, source="x" * 10_000)
    # What has not changed is not written again.
    assert len(list((tmp_path / "a.data").iterdir())) == 1
    assert max(len(line) for line in current_path(tmp_path, "a").read_bytes().split(b"\n")) < 400_000
    recorder.close()
    resumed, again = resume_journal(tmp_path, "a")
    resumed.close()
    assert again is not None and again["marking"] == state["marking"]


def test_a_state_that_is_too_large_for_a_line_lets_the_file_grow(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A journal never has a line that its node would refuse later."""
    monkeypatch.setattr("dineros.runtime.journal.recorder.LINE_LIMIT", 20_000)
    state = _large_state({"Many": 10}, 10)
    recorder = JournalRecorder(tmp_path, "a", part_bytes=5_000)
    recorder.open(_Ports(), lambda: state)  # type: ignore[arg-type]
    state["marking"] = _large_state({"Many": 10_000}, 10)["marking"]
    for _ in range(200):
        recorder.record("signal", signal="S", value=True, source="outside")
    assert len(parts_of(tmp_path, "a")) == 1
    state["marking"] = {}
    for _ in range(200):
        recorder.record("signal", signal="S", value=True, source="outside")
    assert len(parts_of(tmp_path, "a")) > 1
    recorder.close()
    resumed, again = resume_journal(tmp_path, "a")
    resumed.close()
    assert again is not None and again["marking"] == {}


def test_data_of_places_that_is_missing_is_refused(tmp_path: Path) -> None:
    state = _large_state({"Many": 20_000}, 300)
    recorder = JournalRecorder(tmp_path, "a")
    recorder.open(_Ports(), lambda: state)  # type: ignore[arg-type]
    recorder.close()
    (stored,) = (tmp_path / "a.data").iterdir()
    stored.write_text("[]")
    with pytest.raises(DinerosError, match="differs from what the trace stored"):
        rebuild_at(tmp_path, "a")
    line = current_path(tmp_path, "a").read_text().replace('"$stored"', '"$gone"')
    current_path(tmp_path, "a").write_text(re.sub(r',"crc":"[0-9a-f]*"', "", line))
    with pytest.raises(DinerosError, match="data of the tokens of 'Many' is not stored"):
        rebuild_at(tmp_path, "a")
