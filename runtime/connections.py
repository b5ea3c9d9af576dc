"""Limits on the number and age of a server's connections with unknown clients.

Each user of the machine can connect to a port of 127.0.0.1, and each connection uses a file descriptor of the
server's process. A run, a node or an editor must not run out of file descriptors because of that.
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
"""Maximum number of connections with unknown clients; a further one closes the oldest.

It is three times `BACKLOG`: a client that sends its request at once is identified before others can displace
it.
"""

BACKLOG = 64
"""Connections that the system queues until they are accepted; asyncio accepts all of them at once."""

QUIET = 60.0
"""Minimum time in seconds between two equal lines of the log."""

Client = tuple[str, int]
"""Host and port of a client."""


class QuietLog:
    """A log that suppresses repetitions for a while, since anyone can cause lines by connecting."""

    def __init__(self, log: Logger) -> None:
        self._log = log
        self._last: dict[str, float] = {}

    def warn(self, line: str) -> None:
        """Log a line unless it was logged recently."""
        now = time.monotonic()
        if now - self._last.get(line, -QUIET) >= QUIET:
            self._last[line] = now
            self._log.warning("%s", line)


class UnknownClients:
    """The open connections of a server with clients not yet identified; used in the server's event loop.

    Parameters
    ----------
    log : Logger
        Gets a line when connections are closed.
    patience : float, optional
        Seconds after which a connection of an unknown client is closed: the time limit for the header of its
        request; None: the server has its own limit.
    """

    def __init__(self, log: Logger, patience: float | None = None) -> None:
        self._patience = patience
        self._open: dict[Client, tuple[asyncio.Transport, asyncio.TimerHandle | None]] = {}
        self._log = QuietLog(log)

    def arrived(self, transport: asyncio.Transport) -> None:
        """Register a new connection; close the oldest ones if there are too many."""
        name = transport.get_extra_info("peername")
        if not isinstance(name, tuple):
            transport.abort()  # already closed
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
        """Stop counting a connection: it was closed, or its client has been identified."""
        _, timer = self._open.pop(client, (None, None))
        if timer is not None:
            timer.cancel()

    def _end(self, client: Client) -> None:
        transport, _ = self._open[client]
        self.forget(client)
        transport.abort()


def counting_protocol(clients: UnknownClients, base: type[H11Protocol] | None = None) -> type[H11Protocol]:
    """Return a protocol of uvicorn that registers each new connection as one of an unknown client.

    Parameters
    ----------
    clients : UnknownClients
        Registers the connections.
    base : type, optional
        The base class of the protocol.
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
    """Return a protocol of uvicorn that registers a connection before its TLS handshake, and limits its time.

    A server of asyncio is notified of a connection only after the handshake, which a client may never finish.

    Parameters
    ----------
    clients : UnknownClients
        Registers the connections.
    base : type
        The protocol used after the handshake.
    context : SSLContext
        The TLS context of the server.
    patience : float
        Time limit of the handshake, in seconds.
    """

    class SpokenProtocol(counting_protocol(clients, base)):  # type: ignore[misc]
        """Buffers data that arrives with the end of the handshake until the connection is made."""

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
            transport.pause_reading()  # the first data belongs to the handshake
            clients.arrived(transport)
            self._task = asyncio.get_running_loop().create_task(self._shake_hands(transport))

        async def _shake_hands(self, transport: asyncio.Transport) -> None:
            loop, protocol = asyncio.get_running_loop(), SpokenProtocol(**self._settings)
            name = transport.get_extra_info("peername")
            try:
                safe = await loop.start_tls(
                    transport, protocol, context, server_side=True, ssl_handshake_timeout=patience
                )
            except (OSError, asyncio.CancelledError):  # includes TLS errors and the time-out
                transport.abort()
                clients.forget((str(name[0]), int(name[1])) if isinstance(name, tuple) else ("", 0))
                return
            if safe is not None:
                protocol.connection_made(safe)

    return HandshakingProtocol


def log_in_lines(log: Logger, what: str) -> Callable[[asyncio.AbstractEventLoop, dict[str, Any]], None]:
    """Return an exception handler for an event loop that logs one line instead of asyncio's stack trace.

    asyncio prints a stack trace for each connection that it cannot accept, for example without a free file
    descriptor.
    """
    quiet = QuietLog(log)

    def failed(_: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
        reason = context.get("exception") or context["message"]
        quiet.warn(f"{what}: {' '.join(str(reason).split())}")

    return failed
