"""A private connection between a supervisor and a node's process: one JSON object per line of a socket.

The process inherits its end, so no other process can use the connection. Still, each side treats the messages
of the other as untrusted, since handlers of the developers run in the process of a node.
"""

from __future__ import annotations

import contextlib
import json
import logging
import os
import socket
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import decode_json

LOG = logging.getLogger("dineros.runtime")

LINE = "DINEROS_LINE"
"""Environment variable: the descriptor of the line in the process of a node."""

LONGEST = 1 << 20
"""Maximum size of one message, in bytes."""

_PIECE = 1 << 16


class LineError(DinerosError):
    """The other side sent an invalid message, or does not read."""


class Line:
    """One side of the connection. One thread may receive while others send, one at a time.

    Parameters
    ----------
    end : socket.socket
        The socket; it belongs to the line from now on.
    """

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._read = bytearray()

    def say(self, said: Mapping[str, Any], *, waits: bool) -> None:
        """Send a message.

        Parameters
        ----------
        said : mapping
            The message, as JSON values.
        waits : bool
            Whether to wait until the other side has room. If not, and there is no room, the caller must
            `hang_up`: the other side may have received a part of the message.

        Raises
        ------
        LineError
            It is too long, or there is no room for it.
        OSError
            The line is closed.
        """
        data = json.dumps(said).encode() + b"\n"  # in ASCII: lone surrogates are not UTF-8
        if len(data) > LONGEST:
            raise LineError(f"{len(data)} bytes are too much for one line", hint=f"at most {LONGEST}")
        if waits:
            self._end.sendall(data)
            return
        try:
            sent = self._end.send(data, socket.MSG_DONTWAIT)
        except BlockingIOError:
            sent = 0
        if sent < len(data):
            raise LineError("the other end of the connection does not respond")

    def receive(self) -> dict[str, Any] | None:
        """Wait for a message of the other side; None: it has closed the line, or the line is closed.

        Raises
        ------
        LineError
            The message is too long, or not a JSON object.
        """
        while (end := self._read.find(b"\n")) < 0:
            if len(self._read) > LONGEST:
                raise LineError(f"a line of more than {LONGEST} bytes")
            try:
                piece = self._end.recv(_PIECE)
            except OSError:
                return None
            if not piece:
                return None
            self._read += piece
        line = bytes(self._read[:end])
        del self._read[: end + 1]
        try:
            said = decode_json(line, limit=LONGEST)
        except DinerosError as error:
            raise LineError(error.message) from error
        if not isinstance(said, dict):
            raise LineError("no JSON object")
        return said

    def hang_up(self) -> None:
        """Shut down both directions: a receiver gets the end of the stream. From any thread."""
        with contextlib.suppress(OSError):  # the other side closed it before
            self._end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Close the socket; only on the receiving thread: no other thread may still use the descriptor."""
        self._end.close()


@contextlib.contextmanager
def new_line(connect: Callable[[socket.socket], None] | None) -> Iterator[dict[str, str]]:
    """Create a line to a process that is started within the block.

    Parameters
    ----------
    connect : callable or None
        Called with this side's end when the process has been started; None: no line is created.

    Yields
    ------
    dict of str to str
        Additions to the environment of the process; the value is the descriptor that the process inherits.

    Raises
    ------
    OSError
        The system has no free descriptors.
    """
    if connect is None:
        yield {}
        return
    ours, theirs = socket.socketpair()
    try:
        with theirs:  # if kept open here, the end of the process would not be noticed
            yield {LINE: str(theirs.fileno())}
    except BaseException:
        ours.close()
        raise
    connect(ours)


def inherited_line() -> Line | None:
    """Take the line that the supervisor gave this process; child processes do not inherit it.

    Returns
    -------
    Line or None
        None without a line, for example if the process was started by hand.
    """
    given = os.environ.pop(LINE, "")
    if not given:
        return None
    try:
        number = int(given)
        os.set_inheritable(number, False)
        end = socket.socket(fileno=number)
        if end.family != socket.AF_UNIX:  # another connection, which stays open
            end.detach()
            raise ValueError(given)
    except (ValueError, OverflowError, OSError):
        LOG.warning("%s does not name a connection to a supervisor: pages cannot control this node", LINE)
        return None
    return Line(end)
