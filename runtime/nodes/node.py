"""A node: a running net with a transport to other nodes and a recorder."""

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
        Without one, tokens to be sent stay on their places and nothing arrives.
    recorder : Recorder, optional
        Without one, there are no records.
    resume : SavedState, optional
        State from which the node continues; by default it starts from the initial marking.
    run : str
        Part of the ids of messages, after the node's id: ``NODE@RUN/PLACE/NUMBER``. It is for receivers that
        outlive this run if the run is not resumed.
    request_timeout : float, optional
        Seconds after which a request is recorded as timed out and sent again. By default only the transport
        reports time-outs.

    Raises
    ------
    DinerosError
        The net runs already, or does not fit the state from which it is to continue.
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
