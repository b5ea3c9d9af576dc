"""Why a recorded step is not replayed: for good, or not yet."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Fault:
    """A step that is not allowed now, whatever other nodes do later.

    Attributes
    ----------
    reason : str
        Why.
    queue : str or None
        Place of the publisher whose queue was not full, where that is the reason: there, another order of
        other nodes' steps may allow it.
    """

    reason: str
    queue: str | None = None


@dataclass(frozen=True)
class Waiting:
    """A step that other nodes' steps may still allow: that of a message, or a drop at the receiving side.

    Attributes
    ----------
    reason : str
        What is missing.
    senders : tuple of str
        The nodes one of whose steps is awaited.
    outside : str
        What it means if no node of the model ever does what is awaited.
    unclear : bool
        Whether messages without ids are the reason: in another order of other steps, it may be allowed.
    unclear_if_stuck : bool
        Whether that is so if the nodes that it waits for wait, too.
    is_forcible : bool
        Whether it is allowed when nothing else can be done: it loses a message then.
    in_hindsight : bool
        Whether whole traces may allow it where records that are replayed as they come do not: a loss from a
        history of several publishers, which is told after messages were taken that came later.
    """

    reason: str
    senders: tuple[str, ...]
    outside: str = ""
    unclear: bool = False
    unclear_if_stuck: bool = False
    is_forcible: bool = False
    in_hindsight: bool = False


Refusal = Fault | Waiting
