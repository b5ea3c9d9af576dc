"""The server of the live page: one page and one stream of changes, with access by token."""

from __future__ import annotations

import asyncio
import contextlib
import json
import re
from collections.abc import AsyncIterator, Callable
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.metamodel.files.reading import resolved
from dineros.metamodel.files.watching import FolderWatch
from dineros.views.live.following import LiveTrace, ModelSource, Source, source_of
from dineros.views.live.steering import LONGEST_MESSAGE, Steering
from dineros.views.serving.entrance import Entrance, guarded
from dineros.views.serving.handle import PageHandle, changed, serve_page
from dineros.views.serving.streams import MOST_WAITING, Streams, Waiting
from dineros.views.traces.page import live_page

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.types import ASGIApp
    from starlette.websockets import WebSocket

INTERVAL = 0.15
"""Seconds between two reads of files that are written continuously, or of sources without notifications."""

LEAVING = 2.0
"""Limit of the seconds that a stopping server waits for the delivery of its last messages."""

_LONGEST = 15
"""Limit of the digits or letters of the position that a page sends."""


def serve_live(
    source: Path | str | Source,
    model: ModelSource = None,
    port: int = 0,
    *,
    title: str | None = None,
    steering: Steering | None = None,
) -> PageHandle:
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
    steering : Steering, optional
        What pages may do to the run; without it they only watch.

    Returns
    -------
    PageHandle
        Its `url` holds the token; `stop` ends the server.

    Raises
    ------
    DinerosError
        Something that the server needs is not installed, or the port is taken.
    """
    folder: Path | None = None
    path: Path | None = None
    if isinstance(source, Path | str):
        path = Path(source)
        folder = path.parent if path.suffix == ".jsonl" else path
        title, source = title or resolved(path).name, source_of(path)
    trace = LiveTrace(source, model, title or "run")
    live = LivePages(trace, folder, steering)
    make = partial(application, live)
    return serve_page(
        make, path, port, what="the live page", longest_message=LONGEST_MESSAGE, leave=live.leave
    )


def application(live: LivePages, entrance: Entrance) -> ASGIApp:
    """Return the application that serves a trace to authorised requests."""
    from starlette.applications import Starlette
    from starlette.routing import Route, WebSocketRoute

    live.entrance = entrance
    routes = [Route("/", live.page, methods=["GET"]), WebSocketRoute("/changes", live.changes)]
    return guarded(Starlette(routes=routes, lifespan=live.lifespan))


class LivePages:
    """Distributes changes to pages."""

    entrance: Entrance

    def __init__(self, trace: LiveTrace, folder: Path | None, steering: Steering | None = None) -> None:
        self.trace = trace
        self._folder = folder
        self._steering = steering
        self._nodes: str | None = None
        self.streams = Streams(self._attend)
        self._loop: asyncio.AbstractEventLoop | None = None

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        """Follow the trace as long as the server runs."""
        self._loop = asyncio.get_running_loop()
        loop = self._loop
        task = asyncio.create_task(self._follow())
        if self._steering is not None:
            self._steering.begin(lambda message: _in(loop, lambda: self._tell_nodes(message)))
        try:
            yield
        finally:
            if self._steering is not None:
                self._steering.end()
            task.cancel()
            with contextlib.suppress(asyncio.CancelledError):
                await task

    async def _follow(self) -> None:
        with FolderWatch(self._folder) if self._folder else contextlib.nullcontext() as files:
            while True:
                if files is not None:
                    files.forget()
                # In the loop itself, not in a thread: no page may connect between a change and its sending.
                self.streams.tell(*self.trace.poll())
                await asyncio.sleep(INTERVAL)
                if files is not None and not self.trace.is_waiting:
                    await changed(files)

    def _tell_nodes(self, message: str) -> None:
        self._nodes = message
        self.streams.tell(message)

    def leave(self) -> None:
        """Send the remaining changes to the pages, with the end of the stream."""
        if self._loop is not None:
            with contextlib.suppress(TimeoutError, RuntimeError):  # of a page that does not listen
                asyncio.run_coroutine_threadsafe(self._leave(), self._loop).result(LEAVING)

    async def _leave(self) -> None:
        self.streams.tell(*self.trace.poll(), json.dumps({"type": "end"}))
        await asyncio.gather(*(page.join() for page in self.streams.pages))

    async def page(self, request: Request) -> Response:
        """Respond with the page."""
        allowed = self.entrance.lets_in(request)
        return self.entrance.page(request, live_page(self.entrance.streams) if allowed else None)

    async def changes(self, socket: WebSocket) -> None:
        """Send changes to a page until it disconnects."""
        from starlette.responses import PlainTextResponse

        if not await self.entrance.lets_in_stream(socket):
            return
        epoch, number = (socket.query_params.get(name, "") for name in ("epoch", "number"))
        if len(epoch) > _LONGEST or not re.fullmatch(rf"[0-9]{{0,{_LONGEST}}}", number):
            answer = f"number has at most {_LONGEST} digits, and epoch as many letters\n"
            await socket.send_denial_response(PlainTextResponse(answer, 400))
            return
        await socket.accept()
        greeting = self.trace.greeting(epoch, int(number) if number else None)
        nodes = [] if self._nodes is None else [self._nodes]
        await self.streams.serve(socket, [*greeting, *nodes], partial(self._until_gone, socket))

    def _attend(self) -> None:
        """Inspect the nodes while a page shows them."""
        if self._steering is not None:
            self._steering.watched(bool(self.streams.pages))

    async def _until_gone(self, socket: WebSocket, queue: Waiting) -> None:
        """Carry out the requests of the page if the run can be controlled, until it disconnects."""
        while True:
            received: dict[str, Any] = dict(await socket.receive())
            if received["type"] == "websocket.disconnect":
                return
            said = received.get("text") or received.get("bytes") or ""
            # In a thread: a node of another process may take its time to answer.
            refusal = None if self._steering is None else await asyncio.to_thread(self._steering.hear, said)
            if refusal is not None:
                queue.put_nowait(refusal)
            if queue.qsize() > MOST_WAITING:
                return  # it asks and takes nothing
            await asyncio.sleep(0)  # others have their turn


def _in(loop: asyncio.AbstractEventLoop, action: Callable[[], None]) -> None:
    """Run a function on a loop from another thread; do nothing if the loop has ended."""
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(action)
