"""Nets in which what grows holds no more than a limit: what they say of the net itself."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.bounded_part import unbounded_places
from dineros.analysis.logic.ctl import limits
from dineros.analysis.logic.ctl.limits import decide_with_limits
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.branching_time import check_ctl

Decided = tuple[str, tuple[int, ...] | None] | None


def decided(net: CompiledNet, formula: str) -> Decided:
    """Return status and trace of the answer."""
    answer = decide_with_limits(net, parse(formula, "ctl"), NetNames(net), Budget(1 << 28, seconds=60))
    return None if answer is None else (answer.status, answer.trace)


def pile(*more: Transition) -> CompiledNet:
    """Return a worker that puts tasks on a pile without end and takes them again."""
    rows = [
        Transition("ask", {"idle": 1}, {"idle": 1, "pile": 1}, {}),
        Transition("begin", {"idle": 1, "pile": 1}, {"busy": 1}, {}),
        Transition("end", {"busy": 1}, {"idle": 1}, {}),
    ]
    places = {name for row in more for name in (*row.inputs, *row.outputs)}
    return CompiledNet.build(
        {"idle": 1, "pile": 0, "busy": 0} | dict.fromkeys(places - {"idle", "pile"}, 0), [*rows, *more]
    )


def test_what_stays_possible_and_what_is_never_reached() -> None:
    net = pile()
    assert unbounded_places(net) == {net.places.index("pile")}
    assert decided(net, "AG EF busy >= 1") == ("holds", None)
    assert decided(net, "AG !(busy >= 1 & idle >= 1)") == ("holds", None)
    assert decided(net, "EF busy >= 2") == ("violated", None)
    reached = decided(net, "EF busy >= 1")
    assert reached is not None and reached[0] == "holds"
    assert replay(net, reached[1] or ())[-1][net.places.index("busy")] == 1


def test_a_run_leads_to_where_nothing_helps_any_more() -> None:
    net = pile(Transition("break", {"busy": 1, "pile": 2}, {"gone": 1, "pile": 2}, {}))
    answer = decided(net, "AG EF busy >= 1")
    assert answer is not None and answer[0] == "violated"
    last = replay(net, answer[1] or ())[-1]
    assert last[net.places.index("gone")] == 1


def test_what_grows_may_not_be_asked_about_nor_inhibit() -> None:
    assert decided(pile(), "AG EF pile >= 5") is None and decided(pile(), "AG AF busy >= 1") is None
    net = pile(Transition("stop", {"idle": 1}, {"gone": 1}, {"pile": 2}))
    assert decided(net, "AG EF busy >= 1") is None
    assert decided(net, "EF (gone >= 1 & idle >= 1)") == ("violated", None), "it is exact about what inhibits"


@st.composite
def bounded_nets(draw: st.DrawFn) -> tuple[CompiledNet, list[str]]:
    """Return a small net with bounds, and places that are treated as if they had none."""
    piles = ["p", "q"][: draw(st.integers(1, 2))]
    places = ["a", "b", "c"]
    rows = []
    for number in range(draw(st.integers(2, 6))):
        inputs = {draw(st.sampled_from(places)): 1}
        outputs = {draw(st.sampled_from(places)): 1}
        for name in piles:
            taken, put = draw(st.integers(0, 2)), draw(st.integers(0, 2))
            inputs |= {name: taken} if taken else {}
            outputs |= {name: put} if put else {}
            gain = put - taken
            free = f"{name}.room"
            if gain > 0:
                inputs[free] = gain
            elif gain < 0:
                outputs[free] = -gain
        rows.append(Transition(f"t{number}", inputs, outputs, {}))
    room = draw(st.integers(3, 6))
    tokens = {"a": 1, "b": 0, "c": 0} | dict.fromkeys(piles, 0) | {f"{name}.room": room for name in piles}
    return CompiledNet.build(tokens, rows), piles


def test_each_net_with_limits_is_simulated_as_it_says() -> None:
    """By definition, on all markings: the open net can do all that the net can, the lossy one no more."""
    from dineros.analysis.covering.growing import limited

    net = pile(
        Transition("two", {"pile": 2, "busy": 1}, {"busy": 1}, {}),
        Transition("swap", {"pile": 1, "busy": 1}, {"busy": 1, "pile": 3}, {}),
    )
    pile_place, limit = net.places.index("pile"), 2
    made = limited(net, {pile_place: limit}, is_open=True)
    here = made.place[pile_place]
    for tokens in range(6):
        for busy in (0, 1):
            start = [0] * len(net.places)
            start[net.places.index("busy")], start[net.places.index("idle")] = busy, 1 - busy
            start[pile_place] = tokens
            after = successors(net, start, pile_place)
            small = [0] * len(made.net.places)
            for p, q in made.place.items():
                small[q] = start[p]
            small[here] = min(tokens, limit)
            small[made.net.places.index("pile.free")] = limit - small[here]
            most = successors(made.net, small, here, made.origin)
            assert {(t, min(n, limit)) for t, n in after} <= most
            lossy = successors(made.net, small, here, made.origin, made.added)
            for t, n in lossy:
                assert any(u == t and m >= n for u, m in after)


def successors(
    net: CompiledNet,
    marking: list[int],
    place: int,
    origin: tuple[int, ...] | None = None,
    without: frozenset[int] = frozenset(),
) -> set[tuple[int, int]]:
    """Return what can be fired, by its number in the net, and tokens of a place after it."""
    found = set()
    for t in set(range(len(net.transitions))) - without:
        if all(marking[p] >= w for p, w in net.pre.row(t)):
            found.add((t if origin is None else origin[t], marking[place] + net.delta[t].get(place, 0)))
    return found


FORMULAS = ("AG EF b >= 1", "AG EF (a >= 1 & c < 1)", "EF c >= 1", "AG b < 1", "AG EF c >= 1")


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(bounded_nets(), st.sampled_from(FORMULAS))
def test_no_answer_differs_from_that_of_all_markings(
    drawn: tuple[CompiledNet, list[str]], formula: str
) -> None:
    """Places with bounds are treated as if they had none; answers there are have to be those of the net."""
    net, piles = drawn
    numbers = {net.places.index(name) for pile in piles for name in (pile, f"{pile}.room")}
    tree: Formula = parse(formula, "ctl")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(limits, "unbounded_places", lambda _: numbers)
        answer = decide_with_limits(net, tree, NetNames(net), Budget(1 << 28, seconds=60))
    if answer is None:
        return
    expected = check_ctl(net, tree, engine="explicit")
    assert answer.status == expected.status
    if answer.trace is not None:
        replay(net, answer.trace)
