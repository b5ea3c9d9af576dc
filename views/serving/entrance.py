"""Who may come in: those who know the token, and mean this server, from a page of its own."""

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
"""Seconds in which a connection must have shown the token."""

REFUSED = 4403
"""Code that closes a stream to somebody without the token."""


class Entrance:
    """The door of one server.

    Parameters
    ----------
    token : str
        What must be known.
    port : int
        Where the server listens.

    Attributes
    ----------
    strangers : UnknownClients
        The open connections that have not shown the token.
    """

    def __init__(self, token: str, port: int) -> None:
        self.token = token
        self.strangers = UnknownClients(LOG, PATIENCE)
        self._hosts = {f"{HOST}:{port}", f"localhost:{port}"}

    @property
    def streams(self) -> str:
        """Where pages of this server may connect to, for their policy."""
        return " ".join(f"ws://{host}" for host in sorted(self._hosts))

    def is_meant(self, connection: HTTPConnection) -> bool:
        """Return whether a request is for this server, not for a name that somebody else had lead here."""
        return connection.headers.get("host") in self._hosts

    def lets_in(self, connection: HTTPConnection) -> bool:
        """Return whether a request is for this server and has the token.

        Its connection is no longer counted as a stranger's then.
        """
        given = connection.query_params.get("token", "")
        known = secrets.compare_digest(given.encode(), self.token.encode())
        if not known or not self.is_meant(connection):
            return False
        if connection.client is not None:
            self.strangers.forget((connection.client.host, connection.client.port))
        return True

    async def lets_in_stream(self, socket: WebSocket) -> bool:
        """Tell whether a stream is wanted by a page of this server; one that is not is closed."""
        origin = socket.headers.get("origin", "").removeprefix("http://")
        if self.lets_in(socket) and origin in self._hosts:
            return True
        await socket.accept()
        await socket.close(REFUSED)
        return False

    def page(self, connection: HTTPConnection, made: tuple[str, str] | None) -> Response:
        """Answer with a page and its policy, or with a refusal; `made` is None for who may not see it."""
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
    """Whom a request came from does not listen any more."""


def guarded(application: ASGIApp) -> ASGIApp:
    """Let nothing that happens to one request reach the server, which would print where it happened.

    A page that has gone is a line of the log for those who debug, whatever the server makes of it; anything
    else is a line for everybody.
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
