"""Writing TINA's ``.net``: places in model order, then transitions with their arcs, then priorities."""

from __future__ import annotations

import re
from collections import defaultdict
from math import isfinite
from pathlib import Path

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import arcs, label, places, resolve, transitions
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.exact import exact_text, fraction_of

_PLAIN = re.compile(r"[A-Za-z0-9_']+")
_KEYWORDS = frozenset({"net", "tr", "pl", "lb", "pr", "nt"})


def net_text(net: pn.Net, path: Path | None = None) -> str:
    """Return a net in TINA's format; `path` is named in messages.

    Raises
    ------
    ModelFileError
        The net has channels, capacities, clauses, or bounds of intervals below 0.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    location = Location(path)
    if isinstance(net, sym.SystemModel) and len(net.channels):
        raise ModelFileError(
            "a system model with channels cannot be written as .net",
            location=location,
            hint="flatten it first",
        )
    flows = flows_of(net)
    lines = [f"net {_name(label(net))}"]
    for place in places(net):
        if place.capacity is not None:
            raise ModelFileError(
                f"place {place.id!r} has a capacity, which .net cannot express",
                location=location,
                element=place.id,
                hint="use .pnml, or .xmi",
            )
        marking = f" ({place.tokens})" if place.tokens else ""
        lines.append(f"pl {_name(place.id)}{_label(place)}{marking}")
    for transition in transitions(net):
        if isinstance(transition, sym.Transition) and transition.clause is not None:
            raise ModelFileError(
                f"transition {transition.id!r} has a clause, which .net cannot express",
                location=location,
                element=transition.id,
                hint="flatten the model first",
            )
        interval = _interval(transition, location)
        lines.append(
            f"tr {_name(transition.id)}{_label(transition)}{interval} {_arcs(flows[transition])}".rstrip()
        )
    for transition in transitions(net):
        if len(transition.overrides):
            lower = " ".join(_name(other.id) for other in transition.overrides)
            lines.append(f"pr {_name(transition.id)} > {lower}")
    return "\n".join(lines) + "\n"


Flow = dict[tuple[pn.Place, str], int]
"""Weight by place and kind of arc: the kinds of arcs, and "output" for normal arcs to the place."""


def flows_of(net: pn.Net) -> defaultdict[pn.Transition, Flow]:
    """Return the arcs of each transition with references resolved; parallel ones are added up.

    Raises
    ------
    ModelFileError
        An arc does not join a place and a transition.
    DinerosError
        A reference has no target, or references run in a circle.
    """
    flows: defaultdict[pn.Transition, Flow] = defaultdict(dict)
    for arc in arcs(net):
        source, target = resolve(arc.source), resolve(arc.target)
        if isinstance(source, pn.Place) and isinstance(target, pn.Transition):
            flow, key = flows[target], (source, str(arc.kind))
        elif isinstance(source, pn.Transition) and isinstance(target, pn.Place):
            flow, key = flows[source], (target, "output")
        else:
            raise ModelFileError(
                f"arc {arc.id!r} does not join a place and a transition",
                element=arc.id,
                hint="validate the model",
            )
        known = flow.get(key, 0)
        # Of two inhibitor arcs the lower weight is the stricter condition.
        flow[key] = min(known or arc.weight, arc.weight) if key[1] == "inhibitor" else known + arc.weight
    return flows


def _arcs(flow: Flow) -> str:
    inputs: list[str] = []
    outputs: list[str] = []
    for (place, kind), weight in flow.items():
        name = _name(place.id)
        if kind == "output":
            outputs.append(name + (f"*{weight}" if weight != 1 else ""))
        elif kind == "inhibitor":
            inputs.append(f"{name}?-{weight}")
        elif kind == "read":
            inputs.append(f"{name}?{weight + flow.get((place, 'normal'), 0)}")
        else:
            inputs.append(name + (f"*{weight}" if weight != 1 else ""))
    return " ".join([*inputs, "->", *outputs]) if flow else ""


def _interval(transition: pn.Transition, location: Location) -> str:
    interval = transition.interval
    if interval is None:
        return ""
    start = "]" if interval.earliestExcluded else "["
    earliest = _bound(interval.earliest, transition, location)
    if interval.latest is None:
        return f" {start}{earliest},w["
    end = "[" if interval.latestExcluded else "]"
    return f" {start}{earliest},{_bound(interval.latest, transition, location)}{end}"


def _bound(bound: float, transition: pn.Transition, location: Location) -> str:
    """Return the text of a bound, exactly: TINA itself takes whole numbers."""
    if not isfinite(bound) or bound < 0:
        raise ModelFileError(
            f"the interval of transition {transition.id!r} has the bound {bound}",
            location=location,
            element=transition.id,
            hint="bounds are numbers from 0",
        )
    return exact_text(fraction_of(bound))


def _label(node: pn.Node) -> str:
    return f" : {_name(node.name)}" if node.name is not None else ""


def _name(name: str) -> str:
    if _PLAIN.fullmatch(name) and name not in _KEYWORDS:
        return name
    return "{" + re.sub(r"([{}\\])", r"\\\1", name) + "}"
