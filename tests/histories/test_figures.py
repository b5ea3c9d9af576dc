"""The figures of the design: an interpreter, and the flattened net by both engines, count the same."""

from __future__ import annotations

import pytest

from case_study.build import build
from dineros.analysis.model.subject import subject_of
from dineros.analysis.questions.state_space import state_space
from dineros.analysis.reductions import reduce
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.support.references.histories import Interpreter


def periodic(depth: int) -> sym.SystemModel:
    """Return what may publish at any time, and a logger."""
    model = sym.SystemModel(id="periodic", middleware="ros2")
    timer, logger = sym.NodeNet(id="timer", net=model), sym.NodeNet(id="logger", net=model)
    said = sym.Place(id="Said", page=timer)
    flow(sym.Transition(id="Tick", page=timer), said)
    page = sym.CallbackPage(id="OnSaid", page=logger)
    heard = sym.Place(id="Heard", page=page)
    flow(heard, sym.Transition(id="Log", page=page))
    model.channels.append(
        sym.TopicChannel(
            id="talk",
            topic="/talk",
            publishers=[sym.PublisherPort(place=said, limit=depth)],
            subscribers=[sym.SubscriberPort(place=heard, limit=depth)],
        )
    )
    return model


def case_study(objects: tuple[int, int, int], best_effort: bool = False) -> sym.SystemModel:
    model = build()
    model.middleware = "ros2"
    for colour, tokens in zip(("Red", "Blue", "Green"), objects, strict=True):
        find(model, f"{colour}Objects", pn.Place).tokens = tokens
    if best_effort:
        find(model, "LeftCellObjects", sym.TopicChannel).qos = sym.QualityOfService(reliability="bestEffort")
    return model


PERIODIC = {1: (64, 176), 2: (144, 420), 10: (1936, 6116)}
CASE_STUDY: list[tuple[tuple[int, int, int], SignalVariant, int, int | None]] = [
    ((1, 0, 0), "none", 400, 882),
    ((1, 0, 0), "input-enabled", 4_580, 13_293),
    ((1, 0, 0), "io-enabled", 27_840, 105_808),
    ((1, 0, 0), "fully-enabled", 204_800, 2_246_656),
    ((1, 1, 0), "none", 8_184, 25_759),
    ((1, 1, 0), "input-enabled", 132_602, 524_733),
]
BEST_EFFORT: dict[SignalVariant, int] = {"none": 408, "input-enabled": 4_601, "io-enabled": 27_904}


@pytest.mark.parametrize("depth", PERIODIC)
def test_the_interpreter_of_a_periodic_publisher(depth: int) -> None:
    assert Interpreter(periodic(depth)).count() == (*PERIODIC[depth], 0)


@pytest.mark.long
@pytest.mark.parametrize(("objects", "signals", "states", "arcs"), CASE_STUDY[:3])
def test_the_interpreter_of_the_case_study(
    objects: tuple[int, int, int], signals: SignalVariant, states: int, arcs: int
) -> None:
    assert Interpreter(case_study(objects), signals).count() == (states, arcs, 0)


@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize("depth", PERIODIC)
def test_the_net_of_a_periodic_publisher(depth: int, overflow: OverflowVariant) -> None:
    net = subject_of(periodic(depth), "none", overflow).net
    explicit, symbolic = state_space(net, "explicit"), state_space(net, "symbolic")
    assert (explicit.states, explicit.arcs, explicit.deadlocks) == (*PERIODIC[depth], 0)
    assert (symbolic.states, symbolic.deadlocks) == (PERIODIC[depth][0], 0)


@pytest.mark.long
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
@pytest.mark.parametrize(("objects", "signals", "states", "arcs"), CASE_STUDY)
def test_the_nets_of_the_case_study(
    objects: tuple[int, int, int], signals: SignalVariant, states: int, arcs: int, overflow: OverflowVariant
) -> None:
    net = subject_of(case_study(objects), signals, overflow).net
    explicit, symbolic = state_space(net, "explicit"), state_space(net, "symbolic")
    assert (explicit.states, explicit.arcs, explicit.deadlocks) == (states, arcs, 0)
    assert symbolic.states == states
    reduction = reduce(net, {"state_space_size"})
    smaller = state_space(reduction.net, "symbolic")
    assert smaller.states is not None
    assert smaller.states * reduction.count_factor == states


@pytest.mark.long
@pytest.mark.parametrize("signals", BEST_EFFORT)
def test_best_effort(signals: SignalVariant) -> None:
    model = case_study((1, 0, 0), best_effort=True)
    assert Interpreter(model, signals).count()[0] == BEST_EFFORT[signals]
    for overflow in ("weighted", "inhibitor"):
        assert state_space(subject_of(model, signals, overflow).net).states == BEST_EFFORT[signals]


@pytest.mark.long
def test_the_case_study_with_ten_objects_of_each_colour() -> None:
    """Every clause can be true, so that each of the nine signals in use doubles the markings."""
    none, fully = (
        state_space(subject_of(case_study((10, 10, 10)), signals).net, "symbolic").states
        for signals in ("none", "fully-enabled")
    )
    assert none == 7_410_012_008_342_497_312
    assert fully == none * 2**9
