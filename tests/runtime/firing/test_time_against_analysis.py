"""Runs in simulated time are schedules of the time Petri net, as the analysis understands it.

The analysis shares no code with the runtime. Random nets are run, and each run is checked firing by firing.
Small nets tell a loop from a read arc, and a priority that waits from one that could fire.
"""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.nets.witness import WitnessError
from dineros.analysis.timed.nets import TimedNet, compile_timed_net
from dineros.analysis.timed.schedules import check_times, schedule
from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.build import flow, inhibit, read
from dineros.metamodel.elements import find
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal.recording import ListRecorder
from tests.analysis.timed.time_nets import RandomNet, lively_net
from tests.runtime.tiny import tiny

TOLERANCE = Fraction(1, 10**9)
RUNS = int(os.environ.get("DINEROS_EXAMPLES", "1")) * 40


class TimedRecorder(ListRecorder):
    """Notes which transition fires at which simulated time."""

    def __init__(self) -> None:
        super().__init__()
        self.application: LocalApplication | None = None
        self.fired: list[tuple[str, float]] = []

    def record(self, event: str, **fields: object) -> None:
        if event == "fire":
            assert self.application is not None
            self.fired.append((str(fields["transition"]), self.application.clock()))


def run(model: rtm.RuntimeModel, seed: int, firings: int = 60) -> list[tuple[str, float]]:
    """Return what fires when, in simulated time."""
    recorder = TimedRecorder()
    application = LocalApplication([model], seed=seed, recorder=lambda node: recorder)
    recorder.application = application
    with application:
        application.run(lambda _: len(recorder.fired) >= firings, timeout=500)
    return recorder.fired


def check(net: TimedNet, fired: list[tuple[str, float]]) -> None:
    """Check that a run is a schedule, and that its sequence has one that is exact."""
    number = {name: at for at, name in enumerate(net.untimed.transitions)}
    trace = [number[name] for name, _ in fired]
    schedule(net, trace)
    check_times(net, trace, [Fraction(time) for _, time in fired], TOLERANCE)


def model_of(random_net: RandomNet) -> rtm.RuntimeModel:
    """Return the net as the model of a node; the unit of time is a second."""
    node = sym.NodeNet(id="node", name="node")
    model = rtm.RuntimeModel(id="m.node", systemModel="m", pages=[node], node=node)
    places = [
        rtm.Place(id=f"p{at}", tokens=tokens, page=node) for at, tokens in enumerate(random_net.initial)
    ]
    for one in random_net.transitions:
        step = sym.Transition(id=one.name, page=node)
        step.interval = pn.TimeInterval(
            earliest=float(one.earliest),
            latest=None if one.latest is None else float(one.latest),
            earliestExcluded=one.is_open_below,
            latestExcluded=one.is_open_above,
        )
        for join, row in ((flow, one.take), (read, one.read), (inhibit, one.inhibitor)):
            for place, weight in row.items():
                join(places[place], step, weight=weight)
        for place, weight in one.put.items():
            flow(step, places[place], weight=weight)
    for high, low in random_net.pairs:
        find(model, f"t{high}", sym.Transition).overrides.append(find(model, f"t{low}", sym.Transition))
    return model


@pytest.mark.long
@pytest.mark.parametrize("has_priorities", [False, True])
def test_runs_of_random_nets_are_schedules(has_priorities: bool) -> None:
    timed = fired_in_all = 0
    for seed in range(RUNS):
        random_net = lively_net(Random(seed), has_priorities)
        model = model_of(random_net)
        fired = run(model, seed)
        check(compile_timed_net(model), fired)
        fired_in_all += len(fired)
        timed += any(time > 0 for _, time in fired)
    assert timed > RUNS / 2 and fired_in_all > 10 * RUNS


def watched(join: str) -> rtm.RuntimeModel:
    """`watch` waits 5 s for a token that `look` reads or takes and puts back every 2 s."""
    arcs = {"read": "?p turn -> turn", "loop": "p turn -> p turn"}[join]
    model = tiny({"look": arcs, "watch": "p -> done"}, {"p": 1, "turn": 1})
    find(model, "look", pn.Transition).interval = pn.TimeInterval(earliest=2.0, latest=2.0)
    find(model, "watch", pn.Transition).interval = pn.TimeInterval(earliest=5.0, latest=5.0)
    return model


def test_a_read_arc_does_not_disturb_a_clock_and_a_loop_does() -> None:
    reading, looping = (run(watched(join), 1, 8) for join in ("read", "loop"))
    check(compile_timed_net(watched("read")), reading)
    check(compile_timed_net(watched("loop")), looping)
    assert ("watch", 5.0) in reading
    assert [name for name, _ in looping] == ["look"] * 8
    # The runs are told apart: each is wrong for the other net.
    for join, fired in (("loop", reading), ("read", looping)):
        with pytest.raises(WitnessError):
            check(compile_timed_net(watched(join)), fired)


def test_a_token_that_is_taken_and_put_by_another_restarts_a_clock() -> None:
    # `swap` takes both tokens and puts both: `watch` is enabled before and after, but not between.
    model = tiny({"swap": "p q -> p r", "watch": "p -> done"}, {"p": 1, "q": 1})
    find(model, "swap", pn.Transition).interval = pn.TimeInterval(earliest=3.0, latest=3.0)
    find(model, "watch", pn.Transition).interval = pn.TimeInterval(earliest=4.0, latest=4.0)
    fired = run(model, 1)
    assert fired == [("swap", 3.0), ("watch", 7.0)]
    check(compile_timed_net(model), fired)


def test_a_priority_counts_when_the_higher_transition_could_fire() -> None:
    model = tiny({"high": "a -> b", "low": "c -> d"}, {"a": 1, "c": 1})
    high, low = find(model, "high", sym.Transition), find(model, "low", sym.Transition)
    high.overrides.append(low)
    high.interval = pn.TimeInterval(earliest=5.0, latest=5.0)
    low.interval = pn.TimeInterval(earliest=1.0, latest=1.0)
    fired = run(model, 1)
    assert fired == [("low", 1.0), ("high", 5.0)]
    check(compile_timed_net(model), fired)


def test_moves_that_must_happen_at_once_take_no_time() -> None:
    model = tiny({f"t{at}": f"p{at} -> p{at + 1}" for at in range(20)}, {"p0": 1})
    for at in range(20):
        find(model, f"t{at}", pn.Transition).interval = pn.TimeInterval(latest=0.0)
    assert {time for _, time in run(model, 1)} == {0.0}


def test_time_goes_on_although_firings_in_no_time_never_end(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.runtime.application.simulation.MOST_AT_ONCE", 50)
    model = tiny({"spin": "p -> p"}, {"p": 1})
    find(model, "spin", pn.Transition).interval = pn.TimeInterval(latest=0.0)
    with LocalApplication([model], seed=1) as application:
        assert application.run(lambda _: False, timeout=0.05) == "timeout"


def test_bounds_that_are_left_out_are_not_met() -> None:
    model = tiny({"go": "a -> b"}, {"a": 1})
    find(model, "go", pn.Transition).interval = pn.TimeInterval(
        earliest=1.0, latest=1.0001, earliestExcluded=True, latestExcluded=True
    )
    times = {time for seed in range(20) for _, time in run(model, seed)}
    assert len(times) > 10 and all(1.0 < time < 1.0001 for time in times)
