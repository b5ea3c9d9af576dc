"""Connections that strangers open, and what comes of them."""

from __future__ import annotations

import socket
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from urllib.parse import urlsplit

BEGINNINGS = {
    "nothing": b"",
    "half a request": b"GET /?",
    "half a handshake": b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03",
    "a request without an end": b"GET / HTTP/1.1\r\nHost: a\r\n",
    "a request that is refused": b"GET / HTTP/1.1\r\nHost: a\r\n\r\n",
    "a stream that is refused": (
        b"GET /commands HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
        b"Sec-WebSocket-Key: MDEyMzQ1Njc4OWFiY2RlZg==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    ),
    "a body without an end": b"POST / HTTP/1.1\r\nHost: a\r\nContent-Length: 100\r\n\r\nx",
}


@contextmanager
def crowd(port: int, number: int, beginning: bytes) -> Iterator[list[socket.socket]]:
    """Open connections that stay as they are."""
    with ExitStack() as stack:
        found = []
        for count in range(number):
            if count % 40 == 39:
                time.sleep(0.02)  # the system makes those wait for a second whom nobody accepts
            found.append(stack.enter_context(socket.create_connection(("127.0.0.1", port), 5)))
            found[-1].sendall(beginning)
        yield found


def port_of(url: str) -> int:
    port = urlsplit(url).port
    assert port is not None
    return port


def closed(connections: list[socket.socket]) -> int:
    """Return how many the other end has closed."""
    found = 0
    for each in connections:
        each.setblocking(False)
        try:
            found += each.recv(1 << 16) == b"" or each.recv(1 << 16) == b""
        except BlockingIOError:
            pass
        except ConnectionError:
            found += 1
    return found
