"""Data that decides: runs of models with guards conform, and data that the model does not allow is found."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import Monitor, Verdict, conform
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, read, step
from dineros.metamodel.elements import find, transitions
from dineros.metamodel.records import (
    Checkpoint,
    Data,
    Fire,
    Record,
    Response,
    Serve,
    Start,
    StoredToken,
    read_trace,
    traces_of_runs,
)
from dineros.runtime import Firing
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.support.references.guards import GUARDS, Choice, Topic, data_states, modelled
from tests.support.references.messages import ALL

Traces = Mapping[str, Sequence[Record]]

_SOME = st.lists(st.integers(0, 3), min_size=1, max_size=2, unique=True).map(tuple)
CHOICES = st.lists(
    st.builds(
        Choice,
        takes=_SOME,
        puts=st.lists(st.integers(0, 3), min_size=1, max_size=1).map(tuple),
        reads=st.none() | st.integers(0, 3),
        guard=st.none() | st.integers(0, len(GUARDS) - 1),
        ok=st.none() | st.booleans(),
        copied=st.booleans(),
    ),
    min_size=1,
    max_size=5,
)


def run(
    model: sym.SystemModel, seed: int, steps: int = 60
) -> tuple[dict[str, list[Record]], LocalApplication]:
    """Return the traces of a run whose handlers compute any value that the model leaves open."""
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        application = LocalApplication(
            split(model), seed=seed, recorder=partial(JournalRecorder, Path(folder))
        )
        for net in application.nets.values():
            for number, transition in enumerate(net.structure.transition_names):
                assigned = {name for _, given in net.structure.decisions[number].assigns for name, _ in given}

                def compute(firing: Firing, assigned: set[str] = assigned) -> dict[str, object]:
                    ok, level = draw.choice(ALL)
                    return {name: v for name, v in (("ok", ok), ("level", level)) if name not in assigned}

                if draw.random() < 0.8:
                    net.handler(transition, name=f"h{number}")(compute)
        application.open()
        for _ in range(steps):
            application.step()
        application.close()
        traces = traces_of_runs([Path(folder)])
        return {node: list(read_trace(parts)) for node, parts in traces.items()}, application


def verdict_on(model: sym.SystemModel, traces: Traces) -> Verdict:
    return conform(model, {node: partial(iter, records) for node, records in traces.items()})


@settings(max_examples=40, deadline=None)
@given(CHOICES, st.lists(st.sampled_from(ALL), min_size=1, max_size=2), st.booleans(), st.integers(0, 2**20))
def test_runs_conform_and_stay_within_what_the_interpreter_reaches(
    chosen: list[Choice], data: list[tuple[bool, int]], topic: bool, seed: int
) -> None:
    sends = Topic(2, ((True, None), (None, 2)), 1, ((1, 1),))
    model, meanings = modelled(chosen, data, topic=sends if topic else None)
    traces, application = run(model, seed)
    verdict = verdict_on(model, traces)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])
    if not topic:
        inspection = application.nets["node"].inspect()
        state = tuple(
            sorted(
                (id, tuple(sorted((bool(t.data["ok"]), int(str(t.data["level"]))) for t in tokens)))
                for id, tokens in inspection.marking.items()
            )
        )
        assert data_states(model, meanings)[state] == set(inspection.enabled)


def spawning() -> sym.SystemModel:
    """Return a client that asks again if the answer says no, and notes what it got."""
    answer = sym.TokenType(
        id="Answer",
        fields=[
            sym.TokenField(name="ok", kind="boolean"),
            sym.TokenField(name="level", kind="integer", ros="uint8", values="LOW=0, MIDDLE=1, HIGH=2"),
        ],
    )
    model = sym.SystemModel(id="spawning", tokenType=answer, middleware="ros2")
    spawner, manager = node_net(model, "spawner"), node_net(model, "manager")
    start, ask, got = place(spawner, "Start", tokens=1), place(spawner, "Ask"), place(spawner, "Got")
    mode, done = place(spawner, "Mode", tokens=1), place(spawner, "Done")
    step(spawner, "First", [start], [ask])
    finish = step(spawner, "Finish", [got], [done])
    finish.guard, finish.assigns = (
        "Got.ok = true and Mode.level <> 'HIGH'",
        "Done.level := Got.level, Done.ok := false",
    )
    read(mode, finish)
    step(spawner, "Again", [got], [ask]).guard = "ok = false"
    page = callback(manager, "Configure", "server")
    entry, exit_ = place(page, "Entry"), place(page, "Exit")
    step(page, "Work", [entry], [exit_]).guard = "level between 0 and 1"
    model.channels.append(
        sym.ServiceChannel(
            id="Ask",
            service="/configure",
            server=sym.ServerPort(page=page, entry=entry, exit=exit_),
            clients=[sym.ClientPort(client="spawner", request=ask, response=got)],
        )
    )
    return model


def finished(seed: int = 0) -> tuple[sym.SystemModel, dict[str, list[Record]]]:
    model = spawning()
    while True:
        traces, _ = run(model, seed)
        if any(isinstance(r, Fire) and r.transition == "Finish" for r in traces["spawner"]):
            assert verdict_on(model, traces).status == "conforms"
            return model, traces
        seed += 1


def answered(records: list[Record], data: Data) -> list[Record]:
    """Let the last response carry other data."""
    last = max(number for number, record in enumerate(records) if isinstance(record, Response))
    response = records[last]
    assert isinstance(response, Response)
    return [*records[:last], replace(response, data=data), *records[last + 1 :]]


def sending(records: list[Record], place: str, data: Data, last: bool = True) -> list[Record]:
    """Let the last, or first, token that a step puts on a place of messages carry other data."""
    found = list(records)
    steps = [number for number, each in enumerate(found) if isinstance(each, Fire) and place in each.made]
    step = found[steps[-1 if last else 0]]
    assert isinstance(step, Fire)
    made = step.made | {place: [token._replace(data=data) for token in step.made[place]]}
    found[steps[-1 if last else 0]] = replace(step, made=made)
    return found


def only(verdict: Verdict) -> str:
    assert verdict.status == "violated"
    (violation,) = verdict.violations
    return str(violation)


def _answer(ok: object, level: object) -> Data:
    return {"ok": ok, "level": level}  # type: ignore[dict-item]


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (_answer(False, 1), "Finish fires: its guard does not allow the token of Got: ok=false"),
        (_answer(True, 3), "Got.level takes LOW, MIDDLE, HIGH, not 3"),
    ],
)
def test_a_step_that_a_guard_forbids(data: Data, said: str) -> None:
    model, traces = finished()
    sent = sending(traces["manager"], "Ask[1].Exit", data) if data["level"] != 3 else traces["manager"]
    assert said in only(verdict_on(model, {"manager": sent, "spawner": answered(traces["spawner"], data)}))


def test_the_guard_of_a_transition_in_a_server_page() -> None:
    model, traces = finished()
    served = next(r for r in traces["manager"] if isinstance(r, Serve))
    wrong = [replace(r, data=_answer(True, 2)) if r is served else r for r in traces["manager"]]
    sent = sending(traces["spawner"], "Ask", _answer(True, 2), last=False)
    found = only(verdict_on(model, {"spawner": sent, "manager": wrong}))
    assert "Ask[1].Work fires: its guard does not allow the token of Ask[1].Entry: level=HIGH" in found


def test_a_token_that_is_read() -> None:
    model, traces = finished()
    wrong = list(traces["spawner"])
    for number, record in enumerate(wrong):
        if isinstance(record, Start) and (mode := record.marking.get("Mode")):
            marking = {**record.marking, "Mode": [StoredToken(mode[0].id, _answer(True, 2))]}
            wrong[number] = replace(record, marking=marking)
    started = only(verdict_on(model, traces | {"spawner": wrong}))
    assert "Mode holds a token with ok=true, level=HIGH, in the model ok=false, level=LOW" in started
    find(model, "Mode", sym.Place).balloons.append(sym.BalloonToken(data='{"ok": true, "level": 2}'))
    assert "its guard allows no token of Mode, which it reads: level=HIGH" in only(
        verdict_on(model, traces | {"spawner": wrong})
    )


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("ok", "Done.ok is true, but the transition assigns false"),
        ("level", "Done.level is HIGH, but the transition assigns "),
    ],
)
def test_a_field_that_is_not_what_is_assigned(name: str, said: str) -> None:
    seed = 0
    while True:
        model, traces = finished(seed)
        finish = next(r for r in traces["spawner"] if isinstance(r, Fire) and r.transition == "Finish")
        if finish.made["Done"][0].data["level"] != 2:
            break
        seed += 1
    (token,) = finish.made["Done"]
    made = {"Done": [token._replace(data=token.data | {name: True if name == "ok" else 2})]}
    wrong = [replace(r, made=made) if r is finish else r for r in traces["spawner"]]
    assert said in only(verdict_on(model, traces | {"spawner": wrong}))
    monitor = Monitor(model)
    found = [each for records in (traces | {"spawner": wrong}).values() for each in monitor.add(records)]
    assert any(said in str(each) for each in (*found, *monitor.finish().violations))


def test_data_that_the_traces_do_not_tell_is_unknown() -> None:
    model, traces = finished()
    records = [r for r in traces["spawner"] if not isinstance(r, Checkpoint)]
    wrong = answered(records, {})
    verdict = verdict_on(model, traces | {"spawner": wrong})
    assert verdict.status == "unknown"
    assert "the data of the token that it takes from Got is unknown" in str(verdict.unknown[0])


def test_values_outside_of_ranges_are_found_where_no_guard_asks() -> None:
    """The server's step has no guard, and the model has none at all."""
    model, traces = finished()
    for each in transitions(model):
        assert isinstance(each, sym.Transition)
        each.guard = each.assigns = None
    assert verdict_on(model, traces).status == "conforms"
    wrong = sending(traces["manager"], "Ask[1].Exit", _answer(True, 3))
    assert "Ask[1].Exit.level takes LOW, MIDDLE, HIGH, not 3" in only(
        verdict_on(model, traces | {"manager": wrong})
    )


def _list_type() -> sym.TokenType:
    return sym.TokenType(
        id="Scan",
        fields=[
            sym.TokenField(name="ok", kind="boolean"),
            sym.TokenField(name="name"),
            sym.TokenField(name="count", kind="integer", ros="uint8"),
            sym.TokenField(name="pose", kind="list", elementKind="number", length=2),
            sym.TokenField(name="errors", kind="list"),
            sym.TokenField(name="limits", kind="map", elementKind="integer"),
        ],
    )


@pytest.mark.parametrize(
    ("field", "value", "said"),
    [
        ("ok", "yes", 'Done.ok takes true or false, not "yes"'),
        ("ok", 1, "Done.ok takes true or false, not 1"),
        ("name", None, "Done.name takes a text, not null"),
        ("count", True, "Done.count takes an integer, not true"),
        ("count", 300, "Done.count takes"),
        ("pose", [0.0], "Done.pose takes 2 elements, not 1"),
        ("pose", [0.0, "a"], 'Done.pose[1] takes a number, not "a"'),
        ("pose", "none", 'Done.pose takes a list, not "none"'),
        ("errors", ["late", 3], "Done.errors[1] takes a text, not 3"),
        ("limits", {"low": 1.5}, "Done.limits.low takes an integer, not 1.5"),
    ],
)
def test_values_of_the_wrong_kind_are_named(field: str, value: object, said: str) -> None:
    """No transition has a guard; what a step puts, and what is there at the start, fits its type."""
    model = sym.SystemModel(id="scanning", tokenType=_list_type())
    node = node_net(model, "node")
    step(node, "Move", [place(node, "Todo", tokens=1)], [place(node, "Done")])
    traces, _ = run(model, 0)
    assert verdict_on(model, traces).status == "conforms"
    records = sending(traces["node"], "Done", {field: value})  # type: ignore[dict-item]
    assert said in only(verdict_on(model, {"node": records}))
    held = list(traces["node"])
    for number, record in enumerate(held):
        if isinstance(record, Start):
            (token,) = record.marking["Todo"]
            wrong = token._replace(data={field: value})  # type: ignore[dict-item]
            held[number] = replace(record, marking={"Todo": [wrong]})
    assert said.replace("Done", "Todo") in only(verdict_on(model, {"node": held}))
