"""Nets reduced for one question: the answer stays."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import Exists, Finally
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.methods.on_the_fly import holds_always
from dineros.analysis.properties.reduced import reduced
from tests.analysis.logic.generated import atoms_of, random_ltl
from tests.analysis.properties.test_answering import goal, small_nets

FEW = Budget(states=3_000)


@pytest.mark.parametrize("seed", range(4))
def test_answers_are_those_of_the_whole_net(seed: int) -> None:
    rng = random.Random(seed)
    smaller_nets = answered = 0
    for net in small_nets(rng, 15):
        for _ in range(3):
            formula = random_ltl(
                rng, rng.randrange(2, 7), atoms_of(rng, net, with_fired=False), with_next=False
            )
            smaller = reduced(net, formula, NetNames(net))
            if smaller is None:  # it asks for deadlocks
                continue
            smaller_nets += len(smaller.net.transitions) < len(net.transitions)
            answered += 1
            holds = holds_always(
                smaller.net, smaller.formula, NetNames(smaller.net), Budget(1 << 26, seconds=10)
            )
            assert holds is (verify_ltl(net, formula, budget=FEW).status == "holds"), (net, str(formula))
    assert answered >= 20 and smaller_nets >= 5


@pytest.mark.parametrize("seed", range(4))
def test_goals_are_those_of_the_whole_net(seed: int) -> None:
    rng = random.Random(seed)
    for net in small_nets(rng, 15):
        part = goal(rng, net)
        condition = part.operands[0].operands[0]
        smaller = reduced(net, condition, NetNames(net))
        if smaller is not None:
            one = check_ctl(net, Exists(Finally(condition)), budget=FEW, engine="explicit")
            other = check_ctl(smaller.net, Exists(Finally(smaller.formula)), budget=FEW, engine="explicit")
            assert one.status == other.status
