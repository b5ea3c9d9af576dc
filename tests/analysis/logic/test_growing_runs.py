"""LTL and CTL on nets without bounds: runs that repeat a loop although tokens grow."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.ltl.growing_runs import EndlessRuns
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.logic.verdicts.verdict import ReplayError, settled
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.metamodel import sym
from tests.analysis.logic.unbounded_lassos import compare
from tests.analysis.strategies import nets
from tests.support.systems.unbounded_systems import unbounded_systems

WORK = CompiledNet.build(
    {"on": 1, "work": 0, "hands": 1, "busy": 0, "done": 0},
    [
        Transition("tick", {"on": 1}, {"on": 1, "work": 1}),
        Transition("begin", {"work": 1, "hands": 1}, {"busy": 1}),
        Transition("end", {"busy": 1}, {"hands": 1, "done": 1}),
    ],
)
"""Work comes forever, whoever does it; what is done is counted."""

NUMBERS = st.integers(0, 5)
LIMITS = Budget(memory_bytes=1 << 28, seconds=60)


@pytest.mark.long
@pytest.mark.parametrize(
    ("formula", "fair", "status"),
    [
        ("G F fired(begin)", (), "violated"),
        ("F (work >= 5 & X work < 5)", (), "violated"),
        ("G (work <= 40)", (), "violated"),
        ("G (busy + hands == 1)", (), "holds"),
        ("G F fired(tick) | F G !fired(tick)", (), "holds"),
        ("G (busy >= 1 -> F fired(end))", (), "violated"),
        ("G (busy >= 1 -> F fired(end))", ("end",), "holds"),
        ("F G (work >= 3)", (), "violated"),
        ("G (done <= 30)", (), "violated"),
    ],
)
def test_work_that_comes_for_ever(formula: str, fair: tuple[str, ...], status: str) -> None:
    answer = verify_ltl(WORK, formula, weak=fair, budget=LIMITS)
    assert answer.status == status, answer.reason
    if status == "violated":
        atoms = BoundAtoms(WORK, parse(formula), NetNames(WORK))
        assert not holds_on_lasso(
            parse(formula), *settled(WORK, atoms, answer.stem, answer.loop), atoms.is_true
        )


def test_a_counter_is_no_reason_to_give_up() -> None:
    net = CompiledNet.build(
        {"on": 1, "off": 0, "count": 0},
        [("flip", {"on": 1}, {"off": 1, "count": 1}), ("flop", {"off": 1}, {"on": 1})],
    )
    assert verify_ltl(net, "G F fired(flip)").status == "holds"
    assert verify_ltl(net, "F (count >= 9)").status == "holds"
    answer = verify_ltl(net, "G (count <= 9)")
    assert answer.status == "violated"


@pytest.mark.long
def test_what_is_not_decided_says_what_grows() -> None:
    # Whether some run keeps both equal: a question that no loop answers.
    net = CompiledNet.build(
        {"a": 0, "b": 0, "on": 1},
        [
            Transition("more", {"on": 1}, {"on": 1, "a": 1}),
            Transition("other", {"on": 1}, {"on": 1, "b": 1}),
            Transition("take", {"a": 1}, {}),
            Transition("get", {"b": 1}, {}),
        ],
    )
    answer = verify_ltl(net, "G (a - b <= 1000000)")
    assert answer.status in ("unknown", "violated")
    if answer.status == "unknown":
        assert "grows whenever these fire again: " in answer.reason


FORMULAS = [
    "G F fired(t0)",
    "F G !fired(t0)",
    "G (p0 <= 2)",
    "F (p0 >= 1)",
    "G (p0 >= 1 -> F fired(t0))",
    "p0 <= 1 U p0 >= 2",
]


@pytest.mark.long
@settings(max_examples=15, deadline=None)
@given(nets(), st.sampled_from(FORMULAS), st.booleans())
def test_answers_agree_with_the_product(net: CompiledNet, formula: str, fair: bool) -> None:
    tree, names = parse(formula), NetNames(net)
    atoms = BoundAtoms(net, tree, names)
    expected = verify_ltl(net, tree, weak=["t0"] if fair else [], budget=Budget(states=20_000))
    runs = EndlessRuns(net, tree, atoms, names, ("t0",) if fair else (), (), verify_ltl)
    found = runs.decide(Budget(seconds=20, states=20_000))
    if found is None:
        return
    if expected.status != "unknown":
        assert found.status == expected.status
    if found.status == "violated":
        first, again = settled(net, atoms, found.stem, found.loop)
        assert not holds_on_lasso(tree, first, again, atoms.is_true)


@pytest.mark.long
@settings(max_examples=3, deadline=None)
@given(unbounded_systems())
def test_what_a_lasso_of_a_plain_search_refutes_is_refuted(model: sym.SystemModel) -> None:
    compare(model, most=300, formulas=4)


@settings(max_examples=40, deadline=None)
@given(nets(), st.lists(st.integers(0, 5), max_size=6), st.lists(st.integers(0, 5), min_size=1, max_size=4))
def test_atoms_stay_what_they_are_once_a_run_is_settled(
    net: CompiledNet, stem: list[int], loop: list[int]
) -> None:
    tree = parse("p0 >= 3 & enabled(t0) & deadlock & p0 - 2*p0 >= -9")
    atoms = BoundAtoms(net, tree, NetNames(net))
    count = len(net.transitions)
    stem, loop = [t % count for t in stem], [t % count for t in loop]
    try:
        first, again = settled(net, atoms, stem, loop)
        _, once_more = settled(net, atoms, stem + loop * (len(first) // len(loop) + 7), loop)
    except ReplayError:
        return
    row = [[atoms.is_true(atom, step) for atom in atoms.conditions] for step in again]
    assert row == [[atoms.is_true(atom, step) for atom in atoms.conditions] for step in once_more]


@pytest.mark.long
@pytest.mark.parametrize(
    ("formula", "status"),
    [
        ("EF (work >= 7 & busy >= 1)", "holds"),
        ("EF (on == 0)", "violated"),
        ("AG (busy + hands == 1)", "holds"),
        ("AG (busy <= 1)", "holds"),
        ("AG (work <= 20)", "violated"),
        ("AF (done >= 1)", "violated"),
        ("AG (busy >= 1 -> AF busy == 0)", "violated"),
        ("AG EF (work == 0)", "unknown"),
    ],
)
def test_ctl_of_work_that_comes_for_ever(formula: str, status: str) -> None:
    answer = check_ctl(WORK, formula, budget=LIMITS)
    assert answer.status == status, answer.reason
    if answer.status == "unknown":
        assert answer.reason.endswith("because work grows whenever these fire again: tick")
    if answer.loop:
        settled(WORK, BoundAtoms(WORK, parse(formula, "ctl"), NetNames(WORK)), answer.stem, answer.loop)


@pytest.mark.long
def test_ctl_of_a_net_where_only_a_counter_grows() -> None:
    net = CompiledNet.build(
        {"on": 1, "off": 0, "count": 0},
        [("flip", {"on": 1}, {"off": 1, "count": 1}), ("flop", {"off": 1}, {"on": 1})],
    )
    assert check_ctl(net, "AG EF on == 1").status == "holds"
    assert check_ctl(net, "AF count >= 20").status == "holds"
    assert check_ctl(net, "AG EF count == 3").status == "violated"
