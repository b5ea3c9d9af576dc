"""The server of the live page: one page and one stream of changes, for those who know the token."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import re
import secrets
import threading
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.watching import FolderWatch
from dineros.views.live.following import LiveTrace, ModelSource, Source, source_of
from dineros.views.live.remembering import HOST, bind, open_address
from dineros.views.traces.page import live_page

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import HTTPConnection, Request
    from starlette.responses import Response
    from starlette.types import ASGIApp, Message, Receive, Scope, Send
    from starlette.websockets import WebSocket

LOG = logging.getLogger("dineros.views.live")

INTERVAL = 0.15
"""Seconds between two looks at files that are written without a pause, or at what tells of no changes."""

_REFUSED = 4403
"""Code that closes a stream of changes to somebody without the token."""

_LONGEST = 15
"""Most digits or letters of what a page says that it has seen."""


class LiveHandle:
    """A live page that is served.

    Attributes
    ----------
    url : str
        Where it is, token included.
    """

    def __init__(self, url: str, server: Any, thread: threading.Thread) -> None:
        self.url = url
        self._server, self._thread = server, thread

    def stop(self) -> None:
        """End the server; returns when it has ended."""
        self._server.should_exit = True
        self._thread.join()

    def wait(self) -> None:
        """Wait until the server ends, or the user interrupts."""
        while self._thread.is_alive():
            self._thread.join(0.5)


def serve_live(
    source: Path | str | Source, model: ModelSource = None, port: int = 0, *, title: str | None = None
) -> LiveHandle:
    """Serve a page that follows a running application.

    Parameters
    ----------
    source : Path, str or Source
        The folder that the application's nodes record to (it may still be empty), one node's file, or an
        object with a method ``new()`` that returns the records since its last call.
    model : pn.Net or callable or None
        The model, for net, clauses and capacities; or what finds it, given the header of a trace.
    port : int
        The port; 0 for that of the last time, or any.
    title : str, optional
        What stands above the page.

    Returns
    -------
    LiveHandle
        Its `url` holds the token; `stop` ends the server.

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
        raise DinerosError("the live page needs a web server", hint="pip install 'dineros[view]'") from None
    folder: Path | None = None
    try:
        if isinstance(source, Path | str):
            path = Path(source)
            folder = path.parent if path.suffix == ".jsonl" else path
            listening, token = open_address(path, port)
            title, source = title or path.resolve().name, source_of(path)
        else:
            listening, token = bind(port), secrets.token_urlsafe(24)
    except OSError as error:
        raise DinerosError(f"port {port} cannot be used: {error.strerror}", hint="leave --port out") from None
    bound = listening.getsockname()[1]
    live = _Live(LiveTrace(source, model, title or "run"), token, bound, folder)
    config = uvicorn.Config(
        live.application(),
        log_level="critical",  # what goes wrong with a request is told by `_guarded`
        access_log=False,
        timeout_graceful_shutdown=2,
        ws_max_size=1 << 12,  # pages say nothing
    )
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run, args=([listening],), name="dineros live page", daemon=True)
    thread.start()
    return LiveHandle(f"http://{HOST}:{bound}/?token={token}", server, thread)


class _Live:
    """The application: who may see what, and who gets the next change."""

    def __init__(self, trace: LiveTrace, token: str, port: int, folder: Path | None) -> None:
        self.trace, self.token, self.port = trace, token, port
        self._folder = folder
        self._hosts = {f"{HOST}:{port}", f"localhost:{port}"}
        self._pages: set[asyncio.Queue[str]] = set()

    def application(self) -> ASGIApp:
        from starlette.applications import Starlette
        from starlette.routing import Route, WebSocketRoute

        routes = [Route("/", self.page, methods=["GET"]), WebSocketRoute("/changes", self.changes)]
        return _guarded(Starlette(routes=routes, lifespan=self.lifespan))

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        task = asyncio.create_task(self._follow())
        try:
            yield
        finally:
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def _follow(self) -> None:
        with FolderWatch(self._folder) if self._folder else contextlib.nullcontext() as files:
            while True:
                if files is not None:
                    files.forget()
                # In the loop itself, not in a thread: nobody may be greeted between a change and its sending.
                for message in self.trace.poll():
                    for page in self._pages:
                        page.put_nowait(message)
                await asyncio.sleep(INTERVAL)
                if files is not None and not self.trace.is_waiting:
                    await _changed(files)

    def _allowed(self, connection: HTTPConnection) -> bool:
        """Tell whether somebody knows the token and means this server, not a name that leads here."""
        given = connection.query_params.get("token", "")
        known = secrets.compare_digest(given.encode(), self.token.encode())
        return known and connection.headers.get("host") in self._hosts

    async def page(self, request: Request) -> Response:
        from starlette.responses import HTMLResponse, PlainTextResponse

        headers = {
            "Cache-Control": "no-store",
            "Referrer-Policy": "no-referrer",
            "X-Content-Type-Options": "nosniff",
            "X-Frame-Options": "DENY",
        }
        if not self._allowed(request):
            return PlainTextResponse("Open the address that was printed, token included.\n", 403, headers)
        streams = " ".join(f"ws://{host}" for host in sorted(self._hosts))
        text, policy = live_page(streams)
        headers["Content-Security-Policy"] = f"{policy}; frame-ancestors 'none'"
        return HTMLResponse(text, headers=headers)

    async def changes(self, socket: WebSocket) -> None:
        from starlette.responses import PlainTextResponse
        from starlette.websockets import WebSocketDisconnect

        origin = socket.headers.get("origin", "").removeprefix("http://")
        if not self._allowed(socket) or origin not in self._hosts:
            await socket.accept()
            await socket.close(_REFUSED)
            return
        epoch, number = (socket.query_params.get(name, "") for name in ("epoch", "number"))
        if len(epoch) > _LONGEST or not re.fullmatch(rf"[0-9]{{0,{_LONGEST}}}", number):
            answer = f"number has at most {_LONGEST} digits, and epoch as many letters\n"
            await socket.send_denial_response(PlainTextResponse(answer, 400))
            return
        await socket.accept()
        queue: asyncio.Queue[str] = asyncio.Queue()
        for message in self.trace.greeting(epoch, int(number) if number else None):
            queue.put_nowait(message)
        self._pages.add(queue)
        listening = asyncio.create_task(self._until_gone(socket))
        try:
            while not listening.done():
                getting = asyncio.create_task(queue.get())
                await asyncio.wait({getting, listening}, return_when=asyncio.FIRST_COMPLETED)
                if getting.done():
                    await socket.send_text(getting.result())
                else:
                    getting.cancel()
        except (WebSocketDisconnect, RuntimeError):
            pass  # it is gone
        finally:
            self._pages.discard(queue)
            listening.cancel()

    @staticmethod
    async def _until_gone(socket: WebSocket) -> None:
        """Return when the page has closed; what it says is not listened to."""
        while (await socket.receive())["type"] != "websocket.disconnect":
            pass


async def _changed(files: FolderWatch) -> None:
    """Wait until files have changed, or may have without that anybody told."""
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


class _GoneError(OSError):
    """Whom a request came from does not listen any more."""


def _guarded(application: ASGIApp) -> ASGIApp:
    """Let nothing that happens to one request reach the server, which would print where it happened.

    A page that has gone is a line of the log for those who debug, whatever the server makes of it; anything
    else is a line for everybody.
    """
    from starlette.websockets import WebSocketDisconnect

    async def guarded(scope: Scope, receive: Receive, send: Send) -> None:
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
            LOG.debug("a page has gone: %s", _line(error))
        except Exception as error:
            LOG.error("the live page failed: %s", _line(error))

    return guarded


def _line(error: Exception) -> str:
    return " ".join(f"{type(error).__name__}: {error}".split())
