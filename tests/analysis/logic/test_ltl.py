"""LTL verdicts against the reference, on generated nets and formulas."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet
from tests.analysis.logic.generated import atoms_of, random_ltl, random_net
from tests.analysis.logic.reference_ltl import has_counterexample, reachability_graph

SWITCH = CompiledNet.build(
    {"off": 1, "on": 0}, [("press", {"off": 1}, {"on": 1}), ("release", {"on": 1}, {"off": 1}), ("wait",)]
)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_verdicts_equal_the_reference(seed: int) -> None:
    # A violated verdict has been replayed and evaluated by definition before it is returned.
    rng = random.Random(seed)
    counts = {"holds": 0, "violated": 0}
    while sum(counts.values()) < 60:
        net = random_net(rng)
        graph = reachability_graph(net)
        if graph is None:
            continue
        for _ in range(4):
            formula = random_ltl(rng, rng.randrange(2, 9), atoms_of(rng, net, with_fired=True))
            names = list(net.transitions)
            weak = [t for t in names if rng.random() < 0.3]
            strong = [t for t in names if rng.random() < 0.2]
            automaton = translate(negated(formula))
            atoms = BoundAtoms(net, formula, NetNames(net))
            expected = has_counterexample(
                net, graph, automaton, atoms, [names.index(t) for t in weak], [names.index(t) for t in strong]
            )
            verdict = verify_ltl(net, formula, weak=weak, strong=strong)
            assert verdict.status == ("violated" if expected else "holds"), (net, str(formula), weak, strong)
            counts[verdict.status] += 1
    assert min(counts.values()) >= 10


@pytest.mark.parametrize(
    ("formula", "weak", "strong", "status"),
    [
        ("G (off + on == 1)", [], [], "holds"),
        ("F on >= 1", [], [], "violated"),
        ("F on >= 1", ["press"], [], "holds"),
        ("G F on >= 1", ["press", "release"], [], "holds"),
        ("G F fired(wait)", ["press", "release"], [], "violated"),
        ("G F fired(wait)", [], ["wait"], "holds"),
        ("G (fired(press) -> X enabled(release))", [], [], "holds"),
        ("G (signal(on) -> fired(release))", [], [], "violated"),
        ("G !deadlock", [], [], "holds"),
        ("X X X off >= 1", [], [], "violated"),
    ],
)
def test_a_switch(formula: str, weak: list[str], strong: list[str], status: str) -> None:
    assert verify_ltl(SWITCH, formula, weak=weak, strong=strong).status == status


def test_strong_fairness_says_more_than_weak() -> None:
    # `take` is enabled again and again, never continuously.
    net = CompiledNet.build(
        {"idle": 1, "open": 0, "taken": 0},
        [
            ("open", {"idle": 1}, {"open": 1}),
            ("close", {"open": 1}, {"idle": 1}),
            ("take", {"open": 1}, {"taken": 1}),
        ],
    )
    assert verify_ltl(net, "F taken >= 1", weak=["open", "close", "take"]).status == "violated"
    assert verify_ltl(net, "F taken >= 1", strong=["take"]).status == "holds"


def test_a_run_that_ends_in_a_deadlock_stays_there() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1})])
    verdict = verify_ltl(net, "F G a >= 1")
    assert (verdict.status, verdict.stem, verdict.loop) == ("violated", (0,), ())
    assert verify_ltl(net, "F G (deadlock & b == 1 & !fired(t))").status == "holds"


def test_fields_are_widened_while_tokens_grow() -> None:
    net = CompiledNet.build(
        {"p": 0, "stop": 1}, [("more", {}, {"p": 3}, {}, {"stop": 1}), ("end", {"stop": 1})]
    )
    verdict = verify_ltl(net, "G p <= 3000")
    assert verdict.status == "violated"
    assert len(verdict.stem) + len(verdict.loop) >= 1001


@pytest.mark.parametrize(
    ("budget", "word"),
    [
        (Budget(states=1000), "states"),
        (Budget(seconds=0.05), "time"),
        (Budget(memory_bytes=3_000_000), "memory"),
    ],
)
def test_budgets_end_in_unknown(budget: Budget, word: str) -> None:
    net = CompiledNet.build({"p": 0, "q": 0}, [("t", {}, {"p": 1}), ("u", {}, {"q": 1})])
    verdict = verify_ltl(net, "G p >= 0", budget=budget)
    assert verdict.status == "unknown"
    assert verdict.reason.startswith(word)
    assert verdict.states


def test_more_fair_transitions_than_bits_in_a_word() -> None:
    size = 70
    places = {f"p{i}": int(i == 0) for i in range(size)}
    steps = [(f"t{i}", {f"p{i}": 1}, {f"p{(i + 1) % size}": 1}) for i in range(size)]
    net = CompiledNet.build(places, [*steps, ("spin",)])
    assert verify_ltl(net, f"G F p{size - 1} >= 1").status == "violated"
    assert verify_ltl(net, f"G F p{size - 1} >= 1", weak=net.transitions).status == "holds"
    assert verify_ltl(net, f"G p{size - 1} < 1", weak=net.transitions).status == "violated"
    assert verify_ltl(net, f"G p{size - 1} < 1", strong=net.transitions).status == "violated"


def test_progress_is_told() -> None:
    net = CompiledNet.build({f"p{i}": 1 for i in range(17)}, [(f"t{i}", {f"p{i}": 1}) for i in range(17)])
    seen: list[Progress] = []
    assert verify_ltl(net, "G p0 <= 1", budget=Budget(progress=seen.append)).states == 2**17
    assert seen[-1].count > 0
    assert seen[-1].memory_bytes > 0


@pytest.mark.parametrize(
    ("formula", "column", "hint"),
    [("G (of >= 1)", 4, "'off'"), ("fired(pres)", 7, "'press'"), ("signal(o)", 8, None)],
)
def test_unknown_names_are_shown_with_near_ones(formula: str, column: int, hint: str | None) -> None:
    with pytest.raises(FormulaError) as caught:
        verify_ltl(SWITCH, formula)
    assert caught.value.column == column
    assert hint is None or (caught.value.hint is not None and hint in caught.value.hint)


def test_an_unknown_fair_transition_is_an_error() -> None:
    with pytest.raises(FormulaError, match="no transition is named 'pres'"):
        verify_ltl(SWITCH, "true", weak=["pres"])


@pytest.mark.parametrize("size", [62, 63, 64])
def test_the_automaton_s_state_may_stand_in_the_highest_bit_of_a_word(size: int) -> None:
    net = CompiledNet.build({f"p{i}": 1 for i in range(size)}, [(f"t{i}", {f"p{i}": 1}) for i in range(size)])
    edge = Edge(0, 0, 0, 1)
    automaton = Automaton((), 0, 1, ((edge,), (edge,)))
    product = Product(net, automaton, [], (), (), Budget().begun())
    assert product.marking(0) == tuple(net.initial.tolist())
