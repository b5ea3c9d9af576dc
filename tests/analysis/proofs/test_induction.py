"""Bounded model checking and k-induction against a plain search, and what their evidence says."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Inductive
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import And, Formula, Implies, Not, Or
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.proofs.induction import by_induction, sums_of
from tests.analysis import classic_nets as classic
from tests.analysis.logic.generated import atoms_of, random_net
from tests.analysis.logic.reference_ltl import reachability_graph


def conditions_of(rng: random.Random, net: CompiledNet) -> Formula:
    one, other, third = (rng.choice(atoms_of(rng, net, with_fired=False)) for _ in range(3))
    return rng.choice(
        [one, And((one, other)), Or((And((one, Not(third))), other)), Implies(one, And((other, third)))]
    )


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_answers_are_those_of_a_plain_search(seed: int) -> None:
    rng = random.Random(seed)
    seen: Counter[str] = Counter()
    for _ in range(60):
        net = random_net(rng)
        graph = reachability_graph(net)
        if graph is None or sums_of(net) is None:
            continue
        for _ in range(4):
            goal = conditions_of(rng, net)
            atoms = BoundAtoms(net, goal, NetNames(net))

            def holds(marking: tuple[int, ...], goal: Formula = goal, atoms: BoundAtoms = atoms) -> bool:
                return holds_on_lasso(goal, [], [Step(marking, None)], atoms.is_true)

            expected = any(map(holds, graph))
            answer = by_induction(net, goal, atoms.conditions, Budget(seconds=20))
            seen[answer.status] += 1
            if answer.status == "reachable":
                assert expected
                assert holds(tuple(replay(net, answer.trace or ())[-1]))
            elif answer.status == "unreachable":
                assert not expected
                assert isinstance(answer.evidence, Inductive)
    assert seen["reachable"] > 10
    assert seen["unreachable"] > 10
    assert seen["unknown"] <= sum(seen.values()) // 10


def test_two_neighbours_never_eat_together() -> None:
    net = classic.philosophers(40)
    goal = parse("eat3 >= 1 & eat4 >= 1", "state")
    answer = by_induction(net, goal, BoundAtoms(net, goal, NetNames(net)).conditions, Budget(seconds=60))
    assert answer.status == "unreachable"
    assert isinstance(answer.evidence, Inductive)
    assert answer.evidence.bounds == (1,) * len(net.places)


def test_places_with_many_tokens_are_left_to_others() -> None:
    net = CompiledNet.build({"a": 100, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    goal = parse("b >= 101", "state")
    atoms = BoundAtoms(net, goal, NetNames(net))
    assert by_induction(net, goal, atoms.conditions, Budget(seconds=5)).status == "unknown"
