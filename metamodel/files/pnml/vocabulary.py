"""Names of the PNML format, of the DiNeROS extension and of our own blocks."""

from __future__ import annotations

from typing import Literal, TypeAlias

PNML = "http://www.pnml.org/version-2009/grammar/pnml"
NAMESPACES: dict[str, str] = {None: PNML}  # type: ignore[dict-item] # the stubs forbid the default namespace
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"

MATHML = "http://www.w3.org/1998/Math/MathML"
"""Namespace of the intervals that TINA writes."""

DINEROS = "de.tudresden.inf.st.pnml.distributedPN"
"""Tool name of the DiNeROS extension."""
Version: TypeAlias = Literal["0.1", "0.2"]
VERSIONS = ("0.1", "0.2")

OWN = "org.dineros"
"""Tool name of our own blocks: what neither PNML nor the extension can say."""
OWN_VERSION = "1.0"

EDITOR = "ModernPetriEditor"
"""Tool whose block marks inhibitor arcs."""

PLACE_TYPES = {"placeStartType": "start", "placeEndType": "end"}
TRANSITION_TYPES = {
    "discreteTransitionType": "discrete",
    "timeTransitionType": "timed",
    "transitionStartType": "start",
    "transitionEndType": "end",
}
TOPIC = "topicTransitionType"
SERVICE = "serviceTransitionType"
ACTION = "actionTransitionType"
NODE_PAGE = "nodePage"
CALLBACK_TYPES = {
    "callbackTimer": "timer",
    "callbackSubscriber": "subscriber",
    "callbackServer": "server",
    "callbackClient": "client",
    "callbackGoal": "goal",
}

FIELDS: dict[str, frozenset[str]] = {
    "net": frozenset({"callbackgroups"}),
    "page": frozenset({"type", "executor", "threads", "group", "timer", "priority"}),
    "place": frozenset({"node", "subnet", "type", "balloonMarking"}),
    "transition": frozenset({"node", "subnet", "type", "inputsignalclause", "time"}),
    "reference": frozenset({"node", "subnet"}),
    "topic": frozenset({"type", "topicName", "publishers", "subscribers"}),
    "service": frozenset(
        {"type", "serviceName", "serverInput", "serverOutput", "serverCapacity", "channels"}
    ),
    "action": frozenset({"type", "actionName"}),
    "arc": frozenset(),
}
"""The extension's fields by the kind of element; other fields in its blocks are kept as they are."""

ALL_FIELDS: frozenset[str] = frozenset().union(*FIELDS.values())


def tag(name: str) -> str:
    """Return the qualified name of a PNML element."""
    return f"{{{PNML}}}{name}"
