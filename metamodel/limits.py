"""Limits of sizes: numbers of a model that cost memory or time, and how large they may be.

A file of a few kilobytes can ask for two thousand million tokens. Usual sizes are accepted; for large ones,
`validate` warns; a size above the limit is an error, before any object is created. A user who needs
more raises the limit, by ``--limit NAME=NUMBER`` or ``DINEROS_LIMITS=NAME=NUMBER,..`` in the environment,
which processes that are started inherit.
"""

from __future__ import annotations

import os
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from dineros.metamodel.errors import DinerosError, near_matches

VARIABLE = "DINEROS_LIMITS"
"""Name of the environment variable."""


@dataclass(frozen=True)
class Limit:
    """How large a number may be.

    Attributes
    ----------
    counts : str
        What the number is a number of, for messages.
    usual : int or None
        Larger numbers get a warning. None: no number gets a warning, because it is not part of a model.
    most : int
        Larger numbers are refused, unless the user raises the limit.
    says : str
        Where it holds.
    """

    counts: str
    usual: int | None
    most: int
    says: str


LIMITS = {
    "instances": Limit("instances", 100, 1_000, "server instances of a service, slots of an action"),
    "tokens": Limit("tokens", 1_000, 100_000, "tokens at the start, of a place and of a running node net"),
    "length": Limit("elements", 10_000, 1_000_000, "a token field that is a list of fixed length"),
    "values": Limit("values", None, 10_000_000, "what the tokens of a running node net carry at the start"),
    "weight": Limit("tokens", 1_000, 100_000, "weight of an arc that moves tokens"),
    "queue": Limit("messages", 10_000, 1_000_000, "capacity of a topic's queue"),
    "threads": Limit("threads", 64, 1_000, "threads of a node net"),
    "elements": Limit("elements", None, 200_000, "what the rules make, and a running node net"),
    "points": Limit("points", None, 100_000, "a sweep"),
    "topics": Limit("topics", None, 10_000, "a recording"),
    "unpacking": Limit("times its size", None, 100, "what a recording unpacks to, beyond 64 MiB"),
}
"""All limits, by name. `tokens` and `weight` are for models whose tokens carry data, not for plain nets."""


class SizeLimitError(DinerosError):
    """A number is larger than its limit."""


def most(name: str) -> int:
    """Return how large a number may be, by the name of its limit.

    Raises
    ------
    DinerosError
        The environment says something else than limits.
    """
    return _set(os.environ.get(VARIABLE, "")).get(name, LIMITS[name].most)


def raised(texts: tuple[str, ...]) -> str:
    """Return what the environment variable has to be so that further limits hold, each ``NAME=NUMBER``.

    Raises
    ------
    DinerosError
        There is no such limit, or it is not a number.
    """
    before = os.environ.get(VARIABLE, "")
    text = ",".join([*([before] if before else []), *texts])
    return ",".join(f"{name}={number}" for name, number in _set(text).items())


def exceeds(
    name: str, size: int, what: str, element: str | None = None, *, is_all: bool = True
) -> SizeLimitError | None:
    """Return the error where a number is larger than its limit.

    Parameters
    ----------
    name : str
        Name of the limit.
    size : int
        The number.
    what : str
        The beginning of the message, such as ``the service 'Pick' has``.
    element : str, optional
        Id of the element concerned.
    is_all : bool
        Whether the number is all that there is; otherwise counting ended with it.
    """
    limit = most(name)
    if size <= limit:
        return None
    counts = LIMITS[name].counts
    if is_all:
        message = f"{what} {size} {counts}, more than the limit of {limit}"
    else:
        message = f"{what} {limit} {counts}, which is the limit"
    return SizeLimitError(message, element=element, hint=hint(name, size if is_all else None))


def hint(name: str, size: int | None = None) -> str:
    """Return how to raise a limit so that a number is accepted, if that is known."""
    return f"make it smaller, or raise the limit: --limit {name}={size or 'NUMBER'}"


@lru_cache(maxsize=8)
def _set(text: str) -> Mapping[str, int]:
    found: dict[str, int] = {}
    for part in filter(None, (part.strip() for part in text.split(","))):
        name, _, number = part.partition("=")
        if name not in LIMITS:
            known = near_matches(name, LIMITS) or f"known are {', '.join(LIMITS)}"
            raise DinerosError(f"{part!r} is not a limit of a size", hint=known)
        if not re.fullmatch("[0-9]{1,18}", number):
            raise DinerosError(f"{part!r} is not a limit of a size", hint=f"for example {name}=5000")
        found[name] = int(number)
    return found
