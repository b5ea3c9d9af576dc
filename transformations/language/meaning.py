"""The meaning of an element made by a rule: its description, its step in a trace, its part of a queue."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from dineros.metamodel.records.schema import Step

QueueKind = Literal[
    "publisher", "dispatcher", "subscriber", "request", "response", "feedback", "goal", "result", "answer"
]


@dataclass(frozen=True)
class Meaning:
    """The meaning of an element for readers of a net, a witness or a trace, who need not know the rules.

    Attributes
    ----------
    words : str
        What it is, or what its firing does. Names in braces are filled in: ``topic``, ``service``,
        ``client``, ``instance``, ``signal``, ``value``, ``publisher``, ``subscriber``, ``place``,
        ``callback``, ``group``, ``node``, ``action`` and ``outcome`` are of what the rule matched,
        ``writing`` and ``reading`` the node nets of a publisher and a subscriber, ``queue`` is its queue,
        ``writer`` the server instance that writes there, and ``waits`` what a client does whose request is
        lost.
    on_server_page : str
        Description used instead if the client is on a server page.
    step : type of Step or None
        The step of its firing in a trace; None for a firing of the model, and for places.
    queue : QueueKind or None
        The kind of queue it belongs to.
    called : str
        Description of that queue, with names in braces.
    part : str
        Its role: ``load``, ``capacity``, ``enter``, ``leave`` or ``drop`` of a queue; ``threads``,
        ``lock``, ``running`` or ``awaiting`` of an executor; ``idle``, ``due`` or ``tick`` of a timer;
        ``idle slot``, ``executing``, ``asked``, ``canceling``, ``waits``, ``works``, ``over``, ``ask``,
        ``nothing``, ``reject``, ``refuse``, ``end``, ``too late``, ``unheeded`` or ``result`` of goals; for a
        managed node, its state or the requested state change.
    value : bool or None
        The value of a signal that it stands for; true, too, for the value that the rule matched last.
    rests : bool
        Whether the place is marked in an idle state.
    """

    words: str
    on_server_page: str = ""
    step: type[Step] | None = None
    queue: QueueKind | None = None
    called: str = "{queue_kind} queue of {queue_end} (topic {topic})"
    part: str = ""
    value: bool | None = None
    rests: bool = False
