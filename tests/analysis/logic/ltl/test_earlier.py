"""Searches that continue from earlier ones give the same answers, runs and numbers of states."""

from __future__ import annotations

import random

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.ltl.earlier import EarlierSearches
from dineros.analysis.logic.ltl.verification import verify_ltl
from tests.analysis.logic.generated import atoms_of, random_ltl, random_net
from tests.analysis.logic.ltl.test_emptiness import stairs

LIMITS = Budget(1 << 26, states=3_000)


def shown(answer: Outcome) -> tuple[object, ...]:
    """Return all of an answer but its time."""
    return answer.status, answer.states, answer.stem, answer.loop


def test_more_and_more_fair_transitions() -> None:
    rng = random.Random(7)
    statuses: set[tuple[str, ...]] = set()
    for _ in range(60):
        net = random_net(rng)
        formula = random_ltl(rng, rng.randrange(2, 7), atoms_of(rng, net, with_fired=True))
        earlier, rounds = EarlierSearches(), []
        weak, strong = set[str](), set[str]()
        for name in rng.sample(net.transitions, len(net.transitions)):
            (weak if rng.random() < 0.5 else strong).add(name)
            if weak and rng.random() < 0.3:
                strong.add(weak.pop())
            names = None, sorted(weak), sorted(strong)
            answer = verify_ltl(net, formula, *names, LIMITS, earlier)
            assert shown(answer) == shown(verify_ltl(net, formula, *names, LIMITS))
            rounds.append(answer.status)
        statuses.add(tuple(dict.fromkeys(rounds)))
    assert ("violated", "holds") in statuses


def test_fewer_fair_transitions_and_other_formulas_begin_anew() -> None:
    net = stairs(5)
    earlier = EarlierSearches()
    for formula, strong in (
        ("F left == 0", ["go", "press"]),
        ("F left == 0", ["press"]),
        ("F left == 1", ["press", "go"]),
        ("F left == 1", []),
    ):
        answer = verify_ltl(net, formula, strong=strong, earlier=earlier)
        assert shown(answer) == shown(verify_ltl(net, formula, strong=strong))


def test_rejected_states_are_not_visited_again() -> None:
    net, earlier = stairs(300), EarlierSearches()
    assert verify_ltl(net, "F left == 0", strong=["go", "press"], earlier=earlier).status == "holds"
    known = earlier.stored(net, parse("F left == 0"), (), (0, 1, 2))
    assert known is not None
    product, rejected = known
    assert product.states == rejected.size > 300
