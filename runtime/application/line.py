"""A private line between a supervisor and the process of a node: JSON objects, one in a line of a socket.

The process inherits its end, so nobody else can speak on the line; still, each side takes what the other says
for something that may be wrong, since handlers of the developers run in the process of a node.
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
"""Bytes of what is said at once."""

_PIECE = 1 << 16


class LineError(DinerosError):
    """The other side says something that is none of ours, or does not listen."""


class Line:
    """One side of a line. One thread may receive while others, one at a time, say something.

    Parameters
    ----------
    end : socket.socket
        Its end, which belongs to the line from now on.
    """

    def __init__(self, end: socket.socket) -> None:
        self._end = end
        self._read = bytearray()

    def say(self, said: Mapping[str, Any], *, waits: bool) -> None:
        """Say something.

        Parameters
        ----------
        said : mapping
            What; it fits JSON.
        waits : bool
            Whether to wait until the other side takes it. Who does not wait, and finds that there is no room,
            has to `hang_up`: the other side may have got a part of it.

        Raises
        ------
        LineError
            It is too long, or there is no room for it.
        OSError
            The line is closed.
        """
        data = json.dumps(said).encode() + b"\n"  # in ASCII: halves of surrogate pairs are not UTF-8
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
            raise LineError("the other side of the line does not listen")

    def receive(self) -> dict[str, Any] | None:
        """Wait for what the other side says; None: it has gone, or the line is closed.

        Raises
        ------
        LineError
            It is too long, or no JSON object.
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
        """End what is said, both ways: whoever receives is told that nothing more comes. From any thread."""
        with contextlib.suppress(OSError):  # the other side has gone before
            self._end.shutdown(socket.SHUT_RDWR)

    def close(self) -> None:
        """Give the socket back; for the thread that receives, since nobody must use the descriptor then."""
        self._end.close()


@contextlib.contextmanager
def new_line(connect: Callable[[socket.socket], None] | None) -> Iterator[dict[str, str]]:
    """Make a line to a process that is started within the block.

    Parameters
    ----------
    connect : callable or None
        Gets our end when the process has been started; None: it gets no line.

    Yields
    ------
    dict of str to str
        What the process's environment is to have; the value is the descriptor that the process inherits.

    Raises
    ------
    OSError
        The system has no more descriptors.
    """
    if connect is None:
        yield {}
        return
    ours, theirs = socket.socketpair()
    try:
        with theirs:  # where we kept it, nobody would notice that the process has ended
            yield {LINE: str(theirs.fileno())}
    except BaseException:
        ours.close()
        raise
    connect(ours)


def inherited_line() -> Line | None:
    """Take the line that the supervisor gave this process; what this process starts does not get it.

    Returns
    -------
    Line or None
        None where nobody gave one: the process was started by hand, say.
    """
    given = os.environ.pop(LINE, "")
    if not given:
        return None
    try:
        number = int(given)
        os.set_inheritable(number, False)
        end = socket.socket(fileno=number)
        if end.family != socket.AF_UNIX:  # somebody's connection, which stays open
            end.detach()
            raise ValueError(given)
    except (ValueError, OverflowError, OSError):
        LOG.warning("%s names no line to a supervisor: no page can steer this node", LINE)
        return None
    return Line(end)
