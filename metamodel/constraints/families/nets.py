"""Petri nets: arcs, tokens, references, time and priorities (ISO/IEC 15909-1 and -2)."""

from __future__ import annotations

import math
from datetime import date

from dineros.metamodel import pn
from dineros.metamodel.constraints.circles import circles
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe, listed
from dineros.metamodel.files.exact import fraction_of

_FROM_PLACES = {pn.ArcKind.inhibitor: "an inhibitor", pn.ArcKind.read: "a read"}


def _ends(arc: pn.Arc) -> tuple[pn.Node, pn.Node, pn.ArcKind]:
    return (arc.source, arc.target, arc.kind)


@constraint(
    "{it} joins {found}",
    fix="join a place and a transition, or references to them",
)
def arc_joins_place_and_transition(arc: pn.Arc, index: Index) -> Outcome:
    """An arc joins a place and a transition, or references to them."""
    ends = (arc.source, arc.target)
    return isinstance(ends[0], pn.PlaceNode) != isinstance(ends[1], pn.PlaceNode) or listed(ends)


@constraint(
    "{it} joins {found}, which are on different pages",
    fix="put a reference place or a reference transition on one of the pages",
)
def arc_within_page(arc: pn.Arc, index: Index) -> Outcome:
    """An arc joins nodes of the same page."""
    return arc.source.page is arc.target.page or listed([arc.source, arc.target])


@constraint(
    "{it} is on another page than its ends",
    fix="move it to {found}",
    severity="warning",
)
def arc_on_page_of_its_ends(arc: pn.Arc, index: Index) -> Outcome:
    """An arc is on the page of the nodes it joins."""
    page = arc.source.page
    return arc.page is page or page is None or page is not arc.target.page or describe(page)


@constraint("{it} has the weight {element.weight}", fix="give it a weight of 1 or more")
def arc_weight(arc: pn.Arc, index: Index) -> Outcome:
    """The weight of an arc is 1 or more."""
    return arc.weight >= 1


@constraint(
    "{it} is {found} arc that starts at a transition",
    fix="let it go from the place to the transition",
    guard=lambda arc, index: isinstance(arc.target, pn.PlaceNode),
)
def read_or_inhibitor_arc_from_place(arc: pn.Arc, index: Index) -> Outcome:
    """An inhibitor or read arc goes from a place to a transition."""
    return _FROM_PLACES.get(arc.kind, True)


@constraint(
    "{it} joins the same nodes as {found}, in the same direction",
    fix="use one arc; the weights of normal arcs add up",
    severity="warning",
)
def arc_not_doubled(arc: pn.Arc, index: Index) -> Outcome:
    """No two arcs of the same kind go from one node to another."""
    first = index.earliest(arc, pn.Arc, _ends)
    return first is arc or describe(first)


@constraint("{it} holds {element.tokens} tokens", fix="give it 0 tokens or more")
def tokens_not_negative(place: pn.Place, index: Index) -> Outcome:
    """A place holds 0 tokens or more."""
    return place.tokens >= 0


@constraint("references run in a circle: {found}", fix="let one of them refer to a place or transition")
def reference_ends(node: pn.Node, index: Index) -> Outcome:
    """Chains of references end at a place or transition."""
    return circles(index, pn.Node, _reference_target).get(node, True)


def _reference_target(node: pn.Node) -> list[pn.Node]:
    return [node.target] if isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)) else []


@constraint(
    "{it} refers to {found} of its own page",
    fix="join the arcs to that node itself",
    severity="warning",
    guard=lambda node, index: (
        isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)) and node.target is not node
    ),
)
def reference_to_other_page(node: pn.Node, index: Index) -> Outcome:
    """A reference stands for a node of another page."""
    assert isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition))
    return node.target.page is not node.page or describe(node.target)


@constraint(
    "{it} runs from {element.earliest} to {element.latest}",
    fix="use finite bounds of 0 or more, or no latest time for a transition that may wait forever",
)
def interval_finite(interval: pn.TimeInterval, index: Index) -> Outcome:
    """The bounds of a time interval are finite and not negative."""
    bounds = [interval.earliest, interval.earliest if interval.latest is None else interval.latest]
    return all(math.isfinite(bound) and bound >= 0 for bound in bounds)


@constraint(
    "{it} is empty: it runs from {element.earliest} to {element.latest}{found}",
    fix="use a latest time after the earliest one, or the same time with both ends included",
    guard=lambda interval, index: (
        interval.latest is not None and interval_finite.check(interval, index) is True
    ),
)
def interval_not_empty(interval: pn.TimeInterval, index: Index) -> Outcome:
    """A time interval contains a time."""
    assert interval.latest is not None
    earliest, latest = fraction_of(interval.earliest), fraction_of(interval.latest)
    if earliest == latest and (interval.earliestExcluded or interval.latestExcluded):
        return ", ends excluded"
    return earliest <= latest or ""


@constraint("priorities run in a circle: {found}", fix="remove one of these overrides")
def overrides_acyclic(transition: pn.Transition, index: Index) -> Outcome:
    """No transition has, over others, a higher priority than itself."""
    return circles(index, pn.Transition, _overridden).get(transition, True)


def _overridden(transition: pn.Transition) -> list[pn.Transition]:
    return list(transition.overrides)


@constraint("{it} lies at ({element.x}, {element.y})", fix="use finite numbers")
def layout_finite(point: pn.Point, index: Index) -> Outcome:
    """Positions, offsets and sizes are finite numbers."""
    return math.isfinite(point.x) and math.isfinite(point.y)


@constraint(
    "{it} ends on {element.until!r}, which is not a date",
    fix="write the date as 2027-03-31, or omit it",
    guard=lambda suppression, index: suppression.until is not None,
)
def suppression_until_day(suppression: pn.Suppression, index: Index) -> Outcome:
    """A suppression ends on a day of the calendar, written as YYYY-MM-DD."""
    try:
        return date.fromisoformat(suppression.until or "").isoformat() == suppression.until
    except ValueError:
        return False


@constraint("{it} gives no reason", fix="write why the finding is accepted")
def suppression_has_reason(suppression: pn.Suppression, index: Index) -> Outcome:
    """A suppression gives the reason why the finding is accepted."""
    return bool((suppression.reason or "").strip())
