"""The server of the editor: a page, a stream in both directions for each tab, a comparison with the file."""

from __future__ import annotations

import asyncio
import contextlib
import re
from collections.abc import AsyncIterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from dineros.metamodel.editing import Document
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.watching import FolderWatch
from dineros.views.editing.arranging import positions, sheet_view
from dineros.views.editing.page import editor_page
from dineros.views.editing.session import LONGEST_MESSAGE, QUICK, Session, job_text
from dineros.views.editing.working import Jobs
from dineros.views.nets import compare, to_html, view_of
from dineros.views.serving.entrance import Entrance, guarded
from dineros.views.serving.handle import PageHandle, changed, serve_page
from dineros.views.serving.streams import BEHIND, MOST_WAITING, Streams, Waiting

if TYPE_CHECKING:
    from starlette.applications import Starlette
    from starlette.requests import Request
    from starlette.responses import Response
    from starlette.types import ASGIApp
    from starlette.websockets import WebSocket

PAUSE = 0.15
"""Seconds without a change after which a model with slow checks is checked."""

MOST_PAGES = 16
"""Limit of the open pages."""

_TAB = re.compile(r"[0-9a-z]{8,40}")


def serve_editor(document: Document, port: int = 0, program: Sequence[str] | None = None) -> PageHandle:
    """Serve the pages that edit a document.

    Parameters
    ----------
    document : Document
        The document; the server's thread alone may use it until the server ends.
    port : int
        The port; 0: the last one used, or any.
    program : sequence of str, optional
        What begins the command lines of ``dineros``, which check, generate and run; without it nothing does.

    Raises
    ------
    DinerosError
        Something that the server needs is not installed, or the port is taken.
    """
    make = partial(application, document, program=program)
    return serve_page(make, document.path, port, what="the editor", longest_message=LONGEST_MESSAGE)


def application(document: Document, entrance: Entrance, program: Sequence[str] | None = None) -> ASGIApp:
    """Return the application that serves a document to authorised requests."""
    from starlette.applications import Starlette
    from starlette.routing import Route, WebSocketRoute

    editor = _Editor(Session(document), entrance, program)
    routes = [
        Route("/", editor.page, methods=["GET"]),
        Route("/compare", editor.comparison, methods=["GET"]),
        Route("/arrange", editor.arrangement, methods=["GET"]),
        Route("/trace", editor.trace, methods=["GET"]),
        WebSocketRoute("/commands", editor.commands),
    ]
    return guarded(Starlette(routes=routes, lifespan=editor.lifespan))


class _Editor:
    """Distributes messages to pages."""

    def __init__(self, session: Session, entrance: Entrance, program: Sequence[str] | None) -> None:
        self._session, self._entrance = session, entrance
        self._streams = streams = Streams()
        self._jobs = session.jobs = Jobs(session.document, program, lambda job: streams.tell(job_text(job)))
        self._checks: asyncio.Event | None = None

    @contextlib.asynccontextmanager
    async def lifespan(self, _: Starlette) -> AsyncIterator[None]:
        self._checks = asyncio.Event()
        tasks = [asyncio.create_task(self._watch()), asyncio.create_task(self._check())]
        try:
            yield
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
            await self._jobs.close()

    async def _watch(self) -> None:
        """Notify pages when another program changes the file."""
        with FolderWatch(self._session.document.path.absolute().parent) as files:
            while True:
                files.forget()
                self._streams.tell(self._session.looked_at_file())
                await asyncio.sleep(0.15)
                await changed(files)

    async def _check(self) -> None:
        """Check models with slow checks during pauses."""
        assert self._checks is not None
        while True:
            await self._checks.wait()
            self._checks.clear()
            if self._session.checking_took > QUICK:
                await asyncio.sleep(PAUSE)
                if self._checks.is_set():
                    continue
            self._streams.tell(self._session.new_marks())

    async def page(self, request: Request) -> Response:
        if not self._entrance.lets_in(request):
            return self._entrance.page(request, None)
        made = editor_page(self._session.document.path.name, f"{self._entrance.streams} 'self'")
        return self._entrance.page(request, made)

    async def comparison(self, request: Request) -> Response:
        """Respond with a picture of the differences between the file and the model."""
        from starlette.responses import PlainTextResponse

        if not self._entrance.lets_in(request):
            return self._entrance.page(request, None)
        document = self._session.document
        try:
            view = compare(view_of(document.on_disk()), view_of(document.root))
            text = await asyncio.to_thread(to_html, view)
        except DinerosError as error:
            return PlainTextResponse(f"{error}\n", 409, {"Cache-Control": "no-store"})
        # The page says itself what may run on it: it is that of a file.
        return self._entrance.page(request, (text, "base-uri 'none'"))

    async def arrangement(self, request: Request) -> Response:
        """Respond with an arrangement of the elements of a sheet."""
        from starlette.responses import JSONResponse

        if not self._entrance.lets_in(request):
            return self._entrance.page(request, None)
        document = self._session.document
        try:
            view = sheet_view(document, request.query_params.get("sheet", ""))
            found = await asyncio.to_thread(positions, document, view)
        except DinerosError as error:
            return JSONResponse({"reason": error.message}, 409, {"Cache-Control": "no-store"})
        return JSONResponse({"positions": found}, headers={"Cache-Control": "no-store"})

    async def trace(self, request: Request) -> Response:
        """Respond with the token game of a page as a trace file."""
        from starlette.responses import PlainTextResponse

        if not self._entrance.lets_in(request):
            return self._entrance.page(request, None)
        headers = {"Cache-Control": "no-store", "Content-Disposition": "attachment"}
        try:
            text = self._session.playing.trace(request.query_params.get("tab", ""))
        except DinerosError as error:
            return PlainTextResponse(f"{error}\n", 409, headers)
        return PlainTextResponse(text, headers=headers, media_type="application/x-ndjson")

    async def commands(self, socket: WebSocket) -> None:
        if not await self._entrance.lets_in_stream(socket):
            return
        tab = socket.query_params.get("tab", "")
        await socket.accept()
        if not _TAB.fullmatch(tab) or len(self._streams.pages) >= MOST_PAGES:
            await socket.close(BEHIND, "a tab must have a name, and the number of tabs is limited")
            return
        await self._streams.serve(socket, [self._session.greeting()], partial(self._hear, socket, tab))

    async def _hear(self, socket: WebSocket, tab: str, queue: Waiting) -> None:
        """Process the requests of a page in sequence until it disconnects."""
        while True:
            received: dict[str, Any] = dict(await socket.receive())
            if received["type"] == "websocket.disconnect":
                return
            answer = self._session.hear(received.get("text") or received.get("bytes") or "", tab)
            self._streams.tell(*answer.all)
            for message in answer.own:
                queue.put_nowait(message)
            if answer.all and self._checks is not None:
                self._checks.set()
            if queue.qsize() > MOST_WAITING:
                queue.put_nowait(None)
                return
            await asyncio.sleep(0)  # others have their turn
