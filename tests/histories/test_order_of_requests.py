"""Which request a full history forgets makes no difference, as the rules say of it."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable
from functools import partial
from typing import NamedTuple, TypeAlias

import pytest

from dineros.transformations.flattening.flatten import flatten
from tests.support.reachability import ReachabilityGraph
from tests.support.references.flattening import plain_net_of
from tests.support.systems.ovens import oven

Observed: TypeAlias = tuple[str, str]
Step: TypeAlias = "tuple[Observed | None, Hashable]"
Steps: TypeAlias = Callable[[Hashable], Iterable[Step]]


@pytest.mark.long
@pytest.mark.parametrize(("bakers", "depth"), [(3, 1), (3, 2), (4, 2)])
def test_which_request_is_lost_makes_no_difference(bakers: int, depth: int) -> None:
    """A history that forgets the oldest request shows what the net shows, which loses the newest.

    What is seen: who asks, whom the server takes and answers, whose requests are lost once all have come.
    """
    graph = ReachabilityGraph(plain_net_of(flatten(oven(bakers, depth, again=False), "none").net))

    def in_net(marking: Hashable) -> Iterable[Step]:
        assert isinstance(marking, tuple)
        for name, after in graph.successors(marking):
            parts = str(name).split(".")
            kind = {"req": "asks", "call[1]": "is taken", "return[1]": "is answered"}.get(parts[-1])
            yield None if kind is None else (kind, parts[2]), after

    def lost_in_net(marking: Hashable) -> frozenset[str] | None:
        assert isinstance(marking, tuple)
        marked = {str(place) for place, tokens in zip(graph.places, marking, strict=True) if tokens}
        if any(place.endswith(".sent") for place in marked):
            return None
        return frozenset(place.split(".")[2] for place in marked if place.endswith(".lost"))

    start = _Oldest(frozenset(f"baker{number}" for number in range(bakers)))
    seen = _compare((graph.start, in_net, lost_in_net), (start, partial(_steps, depth=depth), _lost))
    assert seen > bakers


class _Oldest(NamedTuple):
    """Whose requests are not made yet, on their way, in the history in order, at work, lost."""

    idle: frozenset[str]
    away: frozenset[str] = frozenset()
    kept: tuple[str, ...] = ()
    at_work: str = ""
    lost: frozenset[str] = frozenset()


def _steps(state: Hashable, depth: int) -> Iterable[Step]:
    """Yield what can happen in a history that forgets its oldest request."""
    assert isinstance(state, _Oldest)
    idle, away, kept, at_work, lost = state
    for name in idle:
        yield ("asks", name), state._replace(idle=idle - {name}, away=away | {name})
    for name in away:
        full, newest = len(kept) == depth, (*kept, name)
        gone = lost | {kept[0]} if full else lost
        yield None, state._replace(away=away - {name}, kept=newest[full:], lost=gone)
    if kept and not at_work:
        yield ("is taken", kept[0]), state._replace(kept=kept[1:], at_work=kept[0])
    if at_work:
        yield ("is answered", at_work), state._replace(at_work="")


def _lost(state: Hashable) -> frozenset[str] | None:
    assert isinstance(state, _Oldest)
    return None if state.away else state.lost


Automaton: TypeAlias = tuple[Hashable, Steps, Callable[[Hashable], "frozenset[str] | None"]]


def _compare(one: Automaton, other: Automaton) -> int:
    """Walk what two automata show together, and return how many sets of states were compared."""
    pairs = [tuple(_closed({automaton[0]}, automaton[1]) for automaton in (one, other))]
    seen = set(pairs)
    for pair in pairs:
        after: list[dict[Observed, set[Hashable]]] = [{}, {}]
        shown = []
        for states, (_, steps, lost), then in zip(pair, (one, other), after, strict=True):
            shown.append({found for state in states if (found := lost(state)) is not None})
            for state in states:
                for observed, reached in steps(state):
                    if observed is not None:
                        then.setdefault(observed, set()).add(reached)
        assert shown[0] == shown[1]
        assert after[0].keys() == after[1].keys()
        for observed in after[0]:
            next_pair = _closed(after[0][observed], one[1]), _closed(after[1][observed], other[1])
            if next_pair not in seen:
                seen.add(next_pair)
                pairs.append(next_pair)
    return len(seen)


def _closed(states: set[Hashable], steps: Steps) -> frozenset[Hashable]:
    """Return what can be reached from states without anything being seen."""
    pending, found = list(states), set(states)
    while pending:
        for observed, reached in steps(pending.pop()):
            if observed is None and reached not in found:
                found.add(reached)
                pending.append(reached)
    return frozenset(found)
