"""Several token types: ports of a channel agree, installed messages are known, and what needs a handler."""

from __future__ import annotations

from collections.abc import Iterable

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import PARTS_OF_GOALS, goal_parts
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.token_types.installed import UnknownInterfaceError, installed_fields
from dineros.metamodel.token_types.passing import passing


def _name(token_type: sym.TokenType | None) -> str:
    return repr(token_type.id) if token_type is not None else "no token type"


def _disagreement(places: Iterable[pn.Node | None], index: Index) -> str | None:
    """Return two places whose tokens have different types, in words; None if all agree."""
    there = [place for place in places if place is not None]
    for place in there[1:]:
        first, other = index.token_type_of(there[0]), index.token_type_of(place)
        if first is not other:
            return f"{describe(there[0])} has {_name(first)}, {describe(place)} has {_name(other)}"
    return None


@constraint("{it} joins places of different token types: {found}", fix="give the places one token type")
def topic_has_one_type(channel: sym.TopicChannel, index: Index) -> Outcome:
    """The places of a topic's publishers and subscribers have one token type."""
    return _disagreement((p.place for p in (*channel.publishers, *channel.subscribers)), index) or True


@constraint(
    "{it} has requests of different token types: {found}",
    fix="give the request places of clients and the server's entry one token type",
)
def requests_have_one_type(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """The request places of a service's clients and its entry have one token type."""
    return _disagreement([channel.server.entry, *(port.request for port in channel.clients)], index) or True


@constraint(
    "{it} has responses of different token types: {found}",
    fix="give the response places of clients and the server's exit one token type",
)
def responses_have_one_type(channel: sym.ServiceChannel, index: Index) -> Outcome:
    """The response places of a service's clients and its exit have one token type."""
    return _disagreement([channel.server.exit, *(port.response for port in channel.clients)], index) or True


@constraint(
    "{it} has {found}",
    fix="give the places of goals, those of results and those of feedback one token type each",
)
def parts_of_goals_have_one_type(channel: sym.ActionChannel, index: Index) -> Outcome:
    """The places of an action's goals have one token type, so do those of its results and of its feedback."""
    for part, places in goal_parts(channel).items():
        if (found := _disagreement(places, index)) is not None:
            return f"{_PLURALS[part]} of different token types: {found}"
    return True


_PLURALS = {"goal": "goals", "result": "results", "feedback": "feedback"}


def _parts(channel: sym.Channel) -> tuple[str, ...]:
    """Return the parts of a channel's interface."""
    if isinstance(channel, sym.TopicChannel):
        return ("message",)
    return PARTS_OF_GOALS if isinstance(channel, sym.ActionChannel) else ("request", "response")


@constraint(
    "{it} has the type {element.type!r}, but its tokens are the ROS message {found}",
    fix="omit the type of the channel, or give its places a token type with fields of its own",
    guard=lambda channel, index: bool(channel.type),
)
def channel_type_of_tokens(channel: sym.Channel, index: Index) -> Outcome:
    """A channel whose tokens are ROS messages has no other type than theirs."""
    for part in _parts(channel):
        place = index.place_of_part(channel, part)
        carried = index.token_type_of(place) if place is not None else None
        if carried is not None and carried.ros and carried.ros != channel.type:
            return carried.ros
    return True


@constraint(
    "{it} is not a ROS message that tokens can be: {found}",
    fix="name one such as std_msgs/msg/String",
    guard=lambda token_type, index: token_type.ros is not None,
)
def ros_message_known(token_type: sym.TokenType, index: Index) -> Outcome:
    """The ROS message that a token type names is one of its package, if the package is installed."""
    try:
        installed_fields(token_type.ros or "")
    except UnknownInterfaceError as error:
        return error.is_missing or error
    return True


@constraint(
    "{it} has fields and is the ROS message {element.ros!r}",
    fix="remove the fields: a ROS message brings its own",
    guard=lambda token_type, index: token_type.ros is not None,
)
def ros_message_has_fields(token_type: sym.TokenType, index: Index) -> Outcome:
    """A token type that is a ROS message declares no fields of its own."""
    return len(token_type.fields) == 0


@constraint(
    "{it} puts tokens of a type that it does not take: {found}",
    fix="write a handler that makes them; without one they carry the defaults",
    severity="warning",
    guard=lambda transition, index: bool(_others(index)),
)
def type_change_has_handler(transition: pn.Transition, index: Index) -> Outcome:
    """A transition takes a token of each type that it puts; if not, its handler makes the data."""
    table = index.once("arcs of transitions", lambda: _arcs(index))
    inputs, outputs, reads = table.get(transition, ({}, {}, []))
    goes_on = passing(list(inputs.items()), list(outputs.items()), reads, index.token_type_of)
    made = [f"{_name(index.token_type_of(place))} in {describe(place)}" for place in goes_on.made]
    return not made or " and ".join(made)


def _others(index: Index) -> bool:
    return bool(getattr(index.net, "otherTokenTypes", ()))


_Weights = dict[pn.Node, int]


def _arcs(index: Index) -> dict[pn.Node, tuple[_Weights, _Weights, list[pn.Node]]]:
    """Return the places that each transition takes from, puts to and reads, with weights."""
    found: dict[pn.Node, tuple[_Weights, _Weights, list[pn.Node]]] = {}
    for arc in index.all(pn.Arc):
        source, target = index.final(arc.source), index.final(arc.target)
        if arc.kind == pn.ArcKind.inhibitor or source is None or target is None:
            continue
        takes = isinstance(source, pn.Place)
        transition, place = (target, source) if takes else (source, target)
        inputs, outputs, reads = found.setdefault(transition, ({}, {}, []))
        if arc.kind == pn.ArcKind.read:
            reads.append(place)
        else:
            table = inputs if takes else outputs
            table[place] = table.get(place, 0) + arc.weight
    return found
