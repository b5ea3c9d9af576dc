"""Firing intervals as TINA writes them into PNML: MathML inside of ``<delay>``; and its test arcs.

Without time, a read arc is written as a pair of normal arcs, which every reader understands. With time, such
a pair would restart the clocks of others, so a net with intervals gets arcs of the type ``test``. TINA
compares the marking with the weight of a test arc alone and DiNeROS with the sum of what is taken and read.
"""

from __future__ import annotations

import math
from collections import Counter

from lxml import etree

from dineros.metamodel import elements, pn, rtm, sym
from dineros.metamodel.files.exact import decimal_text, fraction_of
from dineros.metamodel.files.pnml.records import ArcRecord, NetRecord, NodeRecord
from dineros.metamodel.files.pnml.vocabulary import MATHML, tag


def write_delay(xml: etree._Element, transition: pn.Transition) -> set[str]:
    """Add the interval of a transition; return the features that it expresses without loss."""
    interval = transition.interval
    if interval is None or not _is_sayable(interval):
        return set()
    delay = etree.SubElement(xml, tag("delay"))
    inside = etree.SubElement(delay, f"{{{MATHML}}}interval", nsmap={None: MATHML})  # type: ignore[dict-item]
    is_open_above = interval.latest is None or interval.latestExcluded
    inside.set(
        "closure",
        {
            (False, False): "closed",
            (True, True): "open",
            (False, True): "closed-open",
            (True, False): "open-closed",
        }[bool(interval.earliestExcluded), bool(is_open_above)],
    )
    _bound(inside, interval.earliest)
    if interval.latest is None:
        etree.SubElement(inside, f"{{{MATHML}}}ci").text = "infty"
    else:
        _bound(inside, interval.latest)
    return {"interval"}


def _is_sayable(interval: pn.TimeInterval) -> bool:
    """Return whether reading the interval again gives this one; a reader refuses empty ones."""
    bounds = [interval.earliest, *([] if interval.latest is None else [interval.latest])]
    if not all(math.isfinite(bound) and bound >= 0 for bound in bounds):
        return False
    if interval.latest is None:
        return not interval.latestExcluded
    low, high = fraction_of(interval.earliest), fraction_of(interval.latest)
    return low < high or (low == high and not (interval.earliestExcluded or interval.latestExcluded))


def _bound(xml: etree._Element, bound: float) -> None:
    number = etree.SubElement(xml, f"{{{MATHML}}}cn")
    exact = fraction_of(bound)
    text = decimal_text(exact)
    if text is not None:
        number.text = text
        return
    number.set("type", "rational")
    number.text = str(exact.numerator)
    etree.SubElement(number, f"{{{MATHML}}}sep").tail = str(exact.denominator)


class TestArcs:
    """Which read arcs of a net are written as test arcs; all others become a pair of normal arcs."""

    __test__ = False  # not a test of pytest

    def __init__(self, net: pn.Net) -> None:
        is_plain = not isinstance(net, (sym.SystemModel, rtm.RuntimeModel))
        self._has_times = is_plain and any(t.interval is not None for t in elements.transitions(net))
        self._taken = {
            _ends(arc) for arc in (elements.arcs(net) if self._has_times else ()) if str(arc.kind) == "normal"
        }

    def __contains__(self, arc: pn.Arc) -> bool:
        return self._has_times and str(arc.kind) == "read" and _ends(arc) not in self._taken


def _ends(arc: pn.Arc) -> tuple[pn.Node, pn.Node]:
    return elements.resolve(arc.source), elements.resolve(arc.target)


def convert_test_arcs(net: NetRecord) -> None:
    """Limit test arcs to tokens that their transition does not take; remove test arcs that read nothing."""
    if not any(arc.kind == "read" for arc in net.arcs):
        return
    taken: Counter[tuple[str, str]] = Counter()
    for arc in net.arcs:
        if arc.kind == "normal" and not (arc.extension.mark("half") or arc.extension.mark("kind")):
            taken[_resolved(net, arc)] += arc.weight
    kept = []
    for arc in net.arcs:
        if arc.kind == "read":
            arc.weight -= taken[_resolved(net, arc)]
        if arc.weight < 1:
            del net.ids[arc.id]
        else:
            kept.append(arc)
    net.arcs = kept


def _resolved(net: NetRecord, arc: ArcRecord) -> tuple[str, str]:
    return _target(net, arc.source), _target(net, arc.target)


def _target(net: NetRecord, id: str) -> str:
    seen = set()
    while id not in seen:
        seen.add(id)
        record = net.ids.get(id)
        if isinstance(record, NodeRecord) and record.ref is not None:
            id = record.ref
    return id
