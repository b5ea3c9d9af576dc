"""LTL without what the outside changes at will: every verdict is that of the whole net, every run its own."""

from __future__ import annotations

import random
from collections import Counter

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit.layout import layout
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.patience import is_patient
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.ltl.free_parts import Smaller, without_free_parts
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.logic.verdicts.verdict import check_counterexample
from dineros.analysis.nets.bounds import flows_and_bounds, grows, weighted_sum
from dineros.analysis.nets.compiled import CompiledNet, Transition
from tests.analysis.logic.generated import atoms_of, random_ltl, random_net
from tests.analysis.logic.reference_ltl import has_counterexample, reachability_graph


def with_signals(rng: random.Random, net: CompiledNet) -> CompiledNet:
    """Add signals that change at will, or only where something that tests them has all else it needs."""
    places = dict(zip(net.places, net.initial.tolist(), strict=True))
    rows = [
        [{net.places[p]: w for p, w in table.row(t)} for table in (net.pre, net.post, net.inhibitor)]
        for t in range(len(net.transitions))
    ]
    movers = []
    for s in range(rng.randrange(1, 3)):
        places |= {f"s{s}": 1, f"n{s}": 0}
        tests = rng.sample(range(len(rows)), min(len(rows), rng.randrange(1, 3)))
        is_everywhere = rng.random() < 0.4
        for number, t in enumerate(tests):
            inputs, _, inhibitors = rows[t]
            for k, (low, high) in enumerate(((f"s{s}", f"n{s}"), (f"n{s}", f"s{s}"))):
                if rng.random() < 0.95 and not (is_everywhere and number):
                    # Without what it needs of other signals.
                    own = {} if is_everywhere else {p: w for p, w in inputs.items() if p[0] == "p"}
                    blocked = {} if is_everywhere else {p: w for p, w in inhibitors.items() if p[0] == "p"}
                    movers.append(Transition(f"m{s}.{k}.{t}", {low: 1}, {high: 1}, blocked, own))
        for t in tests:
            wanted = rng.choice([f"s{s}", f"n{s}"])
            if rng.random() < 0.2:
                rows[t][2][wanted] = 1
            else:
                rows[t][0][wanted] = rows[t][1][wanted] = 1
    kept = [Transition(name, *row) for name, row in zip(net.transitions, rows, strict=True)]
    return CompiledNet.build(places, [*kept, *movers])


@pytest.mark.long
@pytest.mark.parametrize("seed", range(8))
def test_verdicts_are_those_of_the_whole_net(seed: int) -> None:
    rng = random.Random(seed)
    seen: Counter[str] = Counter()
    for _ in range(150):
        core = random_net(rng)
        net = with_signals(rng, core)
        graph = reachability_graph(net, 200)
        if graph is None:
            continue
        formula = random_ltl(rng, rng.randrange(2, 7), atoms_of(rng, core, with_fired=True))
        bound = BoundAtoms(net, formula, NetNames(net))
        strong = rng.sample(range(len(net.transitions)), rng.choice([0, 0, 1]))
        weak = rng.sample(range(len(core.transitions)), rng.randrange(0, len(core.transitions) + 1))
        weak = [t for t in weak if t not in strong]
        smaller = without_free_parts(net, formula, bound, NetNames(net), weak, strong)
        if smaller is None:
            seen["nothing free"] += 1
            continue
        expected = has_counterexample(net, graph, translate(negated(formula)), bound, weak, strong)
        answer = verify_ltl(
            smaller.net, formula, smaller.names, smaller.weak, smaller.strong, Budget(1 << 26)
        )
        assert (answer.status == "violated") == expected, (net, str(formula), weak, strong)
        seen[answer.status] += 1
        if expected:
            lasso = smaller.lift(answer.stem, answer.loop)
            assert lasso is not None
            check_counterexample(net, formula, bound, *lasso, weak, strong)
            seen["disabled"] += bool(smaller.disabled)
    assert min(seen["holds"], seen["violated"], seen["disabled"]) >= 3, seen


def test_the_smaller_net_is_made_once_for_the_same_removed_places() -> None:
    net = CompiledNet.build(
        {"off": 1, "on": 0, "low": 1, "high": 0, "idle": 1, "busy": 0},
        [
            ("switch on", {"off": 1}, {"on": 1}),
            ("switch off", {"on": 1}, {"off": 1}),
            ("rise", {"low": 1}, {"high": 1}),
            ("fall", {"high": 1}, {"low": 1}),
            Transition("start", {"idle": 1}, {"busy": 1}, reads={"on": 1}),
            Transition("stop", {"busy": 1}, {"idle": 1}, reads={"high": 1}),
        ],
    )
    start, stop = net.transitions.index("start"), net.transitions.index("stop")

    def smaller(text: str, weak: list[int], strong: list[int]) -> Smaller:
        formula = parse(text)
        names = NetNames(net)
        found = without_free_parts(net, formula, BoundAtoms(net, formula, names), names, weak, strong)
        assert found is not None
        return found

    first, fair, other = (
        smaller("F busy >= 1", [], []),
        smaller("F busy >= 1", [start, stop], []),
        smaller("G F idle >= 1", [stop], []),
    )
    assert first.net.places == ("idle", "busy")
    assert fair.net is first.net and other.net is first.net
    assert (first.disabled, fair.disabled, other.disabled) == ((), (start, stop), (stop,))
    # What tests a part and is strongly fair keeps it.
    kept = smaller("F busy >= 1", [], [start])
    assert kept.net.places == ("off", "on", "idle", "busy")
    assert smaller("F busy >= 1", [stop], [start]).net is kept.net
    assert smaller("F busy >= 1", [], []).net is first.net


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("G F fired(t)", True),
        ("G (!fired(t) | F a >= 1)", True),
        ("(!fired(t)) U (fired(u) & a >= 1)", True),
        ("G (a >= 1 -> F (fired(t) | fired(u)))", True),
        ("F (deadlock & G a == 0)", True),
        ("fired(t)", False),
        ("F !fired(t)", False),
        ("G fired(t)", False),
        ("fired(t) U a >= 1", False),
        ("F (fired(t) | a >= 1)", True),
        ("X a >= 1", False),
        ("G (fired(t) -> X a >= 1)", False),
    ],
)
def test_formulas_that_steps_from_outside_cannot_change(text: str, expected: bool) -> None:
    formula: Formula = parse(text)
    assert is_patient(formula) is expected


@pytest.mark.parametrize("seed", range(4))
def test_the_layout_of_the_rest_is_that_of_the_rest_alone(seed: int) -> None:
    """It comes from the layout of the whole net, which is found once."""
    rng = random.Random(seed)
    compared = 0
    while compared < 25:
        core = random_net(rng)
        net = with_signals(rng, core)
        formula = parse(f"G F fired({core.transitions[0]})")
        bound = BoundAtoms(net, formula, NetNames(net))
        smaller = without_free_parts(net, formula, bound, NetNames(net), (), ())
        if smaller is None or net.once(flows_and_bounds)[0] is None:
            continue
        compared += 1
        alone = smaller.net.with_initial({})
        (flows, bounds), (expected_flows, expected_bounds) = (
            each.once(flows_and_bounds) for each in (smaller.net, alone)
        )
        assert flows == expected_flows
        assert [b and b.value for b in bounds] == [b and b.value for b in expected_bounds]
        for b, p in zip(bounds, range(len(bounds)), strict=True):
            assert b is None or (
                not grows(alone, b.weights) and weighted_sum(alone, b.weights) // b.weights[p] == b.value
            )
        assert cells_of(smaller.net) == cells_of(alone)


def cells_of(net: CompiledNet) -> list[tuple[object, ...]]:
    """Return the cells of a net's layout, in an order of their own."""
    return sorted((cell.places, cell.factors, cell.bits, cell.has_guard) for cell in net.once(layout).cells)
