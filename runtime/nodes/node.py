"""A node: a net that runs, joined to others by a transport and recorded by a recorder."""

from __future__ import annotations

from dineros.runtime.channels.transport import Transport
from dineros.runtime.journal.recording import Recorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.runner import Runner


class Node(Runner):
    """A net with a transport and a recorder.

    Parameters
    ----------
    net : Net
        The net; it belongs to this node from now on.
    transport : Transport, optional
        Without one, tokens to be sent stay where they are and nothing arrives.
    recorder : Recorder, optional
        Without one, nothing is recorded.
    resume : SavedState, optional
        What the node was in when it ended; by default it starts from the initial marking.
    run : str
        Goes into the ids of messages after the node's id, for receivers that outlive this run when it is not
        resumed: ``NODE@RUN/PLACE/NUMBER``.
    request_timeout : float, optional
        Seconds after which a request is recorded as timed out and sent again. By default only the transport
        says so.

    Raises
    ------
    DinerosError
        The net runs already, or does not fit what it is to continue from.
    """

    def __init__(
        self,
        net: Net,
        transport: Transport | None = None,
        recorder: Recorder | None = None,
        *,
        resume: SavedState | None = None,
        run: str = "",
        request_timeout: float | None = None,
    ) -> None:
        super().__init__(
            net.core, transport, recorder, resume=resume, run=run, request_timeout=request_timeout
        )
        self.net = net
