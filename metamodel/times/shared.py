"""Which intervals hold although several runs of a callback share the transition, and so its one clock.

With a clock for each run, a run would fire within ``[0, latest]`` after it has what it needs. The shared
clock starts with the first of these runs, and again when one of them has fired. It is never ahead of the
clock of the run that waits longest, if a run stops waiting only by firing, or together with all others. So
the shared transition allows all that clocks of their own would allow. What has to fire at once needs no such
condition: its clock never advances.

A least time is not kept: the shared clock may be behind that of a run. Without it, the interval allows more.

A transition joins the tokens of several runs if it takes from two places where runs put tokens, or where
messages and responses for them arrive. Then it may be enabled although no single run has what it needs, so
its interval does not hold.
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import resolve
from dineros.metamodel.times.given import duration_of
from dineros.metamodel.times.runs import ports_at, stand_for


def holds_for_all_runs(move: pn.Transition) -> bool:
    """Return whether the interval of a transition holds, although several runs of its callback share it."""
    interval = move.interval
    if interval is None or interval.earliest or interval.earliestExcluded:
        return False
    return latest_holds_for_all_runs(move)


def latest_holds_for_all_runs(move: pn.Transition) -> bool:
    """Return whether the latest bound of the interval of a transition holds for all runs that share it."""
    page, interval = callback_page_of(move), move.interval
    if page is None or interval is None or interval.latest is None or page.awaits or duration_of(page):
        return False
    if interval.latestExcluded or move.overrides:
        return False
    if isinstance(move, sym.Transition) and (move.clause or move.guard or move.duration):
        return False
    needs = [each for each in move.incoming if not isinstance(each.page, pnm.Sheet)]
    if any(each.kind not in (pn.ArcKind.normal, pn.ArcKind.read) or each.weight > 1 for each in needs):
        return False
    taken = [resolve(each.source) for each in needs if each.kind == pn.ArcKind.normal]
    if sum(_has_tokens_of_runs(each, page) for each in taken) > 1:
        return False
    return interval.latest == 0 or all(taker is move for place in taken for taker in _takers(place))


def _has_tokens_of_runs(place: pn.Node, page: sym.CallbackPage) -> bool:
    """Return whether runs of a callback put tokens on a place, or the middleware does so for them."""
    assert isinstance(place, pn.Place)
    return bool(ports_at(place)) or any(callback_page_of(giver) is page for giver in _givers(place))


def _takers(place: pn.Node) -> Iterator[pn.Node]:
    """Yield the transitions that take tokens from a place."""
    assert isinstance(place, pn.Place)
    for each in stand_for(place):
        yield from (arc.target for arc in each.outgoing if arc.kind == pn.ArcKind.normal)


def _givers(place: pn.Node) -> Iterator[pn.Node]:
    """Yield the transitions that put tokens on a place."""
    assert isinstance(place, pn.Place)
    for each in stand_for(place):
        yield from (arc.source for arc in each.incoming)
