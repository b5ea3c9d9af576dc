"""How many runs of a callback overlap, by the times of a model.

A timer's callback in a reentrant group may run on several threads. But its runs do not overlap if each takes
less time than lies between two strikes, and begins with its strike: then the last one has ended. It begins
with its strike if there is a thread for every callback of the node that may run then.

The proof is by the first strike at which one of these timers does not find its last run ended, or does not
find a thread. Until then, each of them has had one run at a time, and so has each exclusive group. So there
is a thread, and the last run, which began with its strike, has ended.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, group_or_node, threads_of
from dineros.metamodel.elements import channels, node_net_of, resolve, system_model_of, transitions
from dineros.metamodel.times.given import duration_of, period_of, runs_at_once
from dineros.metamodel.times.runs import is_changed_elsewhere, places_of_ports


def runs_overlapping(page: sym.CallbackPage) -> int:
    """Return how many runs of a callback may overlap in a model with times."""
    at_once = runs_at_once(page)
    return 1 if at_once > 1 and _comes_in_time(page) and _has_threads(page) else at_once


def _comes_in_time(page: sym.CallbackPage) -> bool:
    """Return whether each run of a timer ends before the next strike, if it begins with its own."""
    node = node_net_of(page)
    period = period_of(page)
    if period is None or node is None or node.lifecycle is not None:
        return False
    longest = _longest(page)
    if longest is None:
        return False
    jitter = Fraction(0) if page.jitter is None else Fraction(repr(page.jitter))
    return longest < Fraction(repr(period)) - jitter


def _has_threads(page: sym.CallbackPage) -> bool:
    """Return whether each callback of a node that may run at a moment has a thread then."""
    node = node_net_of(page)
    assert node is not None
    groups, alone = set(), 0
    for each in node.eAllContents():
        if isinstance(each, sym.CallbackPage):
            if runs_at_once(each) == 1:
                groups.add(group_or_node(each))
            elif _comes_in_time(each):
                alone += 1
            else:
                return False
    return len(groups) + alone <= threads_of(node)


def _longest(page: sym.CallbackPage) -> Fraction | None:
    """Return how long a run takes at most; None if nothing bounds it, or if others can keep it back."""
    body = Body(page)
    if page.awaits or body.requests or not _goes_on_alone(page, body):
        return None
    duration = duration_of(page)
    intervals = [each.interval for each in body.transitions]
    if duration is not None:
        given = [duration] if all(each is None for each in intervals) else []
    else:
        given = [each for each in intervals if each is not None]
        given = given if len(given) == len(intervals) else []
    if not given or any(each.latest is None for each in given):
        return None
    return sum((Fraction(repr(each.latest)) for each in given), Fraction(0))


def _goes_on_alone(page: sym.CallbackPage, body: Body) -> bool:
    """Return whether a run proceeds step by step, without circles, and nothing else takes part in it."""
    model = system_model_of(page)
    if model is None:
        return False
    ports, inside = places_of_ports(model), set(body.transitions)
    published = {port.place for topic in channels(model, sym.TopicChannel) for port in topic.publishers}
    onward: dict[pn.Node, set[pn.Node]] = {}
    for each in transitions(model):
        if each.overrides and (each in inside or inside & set(each.overrides)):
            return False
    for each in body.transitions:
        if isinstance(each, sym.Transition) and (each.clause is not None or each.duration is not None):
            return False
        for arc in _needs(each):
            place = resolve(arc.source)
            if (
                arc.kind != pn.ArcKind.normal
                or not isinstance(place, pn.Place)
                or place in ports
                or place.tokens
                or callback_page_of(place) is not page
                or is_changed_elsewhere(page, place)
            ):
                return False
            onward.setdefault(place, set()).add(each)
        for arc in each.outgoing:
            if isinstance(arc.page, pnm.Sheet):
                continue
            place = resolve(arc.target)
            if not isinstance(place, pn.Place) or place.capacity is not None:
                return False
            if place not in published and (place in ports or callback_page_of(place) is not page):
                return False
            onward.setdefault(each, set()).add(place)
        if body.continues(each) > (each not in body.ends()):
            return False
    return not _is_circular(onward)


def _needs(transition: pn.Transition) -> Iterator[pn.Arc]:
    """Yield the arcs by which a transition of the model needs something, not those that rules add.

    Rule D2Start gives what the first transition of a timer's callback needs to a transition before it.
    """
    for arc in transition.incoming:
        if not isinstance(arc.page, pnm.Sheet):
            yield arc
            continue
        for before in resolve(arc.source).incoming if isinstance(arc.source.page, pnm.Sheet) else ():
            for need in before.source.incoming:
                if not isinstance(need.source.page, pnm.Sheet):
                    yield need


def _is_circular(onward: dict[pn.Node, set[pn.Node]]) -> bool:
    left = dict(onward)
    while left:
        last = [node for node, after in left.items() if not after & left.keys()]
        if not last:
            return True
        for node in last:
            del left[node]
    return False
