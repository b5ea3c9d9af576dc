"""Starts the server of a page in a separate thread, and stops it."""

from __future__ import annotations

import asyncio
import contextlib
import secrets
import socket
import threading
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.watching import FolderWatch
from dineros.runtime.connections import BACKLOG, counting_protocol, log_in_lines
from dineros.views.serving.addresses import HOST, bind, open_address
from dineros.views.serving.entrance import LOG, Entrance
from dineros.views.serving.invitations import Invitations

if TYPE_CHECKING:
    from starlette.types import ASGIApp
    from uvicorn import Server


Leave = Callable[[], None]
"""A function that is called, in the thread that stops a server, before it stops."""


class PageHandle:
    """A served page.

    Attributes
    ----------
    url : str
        Its address, including the token.
    """

    def __init__(
        self,
        url: str,
        server: Any,
        thread: threading.Thread,
        leave: Leave | None = None,
        invitations: Invitations | None = None,
    ) -> None:
        self.url = url
        self._server, self._thread, self._leave = server, thread, leave
        self._invitations = invitations

    def url_for_command_line(self) -> str:
        """Return a one-time address for a browser of this user: other users can read command lines."""
        assert self._invitations is not None, "made by serve_page"
        return f"{self.url.partition('?')[0]}?code={self._invitations.new()}"

    def stop(self) -> None:
        """Send the remaining messages to the pages, and stop the server; returns when it has stopped."""
        if self._leave is not None and self._thread.is_alive():
            self._leave()
        self._server.should_exit = True
        self._thread.join()

    def wait(self) -> None:
        """Wait until the server ends, or the user interrupts."""
        while self._thread.is_alive():
            self._thread.join(0.5)


def serve_page(
    make: Callable[[Entrance], ASGIApp],
    path: Path | None,
    port: int,
    *,
    what: str,
    longest_message: int,
    leave: Leave | None = None,
) -> PageHandle:
    """Serve a page on this machine only.

    Parameters
    ----------
    make : callable
        Creates the application, with the given access control.
    path : Path or None
        The path that the page shows: its last port and token are used; None: new ones.
    port : int
        The port; 0 for that of the last time, or any.
    what : str
        What it is called in messages.
    longest_message : int
        Bytes of what a page may send at once.
    leave : callable, optional
        Called before the server ends.

    Raises
    ------
    DinerosError
        Something that the server needs is not installed, or the port is taken.
    """
    try:
        import uvicorn
        import websockets  # noqa: F401  # uvicorn needs it
        from starlette.applications import Starlette  # noqa: F401
    except ImportError:
        raise DinerosError(f"{what} needs a web server", hint="pip install 'dineros[view]'") from None
    listening, token = _address(path, port)
    bound = listening.getsockname()[1]
    entrance = Entrance(token, bound)
    invitations = Invitations(entrance)
    config = uvicorn.Config(
        invitations.in_front_of(make(entrance)),
        http=counting_protocol(entrance.strangers),
        backlog=BACKLOG,
        log_level="critical",  # errors in requests are reported by `guarded`
        access_log=False,
        timeout_graceful_shutdown=2,
        ws_max_size=longest_message,
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(
        target=_run, args=(server, listening, what), name=f"dineros {what}", daemon=True
    )
    thread.start()
    return PageHandle(f"http://{HOST}:{bound}/?token={token}", server, thread, leave, invitations)


def _run(server: Server, listening: socket.socket, what: str) -> None:
    """Run a server until it ends. A failure is logged; the program continues without the page."""

    async def serving() -> None:
        asyncio.get_running_loop().set_exception_handler(log_in_lines(LOG, what))
        await server.serve(sockets=[listening])

    try:
        asyncio.run(serving())
    except (Exception, SystemExit) as error:
        LOG.error("%s has ended: %s", what, " ".join(f"{type(error).__name__}: {error}".split()))


def _address(path: Path | None, port: int) -> tuple[socket.socket, str]:
    try:
        if path is not None:
            return open_address(path, port)
        return bind(port), secrets.token_urlsafe(24)
    except OSError as error:
        raise DinerosError(f"port {port} cannot be used: {error.strerror}", hint="leave --port out") from None


async def changed(files: FolderWatch) -> None:
    """Wait until files have changed, or may have changed without a notification."""
    loop = asyncio.get_running_loop()
    told = asyncio.Event()
    for descriptor in files.descriptors:
        loop.add_reader(descriptor, told.set)
    try:
        # Not `wait_for`, which forgets in Python 3.11 that it is cancelled when what it waits for comes then.
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout(files.longest):
                await told.wait()
    finally:
        for descriptor in files.descriptors:
            loop.remove_reader(descriptor)
