"""Capacities of places by rules B1 to B3, and which transitions need room.

`Enabling` applies them as rule B4 does: a firing needs room for its net increase of tokens, so a loop needs
none.

Places without a capacity also have a limit if other participants can fill them by messages, requests or
goals: a participant that floods a topic must not exhaust the memory. A place at its limit delays firings and
messages. The model allows every delay, so a run that reaches a limit still conforms.
"""

from __future__ import annotations

from collections.abc import Sequence

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import ports_in

Arcs = tuple[tuple[int, int], ...]
"""Pairs of a place's index and a weight, in arc order; each place occurs once."""

MOST_TOKENS = 10_000
"""Most tokens on a place that others can fill, if the model gives no capacity."""

_UNLIMITED = -1
"""Value of `inHand` with which a node takes any number of messages."""


def _hands_over(port: rtm.PlacePort) -> bool:
    """Return whether a port sends each token of its place at once, so that no token waits there."""
    if isinstance(port, rtm.ClientPort):
        return port.outstanding == UNLIMITED
    return isinstance(port, rtm.PublisherPort)


def capacities_of(
    model: rtm.RuntimeModel,
    nodes: Sequence[tuple[pn.Node, int]],
    inputs: Sequence[Arcs],
    outputs: Sequence[Arcs],
    reads: Sequence[Arcs],
) -> tuple[int | None, ...]:
    """Return the capacity of each place; None: it holds any number of tokens.

    Parameters
    ----------
    model : rtm.RuntimeModel
        The model, for its middleware.
    nodes : sequence of (pn.Node, int)
        The places, each with the number of its server instance.
    inputs, outputs, reads : sequence of Arcs
        For each transition, the tokens it takes and puts, and the total number needed on the places it reads.
    """
    declared = [place.capacity if isinstance(place, pn.Place) else None for place, _ in nodes]
    if model.middleware != sym.Middleware.ros2:
        return tuple(declared)
    puts, needs = _heaviest(outputs, len(nodes)), _heaviest((*inputs, *reads), len(nodes))
    lowered = {place for place, change in _changes(inputs, outputs) if change < 0}
    sending = _sending(model)
    canceled, told, heard = _ends_of_goals(model)
    recalls = _requests_to_cancel(model)
    found = []
    for number, (place, _) in enumerate(nodes):
        bounds = [] if declared[number] is None else [declared[number]]
        if not bounds and isinstance(place, rtm.Place):
            if any(_hands_over(port) for port in place.ports):
                bounds.append(max(1, place.tokens, puts[number]))
            if number in lowered or place in sending:
                bounds += [
                    max(1, place.tokens, needs[number]) if port.inHand is None else port.inHand
                    for port in place.ports
                    if isinstance(port, rtm.SubscriberPort) and port.inHand != _UNLIMITED
                ]
                bounds += [max(1, place.tokens, needs[number])] if place in heard else []
        bounds += [1] if place in canceled else []
        if place in recalls:
            initial = place.tokens if isinstance(place, pn.Place) else 0
            bounds.append(recalls[place] + max(1, initial, puts[number]))
        if not bounds and place in told:
            bounds.append(max(1, place.tokens if isinstance(place, pn.Place) else 0, puts[number]))
        found.append(min((bound for bound in bounds if bound is not None), default=None))
    return tuple(found)


def limits_of(
    capacities: Sequence[int | None],
    nodes: Sequence[tuple[pn.Node, int]],
    inputs: Sequence[Arcs],
    outputs: Sequence[Arcs],
) -> tuple[int | None, ...]:
    """Return the most tokens that each place holds in a run; None: any number.

    This is the capacity, if there is one. Otherwise it is `MOST_TOKENS` for places that receive messages,
    requests or goals, and for places that their tokens can reach by firings; or ten times the initial tokens,
    or ten times the tokens put at once, if that is more. It also applies to a subscriber whose `inHand` is
    unlimited.

    Parameters
    ----------
    capacities : sequence of int or None
        Result of `capacities_of`.
    nodes, inputs, outputs
        As for `capacities_of`.
    """
    arriving, unlimited = set(), set()
    for number, (place, _) in enumerate(nodes):
        for port in place.ports if isinstance(place, rtm.Place) else ():
            if isinstance(port, (rtm.SubscriberPort, rtm.ServerPort, rtm.ActionServerPort)):
                arriving.add(number)
            if isinstance(port, rtm.SubscriberPort) and port.inHand == _UNLIMITED:
                unlimited.add(number)
    filled = _reached(arriving, inputs, outputs) - unlimited
    puts = _heaviest(outputs, len(nodes))
    found = list(capacities)
    for number in filled:
        place = nodes[number][0]
        least = max(place.tokens if isinstance(place, pn.Place) else 0, puts[number])
        if found[number] is None:
            found[number] = max(MOST_TOKENS, 10 * least)
    return tuple(found)


def _reached(start: set[int], inputs: Sequence[Arcs], outputs: Sequence[Arcs]) -> set[int]:
    """Return the places that tokens of some places can reach by firings, including these places."""
    takers: dict[int, list[int]] = {}
    for transition, taken in enumerate(inputs):
        for place, _ in taken:
            takers.setdefault(place, []).append(transition)
    found, waiting = set(start), list(start)
    while waiting:
        for transition in takers.get(waiting.pop(), ()):
            new = {place for place, _ in outputs[transition]} - found
            found |= new
            waiting.extend(new)
    return found


def raises_of(
    capacities: Sequence[int | None], inputs: Sequence[Arcs], outputs: Sequence[Arcs]
) -> tuple[Arcs, ...]:
    """Return, for each transition, the places with a capacity that it raises, and by how many tokens."""
    return tuple(
        tuple(
            (place, change)
            for place, change in _changes([taken], [put])
            if change > 0 and capacities[place] is not None
        )
        for taken, put in zip(inputs, outputs, strict=True)
    )


def _changes(inputs: Sequence[Arcs], outputs: Sequence[Arcs]) -> list[tuple[int, int]]:
    """Return the change of the token count of each place around each transition."""
    found = []
    for taken, put in zip(inputs, outputs, strict=True):
        change = dict(put)
        for place, weight in taken:
            change[place] = change.get(place, 0) - weight
        found += list(change.items())
    return found


def _heaviest(arcs: Sequence[Arcs], places: int) -> list[int]:
    found = [0] * places
    for each in arcs:
        for place, weight in each:
            found[place] = max(found[place], weight)
    return found


def _sending(model: rtm.RuntimeModel) -> set[pn.Node]:
    """Return the places whose tokens a port sends."""
    found: set[pn.Node] = set()
    for place, port in ports_in(model):
        if isinstance(port, (rtm.PublisherPort, rtm.ClientPort)):
            found.add(place)
        elif isinstance(port, rtm.ServerPort):
            found.add(port.exit)
        elif isinstance(port, rtm.ActionClientPort):
            found |= {place} if port.cancel is None else {place, port.cancel}
    return found


def _ends_of_goals(model: rtm.RuntimeModel) -> tuple[set[pn.Node], set[pn.Node], set[pn.Node]]:
    """Return the action places: servers' cancel requests, servers' feedback, clients' feedback."""
    ports = [port for _, port in ports_in(model)]
    servers = [port for port in ports if isinstance(port, rtm.ActionServerPort)]
    clients = [port for port in ports if isinstance(port, rtm.ActionClientPort)]
    return (
        {port.cancel for port in servers if port.cancel is not None},
        {port.feedback for port in servers if port.feedback is not None},
        {port.feedback for port in clients if port.feedback is not None},
    )


def _requests_to_cancel(model: rtm.RuntimeModel) -> dict[pn.Node, int]:
    """Return the cancel-request places of clients, and the most goals that each client has under way."""
    ports = [port for _, port in ports_in(model) if isinstance(port, rtm.ActionClientPort)]
    return {port.cancel: max(1, port.outstanding) for port in ports if port.cancel is not None}
