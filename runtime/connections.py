"""How many connections a server keeps, and for how long, of clients that it does not know.

Each user of the machine can connect to a port of 127.0.0.1, and each connection takes a file descriptor of
the process that serves. A run, a node or an editor must not lose its own files to them.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from logging import Logger
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import ssl

    from uvicorn.protocols.http.h11_impl import H11Protocol

MOST = 192
"""Connections of unknown clients at a time; a further one ends the oldest of them.

It is three times `BACKLOG`: a client that sends its request at once is known before others can end it.
"""

BACKLOG = 64
"""Connections that the system keeps until they are accepted; asyncio accepts all of them at once."""

QUIET = 60.0
"""Seconds, at least, between two equal lines of the log."""

Client = tuple[str, int]
"""Host and port of a client."""


class QuietLog:
    """A log that repeats a line only once in a while, since anyone who connects can cause any number of them.

    Parameters
    ----------
    log : Logger
        Where the lines go.
    """

    def __init__(self, log: Logger) -> None:
        self._log = log
        self._last: dict[str, float] = {}

    def warn(self, line: str) -> None:
        """Log a line unless it was logged a short time ago."""
        now = time.monotonic()
        if now - self._last.get(line, -QUIET) >= QUIET:
            self._last[line] = now
            self._log.warning("%s", line)


class UnknownClients:
    """The open connections of a server whose clients it does not know; used in the server's event loop.

    Parameters
    ----------
    log : Logger
        Where the first of many is logged.
    patience : float, optional
        Seconds after which a connection is closed whose client is still unknown: the time limit of the header
        of its request; None: the server has a limit of its own.
    """

    def __init__(self, log: Logger, patience: float | None = None) -> None:
        self._patience = patience
        self._open: dict[Client, tuple[asyncio.Transport, asyncio.TimerHandle | None]] = {}
        self._log = QuietLog(log)

    def arrived(self, transport: asyncio.Transport) -> None:
        """Count a new connection; end the oldest where there are too many."""
        name = transport.get_extra_info("peername")
        if not isinstance(name, tuple):
            transport.abort()  # it has gone already
            return
        client = (str(name[0]), int(name[1]))
        self.forget(client)  # an earlier connection from the same port
        timer = None
        if self._patience is not None:
            timer = asyncio.get_running_loop().call_later(self._patience, self._end, client)
        self._open[client] = (transport, timer)
        if len(self._open) <= MOST:
            return
        for each, (other, _) in list(self._open.items()):
            if other.is_closing():
                self.forget(each)
        while len(self._open) > MOST:
            self._log.warn(f"more than {MOST} connections of unknown clients: the oldest are closed")
            self._end(next(iter(self._open)))

    def forget(self, client: Client) -> None:
        """Do not count a connection any more: it has closed, or its client is known."""
        _, timer = self._open.pop(client, (None, None))
        if timer is not None:
            timer.cancel()

    def _end(self, client: Client) -> None:
        transport, _ = self._open[client]
        self.forget(client)
        transport.abort()


def counting_protocol(clients: UnknownClients, base: type[H11Protocol] | None = None) -> type[H11Protocol]:
    """Return a protocol of uvicorn that counts each new connection as that of an unknown client.

    Parameters
    ----------
    clients : UnknownClients
        Where they are counted.
    base : type, optional
        What the protocol extends.
    """
    if base is None:
        from uvicorn.protocols.http.h11_impl import H11Protocol as base  # noqa: N813

    class CountingProtocol(base):  # type: ignore[misc,valid-type]
        def connection_made(self, transport: asyncio.Transport) -> None:
            super().connection_made(transport)
            clients.arrived(transport)

        def connection_lost(self, exc: Exception | None) -> None:
            if self.client is not None:
                clients.forget(self.client)
            super().connection_lost(exc)

    return CountingProtocol


def handshaking_protocol(
    clients: UnknownClients, base: type[H11Protocol], context: ssl.SSLContext, patience: float
) -> type[asyncio.Protocol]:
    """Return a protocol of uvicorn that counts a connection before its TLS handshake, and limits its time.

    A server of asyncio hears of a connection only after the handshake, which a stranger need not end.

    Parameters
    ----------
    clients : UnknownClients
        Where connections are counted.
    base : type
        The protocol that is spoken after the handshake.
    context : SSLContext
        The server's.
    patience : float
        Seconds for the handshake.
    """

    class SpokenProtocol(counting_protocol(clients, base)):  # type: ignore[misc]
        """Keeps what comes with the end of the handshake until the connection is made."""

        def __init__(self, **settings: Any) -> None:
            super().__init__(**settings)
            self._early: list[bytes] | None = []

        def connection_made(self, transport: asyncio.Transport) -> None:
            super().connection_made(transport)
            early, self._early = self._early, None
            for data in early or ():
                super().data_received(data)

        def connection_lost(self, exc: Exception | None) -> None:
            if self._early is None:
                super().connection_lost(exc)

        def data_received(self, data: bytes) -> None:
            if self._early is None:
                super().data_received(data)
            else:
                self._early.append(data)

    class HandshakingProtocol(asyncio.Protocol):
        def __init__(self, **settings: Any) -> None:
            self._settings = settings

        def connection_made(self, transport: asyncio.BaseTransport) -> None:
            assert isinstance(transport, asyncio.Transport)
            transport.pause_reading()  # what comes first is for the handshake
            clients.arrived(transport)
            self._task = asyncio.get_running_loop().create_task(self._shake_hands(transport))

        async def _shake_hands(self, transport: asyncio.Transport) -> None:
            loop, protocol = asyncio.get_running_loop(), SpokenProtocol(**self._settings)
            name = transport.get_extra_info("peername")
            try:
                safe = await loop.start_tls(
                    transport, protocol, context, server_side=True, ssl_handshake_timeout=patience
                )
            except (OSError, asyncio.CancelledError):  # of which are TLS's errors, and that time is up
                transport.abort()
                clients.forget((str(name[0]), int(name[1])) if isinstance(name, tuple) else ("", 0))
                return
            if safe is not None:
                protocol.connection_made(safe)

    return HandshakingProtocol


def log_in_lines(log: Logger, what: str) -> Callable[[asyncio.AbstractEventLoop, dict[str, Any]], None]:
    """Return an exception handler for an event loop that logs a line where asyncio would print a stack trace.

    asyncio prints one for each connection that it cannot accept, such as without a free file descriptor.
    """
    quiet = QuietLog(log)

    def failed(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        reason = context.get("exception") or context["message"]
        quiet.warn(f"{what}: {' '.join(str(reason).split())}")

    return failed
