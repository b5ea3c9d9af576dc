"""What parts of a net say about a condition is what a plain search of the whole net says."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit.goals import Comparison, Goal
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.portfolio.known import known_of
from dineros.analysis.portfolio.methods.parts import PARTS, PartsOfNet
from dineros.analysis.portfolio.reach import Reach
from tests.analysis.parts.test_part_firings import nets_of_machines
from tests.analysis.strategies import nets

MOST = 3_000
_RELATIONS = st.sampled_from(["<", "<=", "=", "!=", ">=", ">"])


def markings_of(net: CompiledNet) -> tuple[list[tuple[int, ...]], bool]:
    """Return the first markings of a net, and whether these are all."""
    start = tuple(net.initial.tolist())
    seen, found = {start}, [start]
    for marking in found:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                after = tuple(net.fire(t, marking))
                if after not in seen:
                    if len(found) == MOST:
                        return found, False
                    seen.add(after)
                    found.append(after)
    return found, True


def goals_of_net(net: CompiledNet) -> st.SearchStrategy[Goal]:
    """Goals about single places, or an enabled transition."""
    place = st.integers(0, len(net.places) - 1)
    comparison = st.builds(lambda p, r, n: Comparison({p: 1}, r, n), place, _RELATIONS, st.integers(-1, 4))
    rows = st.lists(st.lists(comparison, min_size=1, max_size=3).map(tuple), min_size=1, max_size=2)
    conditions = rows.map(lambda each: Goal(conjunctions=tuple(each)))
    return conditions | st.sampled_from(range(len(net.transitions))).map(lambda t: Goal((t,)))


class _OfGoal(Reach):
    """A question that is nothing but its goal."""

    def holds(self, marking: object) -> bool:
        assert self.own_goals is not None
        return self.own_goals[0].holds(self.net, marking)  # type: ignore[arg-type]


def asked(net: CompiledNet, goal: Goal) -> Outcome | None:
    question = _OfGoal(net, parse("true", "state"), NetNames(net), own_goals=(goal,))
    return PartsOfNet().answer(question, known_of(net), Budget(seconds=20).begun())


def compare(net: CompiledNet, goal: Goal) -> bool:
    """Compare an answer with a plain search; return whether there is one."""
    answer = asked(net, goal)
    if answer is None:
        return False
    markings, is_all = markings_of(net)
    if answer.status == "reachable":
        assert answer.trace is not None
        assert goal.holds(net, replay(net, answer.trace)[-1])
    else:
        assert answer.status == "unreachable"
        assert not any(goal.holds(net, marking) for marking in markings)
    assert not is_all or (answer.status == "reachable") == any(goal.holds(net, m) for m in markings)
    return True


@given(nets(), st.data())
@settings(max_examples=150, deadline=None)
def test_answers_about_any_net_are_right(net: CompiledNet, data: st.DataObject) -> None:
    compare(net, data.draw(goals_of_net(net)))


@given(nets_of_machines(), st.data())
@settings(max_examples=100, deadline=None)
def test_answers_about_machines_are_right_and_there(net: CompiledNet, data: st.DataObject) -> None:
    # All places are bounded: each question is decided.
    assert compare(net, data.draw(goals_of_net(net)))


def many_machines(count: int) -> CompiledNet:
    """Independent machines of three steps; the first one lacks a token for its last step."""
    places = {f"m{k}.{n}": int(n == 0) for k in range(count) for n in range(3)} | {"gate": 0, "key": 1}
    rows = [
        Transition(f"m{k}.go{n}", {f"m{k}.{n}": 1}, {f"m{k}.{(n + 1) % 3}": 1})
        for k in range(count)
        for n in range(3)
        if (k, n) != (0, 1)
    ]
    rows.append(Transition("last", {"m0.1": 1, "gate": 1}, {"m0.2": 1, "gate": 1}))
    rows.append(Transition("open", {"m1.2": 1, "m1.1": 1, "key": 1}, {"m1.2": 1, "m1.1": 1, "gate": 1}))
    return CompiledNet.build(places, rows)


def test_find_and_verify_decide_what_no_search_of_the_whole_net_can() -> None:
    net = many_machines(60)
    names = NetNames(net)
    answer = PartsOfNet().answer(
        Reach(net, parse('"m0.2" >= 1', "state"), names), known_of(net), Budget(seconds=20).begun()
    )
    assert answer == Outcome("unreachable", by=PARTS)
    assert find_marking(net, '"m0.2" >= 1', names, Budget(seconds=20)).status == "unreachable"


def test_sums_of_places_and_places_that_grow_stay_open() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"a": 1, "b": 1})])

    def of(*comparisons: Comparison) -> Outcome | None:
        return asked(net, Goal(conjunctions=(comparisons,)))

    assert of(Comparison({0: 1, 1: 1}, ">=", 3)) is None
    assert of(Comparison({0: 1}, ">=", 1), Comparison({1: 1}, ">=", 3)) is None
    assert of(Comparison({0: 1}, ">=", 2), Comparison({1: 1}, ">=", 3)) == Outcome("unreachable", by=PARTS)
    assert of(*(Comparison({0: 1}, "!=", number) for number in range(3, 20))) is None
