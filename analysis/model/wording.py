"""What elements of a flattened net are in the words of the system model: channel, queue, client, clause."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, TypeVar

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.under_way import outstanding
from dineros.metamodel.calls import UNLIMITED, exits, server_pages, serving
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.elements import node_net_of

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

E = TypeVar("E", bound=EObject)


def words(link: Link) -> str:
    """Return what an element of the net is, or what its firing does, as a modeller would say it."""
    return f"{_words(link)} ({link.values})" if link.values else _words(link)


def _words(link: Link) -> str:
    meaning = link.meaning
    if meaning is not None:
        from_page = meaning.on_server_page if link.client_index is not None else ""
        return (from_page or meaning.words).format_map(_Parts(link))
    original = link.sources[0] if link.sources else None
    if link.role in ("place", "transition") and original is not None:
        return f"{_id(original)}{_copy_words(link)}"
    return link.target.id


def _copy_words(link: Link) -> str:
    """Return which server instance or slot has a copy of an element of the model."""
    if link.index is None:
        return ""
    return f" of {'slot' if link.rule.startswith('A6') else 'server instance'} {link.index}"


def queue_words(link: Link) -> str:
    """Return the queue that an element belongs to."""
    assert link.meaning is not None, "it belongs to a queue"
    return link.meaning.called.format_map(_Parts(link))


def queue_end(link: Link) -> EObject:
    """Return the place of the port whose queue an element belongs to.

    Of a dispatcher it is the node net, of a service the entry of its server, of responses and feedback the
    client's place.
    """
    port = topic_port(link)
    if link.meaning is not None and link.meaning.queue == "response":
        return source_of(link, sym.ClientPort).response
    if service := next((each for each in link.sources if isinstance(each, sym.ServiceChannel)), None):
        return service.server.entry
    if link.meaning is not None and link.meaning.queue == "goal":
        return source_of(link, sym.ActionChannel).server.entry
    if link.meaning is not None and link.meaning.queue in ("result", "answer"):
        return source_of(link, sym.ActionClientPort).goal
    if client := next((each for each in link.sources if isinstance(each, sym.ActionClientPort)), None):
        return client.goal if client.feedback is None else client.feedback
    return source_of(link, sym.NodeNet) if port is None else port.place


def topic_port(link: Link) -> sym.TopicPort | None:
    """Return the port whose queue an element belongs to; a dispatcher has none."""
    return next((source for source in link.sources if isinstance(source, sym.TopicPort)), None)


def client_words(link: Link) -> str:
    """Return the client of a call: ``client c1``, or the server instance that calls from its own page."""
    sender = next((source for source in link.sources if isinstance(source, sym.ActionClientPort)), None)
    if sender is not None:
        return f"client {sender.client}"
    client = source_of(link, sym.ClientPort)
    if link.client_index is None or client.channel is None or client.channel.model is None:
        return f"client {client.client}"
    pages = server_pages(client.channel.model)
    caller = serving(client.request, pages)
    if isinstance(caller, sym.ActionChannel):
        words = f"slot {link.client_index} of action {caller.action}"
    else:
        assert caller is not None
        words = f"instance {link.client_index} of service {caller.service}"
    beside = [other for other in client.channel.clients if serving(other.request, pages) is caller]
    return words if len(beside) == 1 else f"client {client.client} of {words}"


def source_of(link: Link, kind: type[E]) -> E:
    """Return the element of a class that a rule matched; there must be one."""
    return next(source for source in link.sources if isinstance(source, kind))


def signal_setting(link: Link) -> SignalSetting | None:
    """Return the value of a signal that an element represents; None: it represents none."""
    if link.meaning is None or link.meaning.value is None:
        return None
    values = [source for source in link.sources if isinstance(source, sym.SignalValue)]
    return str(values[-1].name) if values else link.meaning.value


def _id(element: EObject) -> str:
    return str(getattr(element, "name", None) or getattr(element, "id", None) or type(element).__name__)


def _writer(link: Link) -> str:
    """Return which instance of a server page it is that writes to a queue that all of them share."""
    server = next((source for source in link.sources if isinstance(source, sym.ServerPort)), None)
    slots = next((source for source in link.sources if isinstance(source, sym.ActionServerPort)), None)
    if slots is not None and link.index is not None:
        return f" of slot {link.index}" + (f" of action {slots.channel.action}" if slots.channel else "")
    if server is None or link.index is None:
        return ""
    return f" of instance {link.index}" + (f" of service {server.channel.service}" if server.channel else "")


def _with_instance(link: Link, element: EObject) -> str:
    """Return an element of the model, and whose it is where server instances or slots have copies."""
    if link.index is None:
        return _id(element)
    model: EObject | None = element
    while model is not None and not isinstance(model, pn.Net):
        model = model.eContainer()
    served = None if model is None else serving(element, server_pages(model))
    if served is None:
        return _id(element)  # the index is that of one of its clocks
    is_slot = isinstance(served, sym.ActionChannel)
    return f"{_id(element)} of {'slot' if is_slot else 'server instance'} {link.index}"


def _server_node(service: sym.ServiceChannel) -> EObject:
    """Return the node net that serves; the service where none does."""
    return node_net_of(service.server.entry) or service


def _waits(link: Link) -> str:
    """Return what a client does whose request is lost."""
    client = source_of(link, sym.ClientPort)
    if client.timeout is not None:
        return "waits until its time-out"
    return "never gets a response" if outstanding(client) == UNLIMITED else "waits forever"


def outcome_words(link: Link) -> str:
    """Return how a goal ends by an exit of its server."""
    action = source_of(link, sym.ActionChannel)
    outcomes = exits(action.server)
    return next(outcomes[source] for source in link.sources if source in outcomes)


_PARTS: dict[str, Callable[[Link], object]] = {
    "topic": lambda link: source_of(link, sym.TopicChannel).topic,
    "service": lambda link: source_of(link, sym.ServiceChannel).service,
    "action": lambda link: source_of(link, sym.ActionChannel).action,
    "outcome": outcome_words,
    "signal": lambda link: _id(source_of(link, sym.InputSignal)),
    "value": signal_setting,
    "client": client_words,
    "instance": lambda link: link.index,
    "publisher": lambda link: _id(source_of(link, sym.PublisherPort).place),
    "subscriber": lambda link: _id(source_of(link, sym.SubscriberPort).place),
    "place": lambda link: _with_instance(link, source_of(link, pn.Place)),
    "callback": lambda link: f"callback {_with_instance(link, source_of(link, sym.CallbackPage))}",
    "group": lambda link: _id(source_of(link, sym.CallbackGroup)),
    "node": lambda link: _id(node_net_of(link.sources[0]) or link.sources[0]),
    "writing": lambda link: _id(node_net_of(source_of(link, sym.PublisherPort).place) or link.sources[0]),
    "reading": lambda link: _id(node_net_of(source_of(link, sym.SubscriberPort).place) or link.sources[0]),
    "serving": lambda link: _id(_server_node(source_of(link, sym.ServiceChannel))),
    "queue": queue_words,
    "queue_kind": lambda link: link.meaning and link.meaning.queue,
    "queue_end": lambda link: _id(queue_end(link)),
    "writer": _writer,
    "waits": _waits,
}


class _Parts(dict[str, object]):
    """The names that words may hold, found when they are asked for."""

    def __init__(self, link: Link) -> None:
        super().__init__()
        self._link = link

    def __missing__(self, name: str) -> object:
        return _PARTS[name](self._link)
