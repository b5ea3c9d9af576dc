"""Each method of deciding alone, on small random nets, against a plain search."""

from __future__ import annotations

import importlib
import pkgutil
import random
from collections.abc import Iterable
from contextlib import suppress

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import And, Formula, Not, Or
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio import methods as folder
from dineros.analysis.portfolio.answering import ALONE, stages
from dineros.analysis.portfolio.branching_time import PLANS
from dineros.analysis.portfolio.known import known_of
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.methods.diagrams import DecisionDiagrams, DiagramAtHand
from dineros.analysis.portfolio.methods.explicit_search import ExplicitSearch
from dineros.analysis.portfolio.methods.induction import Induction
from dineros.analysis.portfolio.methods.limits import NetWithLimits
from dineros.analysis.portfolio.methods.parts import PartsOfNet
from dineros.analysis.portfolio.methods.reduced_net import ReducedNet
from dineros.analysis.portfolio.methods.state_equation import StateEquationAndTraps
from dineros.analysis.portfolio.methods.walks import Walks
from dineros.analysis.portfolio.plans import COUNT, FIND, FIRE, PROVE, WITNESS
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.scheduler import SheetStage, Together, Turn, answered
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import UnknownBoundError
from tests.analysis.logic.generated import atoms_of, random_net
from tests.analysis.reference_search import distances

LIMITS = Budget(1 << 24, states=2_000, seconds=1)
LEAST = {
    DecisionDiagrams: 60,
    DiagramAtHand: 60,
    ExplicitSearch: 90,
    Induction: 20,
    NetWithLimits: 0,
    PartsOfNet: 20,
    ReducedNet: 60,
    StateEquationAndTraps: 10,
    Walks: 20,
}
"""How many of 100 questions a method answers alone, at least: a method that never answers fails."""


def methods(turns: Iterable[Turn | Together | SheetStage]) -> set[type[Method]]:
    found: set[type[Method]] = set()
    for turn in turns:
        if isinstance(turn, Together):
            for side in turn.sides:
                found |= methods(side.turns)
        else:
            found.add(type(turn.method))
    return found


def built(of: type[Method]) -> set[type[Method]]:
    """Return the methods that are no base of others."""
    below = of.__subclasses__()
    return set().union(*map(built, below)) if below else {of}


def test_every_method_stands_in_a_plan() -> None:
    for module in pkgutil.iter_modules(folder.__path__, f"{folder.__name__}."):
        importlib.import_module(module.name)
    plans = [FIND, PROVE, FIRE, WITNESS, ALONE, stages(), *PLANS.values(), *COUNT.values()]
    assert set().union(*map(methods, plans)) == built(Method)
    assert set(LEAST) == methods([*FIND, *PROVE])


@pytest.mark.long
@pytest.mark.parametrize("kind", LEAST)
def test_a_method_alone(kind: type[Method]) -> None:
    rng, known = random.Random(kind.__name__), 0
    for _ in range(100):
        net = random_net(rng)
        one, other = (rng.choice(atoms_of(rng, net, with_fired=False)) for _ in range(2))
        condition: Formula = rng.choice([one, Not(one), And((one, Not(other))), Or((one, other))])
        question = Reach(net, condition, NetNames(net))
        if kind is DiagramAtHand:
            with suppress(UnknownBoundError):
                known_of(net).space = symbolic_state_space(net, LIMITS)
        made = ReducedNet((Turn(ExplicitSearch()),)) if kind is ReducedNet else kind()
        answer = answered(question, [Turn(made)], LIMITS)
        if answer.status == "unknown":
            continue
        known += 1
        if answer.status == "reachable":
            assert answer.trace is not None
            assert question.holds(tuple(replay(net, answer.trace)[-1])), (condition, net)
        else:
            assert not any(map(question.holds, distances(net))), (condition, net)
    assert known >= LEAST[kind]
