"""Property directed reachability against a plain search; its clauses are checked without the engines."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Inductive
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence.proving import Asked, certificate_of
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.models import to_model
from dineros.analysis.nets.witness import replay
from dineros.analysis.proofs import pdr
from dineros.analysis.proofs.exclusion import excluded
from dineros.analysis.proofs.induction import sums_of
from dineros.analysis.proofs.pdr import PDR, by_clauses
from dineros.analysis.proofs.state_equation import StateEquation
from tests.analysis import classic_nets as classic
from tests.analysis.logic.generated import random_net
from tests.analysis.logic.reference_ltl import reachability_graph
from tests.analysis.proofs.test_induction import conditions_of


def asked(net: CompiledNet, goal: Formula, seconds: float = 20.0) -> Outcome:
    return by_clauses(net, goal, BoundAtoms(net, goal, NetNames(net)).conditions, Budget(seconds=seconds))


def has_certificate(net: CompiledNet, goal: Formula, answer: Outcome) -> bool:
    """Whether who imports no engine agrees that a goal is unreachable."""
    question = Asked(subject_of(to_model(net, "net")), "marking", str(goal))
    return certificate_of(question, "unreachable", answer.evidence) is not None


def compared(net: CompiledNet, goal: Formula) -> str:
    """Compare with a plain search; return what was answered."""
    graph = reachability_graph(net)
    if graph is None or sums_of(net) is None:
        return "left out"
    atoms = BoundAtoms(net, goal, NetNames(net))

    def holds(marking: tuple[int, ...]) -> bool:
        return holds_on_lasso(goal, [], [Step(marking, None)], atoms.is_true)

    answer = asked(net, goal)
    assert answer.status == ("reachable" if any(map(holds, graph)) else "unreachable")
    if answer.status == "reachable":
        assert holds(tuple(replay(net, answer.trace or ())[-1]))
        return "reachable"
    assert has_certificate(net, goal, answer)
    assert isinstance(answer.evidence, Inductive)
    return "clauses" if answer.evidence.clauses else "sums"


@given(st.randoms(use_true_random=False))
def test_answers_are_those_of_a_plain_search(rng: object) -> None:
    net = random_net(rng)  # type: ignore[arg-type]
    compared(net, conditions_of(rng, net))  # type: ignore[arg-type]


def test_all_kinds_of_answers_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    import random

    monkeypatch.setattr(pdr, "MOST_QUERIES", 5)  # solvers are exchanged on the way
    rng = random.Random(7)
    seen: Counter[str] = Counter()
    for _ in range(150):
        net = random_net(rng)
        seen[compared(net, conditions_of(rng, net))] += 1
    assert min(seen["reachable"], seen["clauses"], seen["sums"]) > 3, seen


def peterson() -> CompiledNet:
    """Return two processes that say that they want, give way, and look at what the other one says."""
    places = {"turn0": 1, "turn1": 0}
    transitions: list[Transition] = []
    for one, other in ((0, 1), (1, 0)):
        places |= {f"idle{one}": 1, f"asks{one}": 0, f"waits{one}": 0, f"works{one}": 0}
        places |= {f"wants{one}": 0, f"rests{one}": 1}
        ask = Transition(
            f"ask{one}", {f"idle{one}": 1, f"rests{one}": 1}, {f"asks{one}": 1, f"wants{one}": 1}
        )
        done = Transition(
            f"done{one}", {f"works{one}": 1, f"wants{one}": 1}, {f"idle{one}": 1, f"rests{one}": 1}
        )
        transitions += [ask, done]
        for turn in (0, 1):
            taken = {f"asks{one}": 1, f"turn{turn}": 1}
            transitions.append(
                Transition(f"yield{one}from{turn}", taken, {f"waits{one}": 1, f"turn{other}": 1})
            )
        for reason in (f"rests{other}", f"turn{one}"):
            name = f"enter{one}by{reason}"
            transitions.append(Transition(name, {f"waits{one}": 1}, {f"works{one}": 1}, reads={reason: 1}))
    return CompiledNet.build(places, transitions)


def test_what_the_state_equation_does_not_exclude_is_excluded_by_clauses() -> None:
    net = peterson()
    goal = parse("works0 >= 1 & works1 >= 1", "state")
    conditions = BoundAtoms(net, goal, NetNames(net)).conditions
    assert excluded(StateEquation(net), simplified(goal), conditions, lambda: False, most_traps=0) is None
    assert compared(net, goal) == "clauses"
    assert asked(net, goal).by == PDR


def test_time_is_kept_and_many_tokens_are_left_to_others() -> None:
    net = classic.philosophers(60)
    assert asked(net, parse("deadlock", "state"), 0.0).reason == "time ran out"
    many = CompiledNet.build({"a": 100, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    assert asked(many, parse("b >= 101", "state")).status == "unknown"
