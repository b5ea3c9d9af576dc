"""What elements of a flattened net are in the words of the system model: channel, queue, client, clause."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.transformations.traces import Link

E = TypeVar("E", bound=EObject)


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
    if link.rule == "T2":
        return f"publisher queue of {_id(_source(link, sym.PublisherPort).place)} (topic {channel.topic})"
    if link.rule == "T3":
        return f"dispatcher queue of {_id(_source(link, sym.NodeNet))} (topic {channel.topic})"
    return f"subscriber queue of {_id(_source(link, sym.SubscriberPort).place)} (topic {channel.topic})"


def _id(element: EObject) -> str:
    return str(getattr(element, "name", None) or getattr(element, "id", None) or type(element).__name__)


def _source(link: Link, kind: type[E]) -> E:
    return next(source for source in link.sources if isinstance(source, kind))


def _queue(does: str) -> Callable[[Link], str]:
    return lambda link: f"{queue_words(link)}{does}"


def _client(does: str) -> Callable[[Link], str]:
    def speak(link: Link) -> str:
        client, service = _source(link, sym.ClientPort), _source(link, sym.ServiceChannel)
        return does.format(client=client.client, service=service.service, instance=link.index)

    return speak


def _instance(does: str) -> Callable[[Link], str]:
    return lambda link: does.format(service=_source(link, sym.ServiceChannel).service, instance=link.index)


def _signal(does: str) -> Callable[[Link], str]:
    return lambda link: does.format(signal=_id(_source(link, sym.InputSignal)))


_TEXTS: dict[tuple[str, str], Callable[[Link], str]] = {
    ("T1", "topic"): lambda link: f"messages under way on topic {_source(link, sym.TopicChannel).topic}",
    ("T1", "transport"): lambda link: f"topic {_source(link, sym.TopicChannel).topic} delivers a message",
    ("T3", "received"): lambda link: f"{queue_words(link)}: arriving messages",
    ("T4", "received"): lambda link: f"{queue_words(link)}: arriving messages",
    ("S1", "ready"): _client("client {client} of service {service} is ready"),
    ("S1", "requests"): _client("request of client {client} of service {service} under way"),
    ("S1", "responses"): _client("response to client {client} of service {service} under way"),
    ("S1", "t_req"): _client("client {client} calls service {service}"),
    ("S1", "t_res"): _client("client {client} gets its response from service {service}"),
    ("S2", "in_use"): _client("instance {instance} of service {service} works for client {client}"),
    ("S2", "t_call"): _client(
        "instance {instance} of service {service} takes the request of client {client}"
    ),
    ("S2", "t_return"): _client("instance {instance} of service {service} answers client {client}"),
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
        for rule in ("T2", "T3", "T4")
        for role, does in {
            "load": ": load",
            "capacity": ": free capacity",
            "enter": " takes a message",
            "leave": " passes a message on",
            "drop": " loses a message",
        }.items()
    },
}
