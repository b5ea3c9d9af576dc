"""CTL verdicts against an evaluation by plain sets."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import (
    And,
    Atom,
    Constant,
    Equivalent,
    Finally,
    ForAll,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Release,
    WeakUntil,
)
from dineros.analysis.logic.verdicts.verdict import replayed
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.branching_time import check_ctl
from tests.analysis.logic.generated import atoms_of, random_ctl, random_net
from tests.analysis.logic.reference_ltl import Marking, reachability_graph

Graph = dict[Marking, list[tuple[int | None, Marking]]]


def naive(formula: Formula, graph: Graph, atoms: BoundAtoms) -> set[Marking]:
    """Markings that satisfy a formula, every operator by iterating its expansion law."""
    everything = set(graph)
    match formula:
        case Constant(value):
            return set(graph) if value else set()
        case Atom():
            return {m for m in graph if atoms.is_true(formula, Step(m, None))}
        case Not(operand):
            return everything - naive(operand, graph, atoms)
        case And(operands):
            return everything.intersection(*(naive(part, graph, atoms) for part in operands))
        case Or(operands):
            return set().union(*(naive(part, graph, atoms) for part in operands))
        case Implies(left, right):
            return everything - naive(left, graph, atoms) | naive(right, graph, atoms)
        case Equivalent(left, right):
            return everything - (naive(left, graph, atoms) ^ naive(right, graph, atoms))
    quantifier, path = formula, formula.operands[0]
    choose = all if isinstance(quantifier, ForAll) else any
    rows = [naive(part, graph, atoms) for part in path.operands]

    def step(states: set[Marking]) -> set[Marking]:
        return {m for m, row in graph.items() if choose(target in states for _, target in row)}

    def law(z: set[Marking]) -> set[Marking]:
        match path:
            case Next():
                return step(rows[0])
            case Finally():
                return rows[0] | step(z)
            case Globally():
                return rows[0] & step(z)
            case Release():
                return rows[1] & (rows[0] | step(z))
        return rows[1] | rows[0] & step(z)

    current = everything if isinstance(path, Globally | Release | WeakUntil) else set()
    while (following := law(current)) != current:
        current = following
    return current


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_verdicts_equal_the_reference(seed: int) -> None:
    rng = random.Random(seed)
    counts = {"holds": 0, "violated": 0}
    while sum(counts.values()) < 80:
        net = random_net(rng)
        graph = reachability_graph(net)
        if graph is None:
            continue
        for _ in range(4):
            formula = random_ctl(rng, rng.randrange(2, 9), atoms_of(rng, net, with_fired=False))
            atoms = BoundAtoms(net, formula, NetNames(net))
            expected = tuple(net.initial.tolist()) in naive(formula, graph, atoms)
            verdict = check_ctl(net, formula)
            assert verdict.status == ("holds" if expected else "violated"), (net, str(formula))
            assert verdict.states == len(graph)
            counts[verdict.status] += 1
    assert min(counts.values()) >= 10


@pytest.mark.parametrize("seed", range(4))
def test_witnesses_show_what_they_should(seed: int) -> None:
    rng = random.Random(seed)
    shown = 0
    while shown < 30:
        net = random_net(rng)
        graph = reachability_graph(net)
        if graph is None:
            continue
        atom, other = rng.sample(atoms_of(rng, net, with_fired=False), 2)
        atoms = BoundAtoms(net, And((atom, other)), NetNames(net))

        def true(part: Atom, step: Step, atoms: BoundAtoms = atoms) -> bool:
            return atoms.is_true(part, step)

        verdict = check_ctl(net, f"EF ({atom})")
        if verdict.status == "holds":
            first, again = replayed(net, verdict.stem, verdict.loop, must_loop=False)
            assert true(atom, again[0]) and not any(true(atom, step) for step in first)
            shown += 1
        verdict = check_ctl(net, f"EG ({atom})")
        if verdict.status == "holds":
            first, again = replayed(net, verdict.stem, verdict.loop)
            assert all(true(atom, step) for step in first + again)
            shown += 1
        verdict = check_ctl(net, f"A[({atom}) U ({other})]")
        if verdict.status == "violated":
            first, again = replayed(net, verdict.stem, verdict.loop, must_loop=False)
            assert not any(true(other, step) for step in first + again)
            shown += 1
        verdict = check_ctl(net, f"AX ({atom})")
        if verdict.status == "violated":
            _, again = replayed(net, verdict.stem, verdict.loop, must_loop=False)
            assert len(verdict.stem) <= 1 and not true(atom, again[0])


def test_an_unbounded_net_is_unknown_at_the_limit() -> None:
    net = CompiledNet.build({"p": 0}, [("t", {}, {"p": 1})])
    verdict = check_ctl(net, "AG p >= 0", budget=Budget(states=5000))
    assert verdict.status == "unknown"
    assert verdict.reason.startswith("states")


def test_a_deadlock_is_its_own_successor() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    assert check_ctl(net, "AF AG (b == 1 & deadlock & EX deadlock)").status == "holds"
    verdict = check_ctl(net, "AF AG a == 1")
    assert (verdict.status, verdict.stem, verdict.loop) == ("violated", (0,), ())
