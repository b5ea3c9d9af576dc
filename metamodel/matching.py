"""Whether a publisher and a subscriber of a topic go together: requested against offered quality of service.

The rules are those of DDS (OMG, Data Distribution Service 1.4, 2015, Sect. 2.2.3), which ROS 2 obeys: a pair
that does not match exchanges nothing.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

from dineros.metamodel import sym


class Quality(NamedTuple):
    """A quality of service as plain values.

    Attributes
    ----------
    reliability : {"reliable", "bestEffort"}
    durability : {"volatile", "transientLocal"}
    liveliness : {"automatic", "manualByTopic"}
    deadline, lease_duration, lifespan : float or None
        Seconds; None: without bound.
    """

    reliability: str
    durability: str
    liveliness: str
    deadline: float | None
    lease_duration: float | None
    lifespan: float | None


@dataclass(frozen=True)
class Mismatch:
    """Why a pair does not match.

    Attributes
    ----------
    reason : str
        What is offered and what is requested.
    settings : tuple of str
        Settings of which each one fixes it: first that of the publisher.
    """

    reason: str
    settings: tuple[str, ...]

    @property
    def fix(self) -> str:
        """The settings in words."""
        return " or ".join(self.settings)


def quality_of(port: sym.PublisherPort | sym.SubscriberPort) -> sym.QualityOfService:
    """Return the quality of service of a port: its own, else its topic's, else the usual one."""
    own = port.qos or (port.channel.qos if port.channel is not None else None)
    return own or sym.QualityOfService()


def are_matched(publisher: sym.PublisherPort, subscriber: sym.SubscriberPort) -> bool:
    """Return whether messages of a publisher reach a subscriber."""
    return mismatch(publisher, subscriber) is None


def is_best_effort(publisher: sym.PublisherPort, subscriber: sym.SubscriberPort) -> bool:
    """Return whether messages between two ports may be lost on the way."""
    best_effort = sym.Reliability.bestEffort
    return best_effort in (quality_of(publisher).reliability, quality_of(subscriber).reliability)


def is_kept(publisher: sym.PublisherPort, subscriber: sym.SubscriberPort) -> bool:
    """Return whether a subscriber that comes late gets what the publisher still keeps.

    Both must be transient-local, and reliable: what is best-effort is never sent again (seen on Fast DDS).
    """
    late = sym.Durability.transientLocal
    qualities = quality_of(publisher), quality_of(subscriber)
    return all(each.durability == late for each in qualities) and not is_best_effort(publisher, subscriber)


def plain(quality: sym.QualityOfService) -> Quality:
    """Return a quality of service as plain values."""
    return Quality(
        str(quality.reliability),
        str(quality.durability),
        str(quality.liveliness),
        quality.deadline,
        quality.leaseDuration,
        quality.lifespan,
    )


def unmet(offered: Quality, requested: Quality) -> str | None:
    """Return what a publisher offers less of than a subscriber requests; None: they match."""
    for name, strictness in _ORDERED.items():
        if strictness(getattr(offered, name)) < strictness(getattr(requested, name)):
            return name
    return None


def mismatch(publisher: sym.PublisherPort, subscriber: sym.SubscriberPort) -> Mismatch | None:
    """Return why a publisher and a subscriber do not match; None if they do."""
    offered, requested = plain(quality_of(publisher)), plain(quality_of(subscriber))
    name = unmet(offered, requested)
    if name is None:
        return None
    return _reason(name, publisher, subscriber, getattr(offered, name), getattr(requested, name))


def _reason(
    name: str, publisher: sym.PublisherPort, subscriber: sym.SubscriberPort, given: object, asked: object
) -> Mismatch:
    words, feature = name.replace("_", " "), "leaseDuration" if name == "lease_duration" else name
    settings = (
        _setting("publisher", publisher, feature, asked),
        _setting("subscriber", subscriber, feature, given),
    )
    return Mismatch(
        f"the publisher's {words} is {shown(given)}, and the subscriber requests {shown(asked)}",
        settings,
    )


def _setting(role: str, port: sym.PublisherPort | sym.SubscriberPort, name: str, value: object) -> str:
    """Return a change of a port as `--set` takes it."""
    channel = port.channel.id if port.channel is not None else ""
    return f"{channel}.{role}.{port.place.id}.qos.{name}={'' if value is None else value}"


def shown(value: object) -> str:
    """Return a policy's value in words: ``reliable``, ``0.5 s``, ``without bound``."""
    if value is None:
        return "without bound"
    return f"{value:g} s" if isinstance(value, float) else str(value)


def _time(seconds: float | None) -> float:
    """Return how strict a time is: the shorter the stricter."""
    return -math.inf if seconds is None else -seconds


_ORDERED: dict[str, Callable[..., float]] = {
    "reliability": lambda value: value == "reliable",
    "durability": lambda value: value == "transientLocal",
    "deadline": _time,
    "liveliness": lambda value: value == "manualByTopic",
    "lease_duration": _time,
}
"""How strict each value is; what is offered must be as strict as what is requested."""
