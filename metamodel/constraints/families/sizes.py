"""Numbers that cost memory or time: large ones are suspicious, huge ones refused (see `limits`)."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject, remembered
from dineros.metamodel.constraints.constraint import Outcome, constraint
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.limits import LIMITS, hint, most

_LIMITED: tuple[tuple[type[EObject], str, str], ...] = (
    (sym.ServiceChannel, "instances", "instances"),
    (rtm.ServerPort, "instances", "instances"),
    (sym.ActionChannel, "instances", "instances"),
    (rtm.ActionServerPort, "instances", "instances"),
    (sym.TokenField, "length", "length"),
    (sym.TopicPort, "limit", "queue"),
    (sym.Dispatcher, "limit", "queue"),
    (rtm.PublisherPort, "limit", "queue"),
    (rtm.SubscriberPort, "limit", "queue"),
    (rtm.SubscriberPort, "dispatcherLimit", "queue"),
    (sym.NodeNet, "threads", "threads"),
)
# In a plain net both are numbers, and cost nothing; elsewhere a token is an object with data.
_OF_TOKENS: tuple[tuple[type[EObject], str, str], ...] = (
    (pn.Place, "tokens", "tokens"),
    (pn.Arc, "weight", "weight"),
)


def _sizes(element: EObject, index: Index) -> Iterator[tuple[str, str, int]]:
    """Yield the numbers of an element that are limited: feature, name of the limit, number."""
    for feature, name in _limited(type(element), index.is_distributed):
        size = getattr(element, feature)
        # An inhibitor arc is only compared with.
        if size is not None and (name != "weight" or element.kind != pn.ArcKind.inhibitor):  # type: ignore[attr-defined]
            yield feature, name, size


@remembered
def _limited(kind: type[EObject], is_distributed: bool) -> list[tuple[str, str]]:
    """Return the features of a class that are limited, and the names of their limits."""
    limited = (*_LIMITED, *(_OF_TOKENS if is_distributed else ()))
    return [(feature, name) for cls, feature, name in limited if issubclass(kind, cls)]


@constraint("{it} has {found}", fix="make it smaller")
def size_within_limit(element: EObject, index: Index) -> Outcome:
    """A number that costs memory or time is not larger than its limit, which `--limit` raises."""
    for feature, name, size in _sizes(element, index):
        if size > most(name):
            found = f"{feature} {size}, more than the limit of {most(name)}"
            return DinerosError(found, hint=hint(name, size))
    return True


@constraint("{it} has {found}", fix="make it smaller, unless this size is intended", severity="warning")
def size_usual(element: EObject, index: Index) -> Outcome:
    """A number that costs memory or time is not unusually large."""
    for feature, name, size in _sizes(element, index):
        usual = LIMITS[name].usual
        if usual is not None and usual < size <= most(name):
            return f"{feature} {size}, which costs memory and time; up to {usual} is usual"
    return True
