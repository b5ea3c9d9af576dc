"""Attributes and elements that a P/T net in PNML may have, and what becomes of each.

The standard has few (ISO/IEC 15909-2, clause 7); other tools add theirs. Listed are those that are read and
those that do not concern the behaviour. Everything else is refused: a reader that drops an attribute such as
``type="inhibitor"`` silently changes the net.
"""

from __future__ import annotations

_XML = "{http://www.w3.org/XML/1998/namespace}"
_SCHEMA = "{http://www.w3.org/2001/XMLSchema-instance}"
HARMLESS_NAMESPACES = (_XML, _SCHEMA)
"""Namespaces of attributes that never concern the net."""

DRAWN = frozenset(
    {
        *("positionX", "positionY", "nameOffsetX", "nameOffsetY", "markingOffsetX", "markingOffsetY"),
        *("x", "y", "width", "height", "angle", "color", "colour", "displayName", "visible", "invisible"),
        *("constantId", "constantid", "selected", "distinctPending", "label", "description"),
    }
)
"""Attributes of any element that only a drawing or a list of names needs."""

ATTRIBUTES: dict[str, frozenset[str]] = {
    "net": DRAWN | {"id", "type", "name", "active"},
    "page": DRAWN | {"id", "name"},
    "place": DRAWN | {"id", "name", "initialMarking", "capacity", "invariant"},
    "transition": DRAWN
    | {"id", "name", "priority", "urgent", "timed", "player", "infiniteServer"}
    | {"distribution", "a", "b", "weight", "firingMode", "rate"},
    "referencePlace": DRAWN | {"id", "name", "ref"},
    "referenceTransition": DRAWN | {"id", "name", "ref"},
    "arc": DRAWN | {"id", "name", "source", "target", "type", "weight", "inscription", "transportID"},
}
"""Attributes that are read, checked (see `plain.values` and `plain.net_wide`) or harmless."""

DISTRIBUTION = frozenset({"value", "c", "mean", "stddev", "shape", "scale", "logMean", "logStddev"})
"""Attributes of a transition with a distribution: its parameters, besides `a`, `b` and `rate`."""

COLOURED_ATTRIBUTES = DRAWN | {"id", "type", "name", "ref", "source", "target"}
"""Attributes of any element of a symmetric net, whose values are in elements."""

_ANY = frozenset({"name", "graphics", "toolspecific", "description"})
_NODES = frozenset({"place", "transition", "referencePlace", "referenceTransition", "arc"})
_PAGES = frozenset({"page", "nodePage"})

ELEMENTS: dict[str, frozenset[str]] = {
    "net": _ANY | _NODES | _PAGES | {"token", "labels", "definition", "stategroup", "finalmarkings"},
    "page": _ANY | _NODES | _PAGES | {"labels"},
    "place": _ANY | {"initialMarking", "capacity", "text", "tagged", "label"},
    "transition": _ANY | {"delay", "priority", "timed", "rate", "orientation", "infiniteServer", "label"},
    "referencePlace": _ANY,
    "referenceTransition": _ANY,
    "arc": _ANY | {"inscription", "type", "arctype", "arcpath", "tagged"},
}
"""Elements that are read, checked or harmless, by the element that they are in."""

BESIDE_NET = frozenset({"net", "toolspecific", "query", "queries", "k-bound", "feature", "constant"})
"""Elements next to the net, which ask about it or say how its tool opens it."""

TEXTS = frozenset({"name", "rate"})
"""Labels of which only the form is checked."""

LEFT_OUT = {
    "finalmarkings": "final markings left out",
    "rate": "rates left out",
    "distribution": "rates left out",
    "player": "players left out: every transition may fire",
}
"""Elements that have a meaning and are not read: a note names them."""

MEANINGS = {
    "marking": "a marking is <initialMarking><text>3</text></initialMarking>",
    "tokens": "a marking is <initialMarking><text>3</text></initialMarking>",
    "multiplicity": "a weight is <inscription><text>3</text></inscription>",
    "weight": "a weight is <inscription><text>3</text></inscription>",
    "inhibitor": 'write <arc type="inhibitor">',
    "reset": "a reset arc takes all tokens, which arcs cannot express here",
    "time": "a firing interval is a <delay> with an interval in MathML",
    "guard": "a guard is a condition on data",
    "readVariable": "the transition depends on data",
    "writeVariable": "the transition changes data",
    "variables": "the net has data",
    "hlinitialMarking": "it is a coloured net",
    "hlinscription": "it is a coloured net",
    "condition": "it is a coloured net",
    "declaration": "it is a coloured net",
    "structure": "it is a coloured net",
    "net": "a net inside of a page refines a transition; write the net flat",
    "inhibitorArc": 'write <arc type="inhibitor">',
    "inputArc": "write <arc>",
    "outputArc": "write <arc>",
    "transportArc": "it is a net with time",
    "shared-place": "one net is read; write the composed net",
    "shared-transition": "one net is read; write the composed net",
}
"""Hints for well-known attributes and elements that are refused."""
