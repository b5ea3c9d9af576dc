"""Reads the ports of a runtime model as plain values; server pages have ports for each instance."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TypeVar

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.callbacks.bodies import Body, calls_of, timers_of
from dineros.metamodel.calls import UNLIMITED, copy_id
from dineros.metamodel.clauses import start_value, value_names
from dineros.metamodel.elements import label, pages, ports_in
from dineros.metamodel.lifecycles.start_order import start_steps
from dineros.metamodel.matching import Quality, plain
from dineros.metamodel.token_data import TokenType
from dineros.runtime.nets import ports as plain_ports

P = TypeVar("P", bound=plain_ports.Port)
PagePort = rtm.ServerPort | rtm.ActionServerPort
"""A port whose page is copied for each server instance, or for each slot."""
MOST_UNDER_WAY = 1000
"""Bound of the requests under way of a client without a limit of its own."""


def served_pages(model: rtm.RuntimeModel) -> dict[pn.Page, PagePort]:
    """Return the pages that are copied, with their ports."""
    found = (port for _, port in ports_in(model))
    return {port.page: port for port in found if isinstance(port, (rtm.ServerPort, rtm.ActionServerPort))}


def _under_way(port: rtm.ClientPort | rtm.ServerPort) -> int:
    """Return the most requests that a client of a port has under way."""
    return MOST_UNDER_WAY if port.outstanding == UNLIMITED else port.outstanding


def _callbacks(model: rtm.RuntimeModel) -> Iterator[plain_ports.CallbackPort]:
    """Yield the callbacks with the times that the model declares."""
    timers, calls = set(timers_of(model)), calls_of(model)
    for page in pages(model):
        if not isinstance(page, sym.CallbackPage):
            continue
        body, is_timed = Body(page, calls), page in timers
        duration = page.duration
        yield plain_ports.CallbackPort(
            callback=page.id,
            transitions=frozenset(each.id for each in body.transitions),
            begins=frozenset(each.id for each in body.beginnings()) if is_timed else frozenset(),
            ends=frozenset(each.id for each in body.ends()),
            duration=None if duration is None else (float(duration.earliest), duration.latest),
            period=float(page.timer or 0.0) if is_timed else 0.0,
            jitter=float(page.jitter or 0.0),
        )


class PortReading:
    """Reads the ports of a node.

    Parameters
    ----------
    model : rtm.RuntimeModel
        The model.
    copies : mapping
        Place and number of its server instance (0: not on a server page) -> its index.
    ids : sequence of str
        Ids of the places in the running net, by index.
    prototypes : mapping
        For each node on a copied page, that page.
    type_at : callable
        Returns the token type of a place.
    """

    def __init__(
        self,
        model: rtm.RuntimeModel,
        copies: Mapping[tuple[pn.Node, int], int],
        ids: Sequence[str],
        prototypes: Mapping[pn.Node, pn.Page],
        type_at: Callable[[pn.Node], TokenType],
    ) -> None:
        self._model = model
        self._places = copies
        self._ids = ids
        self._prototypes = prototypes
        self._type_at = type_at
        self._servers = served_pages(model)

    def ports(self, token_type: TokenType, place_types: Mapping[str, TokenType]) -> plain_ports.Ports:
        """Return all ports.

        Parameters
        ----------
        token_type : TokenType
            Token type of places that name no other type.
        place_types : mapping
            Token types of the other places, by id.
        """
        found = [
            self._plain(place, port, number)
            for place, number in self._places
            if isinstance(place, rtm.Place)
            for port in place.ports
            if number <= 1 or isinstance(port, (rtm.ClientPort, rtm.ActionClientPort))
        ]
        model, node = self._model, self._model.node
        return plain_ports.Ports(
            model=model.systemModel,
            node=node.id,
            name=label(node),
            namespace=node.namespace or "",
            executor=str(node.executor),
            threads=node.threads,
            middleware=str(model.middleware),
            token_type=token_type,
            publishers=_of(plain_ports.PublisherPort, found),
            subscribers=_of(plain_ports.SubscriberPort, found),
            clients=_of(plain_ports.ClientPort, found),
            servers=_of(plain_ports.ServerPort, found),
            signals=tuple(
                plain_ports.SignalPort(s.id, label(s), start_value(s), value_names(s)) for s in node.signals
            ),
            timers=tuple(plain_ports.TimerPort(page.id, page.timer or 0.0) for page in timers_of(model)),
            callbacks=tuple(_callbacks(model)),
            action_clients=_of(plain_ports.ActionClientPort, found),
            action_servers=_of(plain_ports.ActionServerPort, found),
            place_types=dict(place_types),
            start_steps=start_steps(node) if str(model.middleware) == "ros2" else {},
            pauses=node.lifecycle is not None and bool(node.lifecycle.pauses),
        )

    def _plain(self, place: rtm.Place, port: rtm.PlacePort, number: int) -> plain_ports.Port:
        """Return a port as plain values; with a number, the port of that server instance."""
        common = (port.channel, self._interface(place, port), _mappings(port))
        match port:
            case rtm.PublisherPort():
                topic = (port.topic, place.id, port.limit, _quality(port, common[1]))
                return plain_ports.PublisherPort(*(*common, *topic), self._copies(place))
            case rtm.SubscriberPort():
                topic = (port.topic, place.id, port.limit, _quality(port, common[1]))
                missed = self._at(port.missed, number)
                return plain_ports.SubscriberPort(*(*common, *topic), port.dispatcherLimit, missed)
            case rtm.ClientPort():
                asked, answered = (self._ids[self._places[at, number]] for at in (place, port.response))
                return plain_ports.ClientPort(
                    *common,
                    service=port.service,
                    client=self._client(place, port.client, number),
                    request=asked,
                    response=answered,
                    outstanding=_under_way(port),
                    timeout=port.timeout,
                    timed_out=self._at(port.timedOut, number),
                )
            case rtm.ServerPort():
                ends = self._copies(place), self._copies(port.exit)
                return plain_ports.ServerPort(*common, port.service, *ends, port.depth, _under_way(port))
            case rtm.ActionClientPort():
                return plain_ports.ActionClientPort(
                    *(*common, port.action, port.depth),
                    client=self._client(place, port.client, number),
                    goal=self._at(place, number) or place.id,
                    outcomes={
                        outcome: at
                        for outcome in plain_ports.OUTCOMES
                        if (at := self._at(getattr(port, outcome), number)) is not None
                    },
                    rejected=self._at(port.rejected, number),
                    cancel=self._at(port.cancel, number),
                    feedback=self._at(port.feedback, number),
                    outstanding=port.outstanding,
                    accepted=self._at(port.accepted, number),
                )
            case rtm.ActionServerPort():
                return plain_ports.ActionServerPort(
                    *(*common, port.action, port.depth),
                    entries=self._copies(place),
                    outcomes={
                        outcome: self._copies(exit_)
                        for outcome in plain_ports.OUTCOMES
                        if (exit_ := getattr(port, outcome)) is not None
                    },
                    cancels=self._copies(port.cancel),
                    feedbacks=self._copies(port.feedback),
                    may_reject=bool(port.mayReject),
                )
        raise TypeError(f"{type(port).__name__} is not a kind of port")

    def _interface(self, place: pn.Node, port: rtm.PlacePort) -> str | None:
        """Return the existing ROS interface of a port: its own, or for a topic the one of its tokens."""
        if isinstance(port, (rtm.PublisherPort, rtm.SubscriberPort)):
            return port.type or self._type_at(place).ros
        return port.type or None

    def _client(self, place: rtm.Place, client: str, number: int) -> str:
        """Return the id of a client; with a number, that of the client in that server instance."""
        if not number:
            return client
        return copy_id(self._servers[self._prototypes[place]].channel, number, client)

    def _at(self, place: pn.Node | None, number: int) -> str | None:
        """Return the id of a place in the running net; with a number, of its copy in that server instance."""
        return None if place is None else self._ids[self._places[place, number]]

    def _copies(self, place: pn.Node | None) -> tuple[str, ...]:
        return tuple(self._ids[index] for (node, _), index in self._places.items() if node is place)


def _of(kind: type[P], ports: Sequence[plain_ports.Port]) -> tuple[P, ...]:
    return tuple(port for port in ports if isinstance(port, kind))


def _mappings(port: rtm.PlacePort) -> tuple[plain_ports.FieldMapping, ...]:
    return tuple(
        plain_ports.FieldMapping(str(mapping.part), mapping.messageField, mapping.tokenField)
        for mapping in port.mappings
    )


def _quality(port: rtm.PublisherPort | rtm.SubscriberPort, interface: str | None) -> Quality:
    """Return the quality of service of a port.

    By default, no message is lost while a node is down for a while. A port with an existing type talks to
    programs outside of the model; these have ROS's defaults, with which a transient-local subscription would
    receive nothing.
    """
    if port.qos is not None:
        return plain(port.qos)
    usual = plain(sym.QualityOfService())
    return usual if interface is not None else usual._replace(durability="transientLocal")
