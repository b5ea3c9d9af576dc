"""Messages on a stream socket: eight bytes say how long one is, then it comes."""

from __future__ import annotations

import socket
import struct
import time

_LENGTH = struct.Struct("!Q")
_PIECE = 1 << 20


def send(connection: socket.socket, content: bytes, ends: float | None = None) -> None:
    """Send a message.

    Parameters
    ----------
    connection : socket
        A stream.
    content : bytes
        The message.
    ends : float, optional
        Time of `time.monotonic` by which it must be sent.

    Raises
    ------
    OSError
        Nobody listens, or (`TimeoutError`) it took too long.
    """
    _limit(connection, ends)
    connection.sendall(_LENGTH.pack(len(content)) + content)


def receive(connection: socket.socket, ends: float | None = None) -> bytes:
    """Return the next message; the arguments are those of `send`.

    Raises
    ------
    EOFError
        The other side has closed the stream.
    OSError
        The stream is broken, or (`TimeoutError`) it took too long.
    """
    (length,) = _LENGTH.unpack(_exactly(connection, _LENGTH.size, ends))
    return _exactly(connection, length, ends)


def _exactly(connection: socket.socket, length: int, ends: float | None) -> bytes:
    content = bytearray()
    while len(content) < length:
        _limit(connection, ends)
        piece = connection.recv(min(length - len(content), _PIECE))
        if not piece:
            raise EOFError
        content += piece
    return bytes(content)


def _limit(connection: socket.socket, ends: float | None) -> None:
    left = None if ends is None else ends - time.monotonic()
    if left is not None and left <= 0:
        raise TimeoutError
    connection.settimeout(left)
