"""CTL by decision diagrams: the same verdicts as the explicit engine, and runs that show them."""

from __future__ import annotations

import random

import pytest

from case_study.build import build
from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.logic.ctl.explicit_sets import ExplicitSets
from dineros.analysis.logic.ctl.fixpoints import satisfying
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.graphs.stored import StateGraph
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import Exists, Globally, Not
from dineros.analysis.logic.verdicts.verdict import replayed
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.metamodel.settings import apply
from dineros.transformations.rules.phases import SignalVariant
from tests.analysis import classic_nets as classic
from tests.analysis.logic.generated import atoms_of, random_ctl, random_net

SMALL = Budget(memory_bytes=1 << 24)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_verdicts_equal_those_of_the_explicit_engine(seed: int) -> None:
    rng = random.Random(seed)
    counts = {"holds": 0, "violated": 0}
    while sum(counts.values()) < 40:
        net = random_net(rng)
        for _ in range(3):
            formula = random_ctl(rng, rng.randrange(2, 9), atoms_of(rng, net, with_fired=False))
            expected = check_ctl(net, formula, budget=Budget(states=3_000), engine="explicit")
            if expected.status == "unknown":
                break
            verdict = check_ctl(net, formula, budget=SMALL, engine="symbolic")
            assert verdict.status == expected.status, (net, str(formula))
            assert verdict.states == expected.states
            # Both show it or neither does; runs may differ, and each was replayed before it was returned.
            assert bool(verdict.reason) == bool(expected.reason)
            replayed(net, verdict.stem, verdict.loop, must_loop=False)
            counts[verdict.status] += 1
    assert min(counts.values()) >= 5


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_runs_that_last_are_those_of_the_stored_graph(seed: int) -> None:
    rng = random.Random(seed)
    partial = 0
    while partial < 15:
        net = random_net(rng)
        formula = rng.choice(atoms_of(rng, net, with_fired=False))
        tree = Exists(Globally(rng.choice([formula, Not(formula)])))
        atoms = BoundAtoms(net, tree, NetNames(net))
        graph = StateGraph(net, atoms.conditions, Budget(states=3_000).begun())
        try:
            graph.explore()
        except BudgetExceededError:
            continue
        lasting = satisfying(tree, ExplicitSets(graph))[tree]
        space = symbolic_state_space(net, Budget(1 << 24))
        sets = SymbolicSets(space, atoms)
        found = satisfying(tree, sets)[tree]
        assert [sets.contains(found, graph.product.marking(n)) for n in range(graph.size)] == lasting.tolist()
        partial += 0 < lasting.sum() < graph.size


def test_far_runs_need_no_layers(monkeypatch: pytest.MonkeyPatch) -> None:
    def layers(*_: object) -> None:
        raise AssertionError("layers were made")

    monkeypatch.setattr(SymbolicSets, "_route", layers)
    model = build()
    for setting in sorting(2):
        apply(model, setting)
    subject = subject_of(model, "none")
    verdict = check_ctl(subject.net, "EF (Shown >= 6)", subject.names, engine="symbolic")
    assert verdict.status == "holds"
    assert 200 < len(verdict.stem) < 400


def test_runs_without_steps_that_cannot_be_undone(monkeypatch: pytest.MonkeyPatch) -> None:
    net = classic.philosophers(6)
    formulas = ("EF deadlock", f'EG !enabled("{net.transitions[0]}")', f'EF enabled("{net.transitions[-1]}")')
    climbed = [check_ctl(net, formula, engine="symbolic") for formula in formulas]
    monkeypatch.setattr("dineros.analysis.logic.ctl.climbing.MOST_MARKINGS", 0)
    for formula, other in zip(formulas, climbed, strict=True):
        verdict = check_ctl(net, formula, engine="symbolic")
        assert (verdict.status, bool(verdict.stem)) == (other.status, bool(other.stem))
        replayed(net, verdict.stem, verdict.loop, must_loop=False)


@pytest.mark.parametrize(
    ("net", "formulas"),
    [
        (classic.philosophers(4), ["AG EF enabled({0})", "EF deadlock", "EG !deadlock", "AF deadlock"]),
        (classic.kanban(1), ["AG EF enabled({0})", "AG !deadlock", "EG enabled({0})"]),
        (classic.round_robin_mutex(4), ["AG EF enabled({0})", "AF enabled({0})", "EX EX enabled({0})"]),
    ],
)  # fmt: skip
def test_classic_nets(net: CompiledNet, formulas: list[str]) -> None:
    for transition in (net.transitions[0], net.transitions[-1]):
        for text in formulas:
            formula = text.format(f'"{transition}"')
            explicit, symbolic = (check_ctl(net, formula, engine=kind) for kind in ("explicit", "symbolic"))
            assert (explicit.status, explicit.states) == (symbolic.status, symbolic.states), formula


def sorting(objects: int) -> list[str]:
    return [f"{color}Objects.tokens={objects}" for color in ("Red", "Blue", "Green")]


@pytest.mark.long
@pytest.mark.parametrize(("objects", "signals"), [(2, "none"), (1, "input-enabled"), (1, "fully-enabled")])
def test_every_state_can_still_finish_all_objects(objects: int, signals: SignalVariant) -> None:
    model = build()
    for setting in sorting(objects):
        apply(model, setting)
    subject = subject_of(model, signals)
    for wanted, status in ((3 * objects, "holds"), (3 * objects + 1, "violated")):
        verdict = check_ctl(
            subject.net, f"AG EF (Shown >= {wanted})", subject.names, Budget(1 << 30), engine="symbolic"
        )
        assert verdict.status == status


@pytest.mark.long
def test_runs_of_the_case_study_are_as_short_as_explicit_ones() -> None:
    subject = subject_of(build(), "none")
    for formula, stem in (("EF (Shown >= 1)", 50), ("AG (PickReqL >= 1 -> AF PickResL >= 1)", 40)):
        symbolic, explicit = (
            check_ctl(subject.net, formula, subject.names, engine=kind) for kind in ("symbolic", "explicit")
        )
        assert symbolic.status == explicit.status
        assert len(explicit.stem) <= len(symbolic.stem) <= 2 * len(explicit.stem) <= 2 * stem


def test_auto_takes_diagrams_for_many_markings() -> None:
    verdict = check_ctl(classic.philosophers(20), "AG EF deadlock")
    assert (verdict.status, verdict.states) == ("holds", 3_486_784_401)


def test_a_firing_that_changes_nothing_is_a_step() -> None:
    net = CompiledNet.build(
        {"a": 1, "b": 0}, [Transition("stay", {"a": 1}, {"a": 1}), ("t", {"a": 1}, {"b": 1})]
    )
    for engine in ("explicit", "symbolic"):
        verdict = check_ctl(net, "EG a == 1", engine=engine)
        assert (verdict.status, verdict.loop) == ("holds", (0,))
        assert check_ctl(net, "EX a == 1", engine=engine).status == "holds"


def test_too_little_memory_is_unknown() -> None:
    net = subject_of(build(), "io-enabled").net
    verdict = check_ctl(net, "AG !deadlock", budget=Budget(memory_bytes=1 << 15), engine="symbolic")
    assert verdict.status == "unknown"
    assert verdict.reason.startswith("memory")


@pytest.mark.parametrize("formula", ["AG EF (a + c >= 9)", "EF EG (b + d >= 5)", "AF (a + d <= 4)"])
def test_operations_that_find_the_memory_full_go_on_where_they_were(formula: str) -> None:
    steps = [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1}), ("v", {"c": 1}, {"d": 1})]
    net = CompiledNet.build({"a": 40, "b": 0, "c": 0, "d": 0}, steps)
    expected = check_ctl(net, formula, engine="explicit").status
    found = [
        check_ctl(net, formula, budget=Budget(memory_bytes=memory), engine="symbolic").status
        for memory in (30_000, 60_000, 90_000, 120_000, 240_000, 1 << 20)
    ]
    assert found[0] == "unknown"
    assert found[-1] == expected
    assert set(found) == {"unknown", expected}
