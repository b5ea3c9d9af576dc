"""One-time addresses for the command line of a browser, which all users of the machine can read."""

from __future__ import annotations

import os
import secrets
import socket
import struct
import time
from typing import TYPE_CHECKING

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.reading import read_text
from dineros.views.serving.addresses import HOST

if TYPE_CHECKING:
    from starlette.requests import Request
    from starlette.types import ASGIApp, Receive, Scope, Send

    from dineros.views.serving.entrance import Entrance

VALID = 60.0
"""Seconds within which a browser must open an invitation."""

_TABLES = ("/proc/self/net/tcp", "/proc/self/net/tcp6")


class Invitations:
    """Codes that redirect a browser to a page's address, once and only for the same user.

    Parameters
    ----------
    entrance : Entrance
        The access control of the server.
    """

    def __init__(self, entrance: Entrance) -> None:
        self._entrance = entrance
        self._codes: dict[str, float] = {}

    def new(self) -> str:
        """Return a new code; from any thread."""
        code = secrets.token_urlsafe(24)
        self._codes[code] = time.monotonic() + VALID
        return code

    def in_front_of(self, application: ASGIApp) -> ASGIApp:
        """Return an application that handles codes (``/?code=...``), and forwards other requests."""
        from starlette.requests import Request as Asked
        from starlette.responses import PlainTextResponse, RedirectResponse

        async def answer(scope: Scope, receive: Receive, send: Send) -> None:
            if scope["type"] != "http" or b"code=" not in scope["query_string"]:
                await application(scope, receive, send)
                return
            headers = {"Cache-Control": "no-store", "Referrer-Policy": "no-referrer", "Connection": "close"}
            if self._is_good(Asked(scope)):
                to = f"/?token={self._entrance.token}"
                await RedirectResponse(to, 303, headers)(scope, receive, send)
                return
            text = "This address works once, for one user. Open the one that was printed, token included.\n"
            await PlainTextResponse(text, 403, headers)(scope, receive, send)

        return answer

    def _is_good(self, request: Request) -> bool:
        client = request.client
        if client is None or not self._entrance.is_meant(request) or not of_this_user(client.port):
            return False  # the code stays valid for the user's browser
        until = self._codes.pop(request.query_params.get("code", ""), 0.0)
        return time.monotonic() < until


def of_this_user(port: int) -> bool:
    """Return whether a connection from a port of this machine was made by a process of this user.

    The system lists all connections with their users (proc(5), ``/proc/net/tcp``).
    """
    (address,) = struct.unpack("=I", socket.inet_aton(HOST))
    local = f"{address:08X}:{port:04X}"
    for table in _TABLES:
        try:
            lines = read_text(table).splitlines()[1:]
        except (OSError, DinerosError):
            continue
        for line in lines:
            _, here, _, _, _, _, _, user, *_ = line.split()
            if here.endswith(local):
                return int(user) == os.geteuid()
    return False
