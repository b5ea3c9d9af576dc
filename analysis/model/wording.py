"""What elements of a flattened net are in the words of the system model: channel, queue, client, clause."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import server_pages, serving
from dineros.transformations.flattening.traces import Link

E = TypeVar("E", bound=EObject)
PUBLISHER_QUEUES = ("T2", "T2History", "T2Instance")
"""Rules that make publishers' queues, or parts of them."""


def words(link: Link) -> str:
    """Return what an element of the net is, or what its firing does, as a modeller would say it."""
    speak = _TEXTS.get((link.rule, link.role))
    if speak is not None:
        return speak(link)
    original = link.sources[0] if link.sources else None
    if link.role in ("place", "transition") and original is not None:
        instance = f" of server instance {link.index}" if link.index is not None else ""
        return f"{_id(original)}{instance}"
    return link.target.id


def queue_words(link: Link) -> str:
    """Return the queue that an element belongs to."""
    channel = _source(link, sym.TopicChannel)
    if link.rule in PUBLISHER_QUEUES:
        return f"publisher queue of {_id(_source(link, sym.PublisherPort).place)} (topic {channel.topic})"
    if link.rule == "T3":
        return f"dispatcher queue of {_id(_source(link, sym.NodeNet))} (topic {channel.topic})"
    return f"subscriber queue of {_id(_source(link, sym.SubscriberPort).place)} (topic {channel.topic})"


def _id(element: EObject) -> str:
    return str(getattr(element, "name", None) or getattr(element, "id", None) or type(element).__name__)


def _source(link: Link, kind: type[E]) -> E:
    return next(source for source in link.sources if isinstance(source, kind))


def _queue(does: str) -> Callable[[Link], str]:
    return lambda link: f"{queue_words(link)}{does}{_writer(link)}"


def _writer(link: Link) -> str:
    """Return which instance of a server page it is that writes to a queue that all of them share."""
    if link.rule != "T2Instance":
        return ""
    server = _source(link, sym.ServerPort).channel
    return f" of instance {link.index}" + (f" of service {server.service}" if server is not None else "")


def _client(does: str, from_page: str = "") -> Callable[[Link], str]:
    """Speak of a call; `from_page` is said where the client stands on a server page."""

    def speak(link: Link) -> str:
        service = _source(link, sym.ServiceChannel).service
        text = does if link.client_index is None else from_page or does
        return text.format(client=client_words(link), service=service, instance=link.index)

    return speak


def client_words(link: Link) -> str:
    """Return the client of a call: ``client c1``, or the server instance that calls from its own page."""
    client = _source(link, sym.ClientPort)
    if link.client_index is None or client.channel is None or client.channel.model is None:
        return f"client {client.client}"
    pages = server_pages(client.channel.model)
    caller = serving(client.request, pages)
    assert caller is not None
    words = f"instance {link.client_index} of service {caller.service}"
    beside = [other for other in client.channel.clients if serving(other.request, pages) is caller]
    return words if len(beside) == 1 else f"client {client.client} of {words}"


def _instance(does: str) -> Callable[[Link], str]:
    return lambda link: does.format(service=_source(link, sym.ServiceChannel).service, instance=link.index)


def _signal(does: str) -> Callable[[Link], str]:
    return lambda link: does.format(signal=_id(_source(link, sym.InputSignal)))


_TEXTS: dict[tuple[str, str], Callable[[Link], str]] = {
    ("T1", "topic"): lambda link: f"messages under way on topic {_source(link, sym.TopicChannel).topic}",
    ("T1", "transport"): lambda link: f"topic {_source(link, sym.TopicChannel).topic} delivers a message",
    ("T3", "received"): lambda link: f"{queue_words(link)}: arriving messages",
    ("T4", "received"): lambda link: f"{queue_words(link)}: arriving messages",
    ("S1", "ready"): _client(
        "{client} of service {service} is ready", "{client} is ready to call service {service}"
    ),
    ("S1", "requests"): _client(
        "request of {client} of service {service} under way",
        "request of {client} to service {service} under way",
    ),
    ("S1", "responses"): _client(
        "response to {client} of service {service} under way",
        "response of service {service} to {client} under way",
    ),
    ("S1", "t_req"): _client("{client} calls service {service}"),
    ("S1", "t_res"): _client("{client} gets its response from service {service}"),
    ("S2", "in_use"): _client("instance {instance} of service {service} works for {client}"),
    ("S2", "t_call"): _client("instance {instance} of service {service} takes the request of {client}"),
    ("S2", "t_return"): _client("instance {instance} of service {service} answers {client}"),
    ("S3", "active"): _instance("instance {instance} of service {service} is active"),
    ("S3", "inactive"): _instance("instance {instance} of service {service} is inactive"),
    ("I4", "true"): _signal("signal {signal} is true"),
    ("I4", "false"): _signal("signal {signal} is false"),
    **{
        (rule, f"change.to_{value}"): _signal(f"signal {{signal}} becomes {value}")
        for rule in ("I5FullyEnabled", "I5InputEnabled", "I5IoEnabled")
        for value in ("true", "false")
    },
    **{
        (rule, f"queue.{role}"): _queue(does)
        for rule in (*PUBLISHER_QUEUES, "T3", "T4")
        for role, does in {
            "load": ": load",
            "capacity": ": free capacity",
            "enter": " takes a message",
            "leave": " passes a message on",
            "drop": " loses a message",
        }.items()
    },
}
