"""Reasons why a recorded step is not replayed: permanently, or not yet."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """A step that is not allowed now, regardless of later steps of other nodes.

    Attributes
    ----------
    queue : str or None
        Place of the publisher whose queue was not full, if that is the reason: then another order of other
        nodes' steps may allow it.
    """

    reason: str
    queue: str | None = None


@dataclass(frozen=True)
class Waiting:
    """A step that other nodes' steps may still allow: one with a message, or a drop at a receiver."""

    reason: str
    """What is missing."""
    senders: tuple[str, ...]
    outside: str = ""
    """The meaning if no node of the model ever does that step."""
    unclear: bool = False
    """Whether messages without ids are the reason: then it may be allowed in another order of other steps."""
    unclear_if_stuck: bool = False
    """Whether this is so if the nodes for which it waits also wait."""
    is_forcible: bool = False
    """Whether it is allowed if nothing else can be replayed; then it loses a message."""
    in_hindsight: bool = False
    """Whether complete traces may allow it although records replayed as they arrive do not: a loss from a
    history of several publishers, reported after later messages were taken.
    """


Refusal = Fault | Waiting
