"""Access control: requests need the token, the name of this server, and an origin of this server."""

from __future__ import annotations

import logging
import secrets
from typing import TYPE_CHECKING

from dineros.runtime.connections import UnknownClients
from dineros.views.serving.addresses import HOST

if TYPE_CHECKING:
    from starlette.requests import HTTPConnection
    from starlette.responses import Response
    from starlette.types import ASGIApp, Message, Receive, Scope, Send
    from starlette.websockets import WebSocket

LOG = logging.getLogger("dineros.views.serving")

PATIENCE = 5.0
"""Seconds within which a connection must send the token."""

REFUSED = 4403
"""Code that closes a stream without the token."""


class Entrance:
    """The access control of one server.

    Attributes
    ----------
    strangers : UnknownClients
        The open connections that have not sent the token.
    """

    def __init__(self, token: str, port: int) -> None:
        self.token = token
        self.strangers = UnknownClients(LOG, PATIENCE)
        self._hosts = {f"{HOST}:{port}", f"localhost:{port}"}

    @property
    def streams(self) -> str:
        """Addresses to which pages of this server may connect, for their policy."""
        return " ".join(f"ws://{host}" for host in sorted(self._hosts))

    def is_meant(self, connection: HTTPConnection) -> bool:
        """Return whether a request names this server, and not another name that resolves to it."""
        return connection.headers.get("host") in self._hosts

    def lets_in(self, connection: HTTPConnection) -> bool:
        """Return whether a request is for this server and has the token.

        Its connection then no longer counts as unknown.
        """
        given = connection.query_params.get("token", "")
        known = secrets.compare_digest(given.encode(), self.token.encode())
        if not known or not self.is_meant(connection):
            return False
        if connection.client is not None:
            self.strangers.forget((connection.client.host, connection.client.port))
        return True

    async def lets_in_stream(self, socket: WebSocket) -> bool:
        """Return whether a stream comes from a page of this server; others are closed."""
        origin = socket.headers.get("origin", "").removeprefix("http://")
        if self.lets_in(socket) and origin in self._hosts:
            return True
        await socket.accept()
        await socket.close(REFUSED)
        return False

    def page(self, connection: HTTPConnection, made: tuple[str, str] | None) -> Response:
        """Respond with a page and its policy, or with a rejection; `made` is None without access."""
        from starlette.responses import HTMLResponse, PlainTextResponse

        headers = {
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
        }
        if made is None or not self.lets_in(connection):
            headers["Connection"] = "close"
            return PlainTextResponse("Open the address that was printed, token included.\n", 403, headers)
        text, policy = made
        headers["Content-Security-Policy"] = f"{policy}; frame-ancestors 'none'"
        return HTMLResponse(text, headers=headers)


class _GoneError(OSError):
    """The sender of a request has disconnected."""


def guarded(application: ASGIApp) -> ASGIApp:
    """Handle all errors of a request, so that the server does not print a stack trace.

    A page that disconnected is logged at the debug level; all other errors are logged as errors.
    """
    from starlette.websockets import WebSocketDisconnect

    async def inside(scope: Scope, receive: Receive, send: Send) -> None:
        async def receiving() -> Message:
            try:
                return await receive()
            except Exception as error:
                raise _GoneError(str(error)) from error

        async def sending(message: Message) -> None:
            try:
                await send(message)
            except Exception as error:
                raise _GoneError(str(error)) from error

        if scope["type"] == "lifespan":
            await application(scope, receive, send)
            return
        try:
            await application(scope, receiving, sending)
        except (_GoneError, WebSocketDisconnect) as error:
            LOG.debug("a page has disconnected: %s", _line(error))
        except Exception as error:
            LOG.error("the page failed: %s", _line(error))

    return inside


def _line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
