"""A diagram of all markings that is there already answers what another method would."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.known import known_of
from dineros.analysis.portfolio.methods.diagrams import DIAGRAMS, DiagramAtHand
from dineros.analysis.portfolio.satisfies import Satisfies
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import UnknownBoundError
from tests.analysis.logic.generated import atoms_of, random_ctl, random_net


def with_diagram(net: CompiledNet) -> CompiledNet:
    known_of(net).space = symbolic_state_space(net)
    return net


def counters(size: int) -> CompiledNet:
    """Counters of three that count up and down: 4 ** size markings."""
    places: dict[str, int] = {}
    rows: list[tuple[object, ...]] = []
    for number in range(size):
        up, down = f"up{number}", f"down{number}"
        places |= {up: 0, down: 3}
        rows += [(f"raise{number}", {down: 1}, {up: 1}), (f"lower{number}", {up: 1}, {down: 1})]
    return CompiledNet.build(places, rows)


def test_random_formulas() -> None:
    rng, answered = random.Random(31), 0
    for _ in range(120):
        net = random_net(rng)
        formula = random_ctl(rng, 4, atoms_of(rng, net, with_fired=False))
        expected = check_ctl(net, formula, budget=Budget(1 << 24, states=2_000, seconds=2), engine="explicit")
        try:
            with_diagram(net)
        except UnknownBoundError:
            continue
        space = known_of(net).space
        assert space is not None
        pinned = list(space.diagram.pinned)
        found = DiagramAtHand().answer(
            Satisfies(net, formula, NetNames(net)), known_of(net), Budget(seconds=20).begun()
        )
        assert space.diagram.pinned == pinned
        assert found is not None
        if expected.status != "unknown":
            answered += 1
            assert found.status == expected.status, (formula, net)
    assert answered >= 40


def test_no_formula_without_a_diagram() -> None:
    net = counters(1)
    question = Satisfies(
        net, random_ctl(random.Random(1), 3, atoms_of(random.Random(1), net, with_fired=False)), NetNames(net)
    )
    assert DiagramAtHand().answer(question, known_of(net), Budget().begun()) is None


def test_questions_about_many_markings_begin_with_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """With a diagram at hand, no method makes another state space, or stores markings one by one."""
    net = with_diagram(counters(11))

    def no_more(*_: object, **__: object) -> None:
        raise AssertionError("another state space")

    monkeypatch.setattr("dineros.analysis.symbolic.engine.symbolic_state_space", no_more)
    monkeypatch.setattr("dineros.analysis.logic.ctl.explicit_sets.ExplicitSets.__init__", no_more)
    everything = " and ".join(f"up{number} >= 3" for number in range(11))
    answer = check_ctl(net, f"AG EF ({everything})", budget=Budget(seconds=60))
    assert (answer.status, answer.by) == ("holds", DIAGRAMS)
    sums = " + ".join(f"up{number} + down{number}" for number in range(11))
    assert find_marking(net, f"{sums} >= 34", NetNames(net), is_shortest=False).status == "unreachable"
    found = find_marking(net, everything, NetNames(net), is_shortest=False)
    assert found.trace is not None
    assert min(replay(net, found.trace)[-1][::2]) == 3
