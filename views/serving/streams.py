"""Streams of messages to the open pages of a server, each with a queue of its own."""

from __future__ import annotations

import asyncio
from collections.abc import Awaitable, Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias

if TYPE_CHECKING:
    from starlette.websockets import WebSocket

MOST_WAITING = 2_000
"""Limit of the undelivered messages of a page; a slow page is disconnected, and has to load again."""

BEHIND = 4408
"""Code that closes the stream to a page that does not read its messages."""

Waiting: TypeAlias = "asyncio.Queue[str | None]"
"""The messages that wait for a page; None: it is disconnected."""


class Streams:
    """Distributes messages to pages, given their queues; calls `changed` when pages connect or disconnect."""

    def __init__(self, changed: Callable[[], None] = lambda: None) -> None:
        self._changed = changed
        self.pages: dict[Waiting, None] = {}

    def tell(self, *messages: str | None) -> None:
        """Send messages to all pages; None is left out."""
        for message in messages:
            for page in list(self.pages) if message is not None else ():
                if page.qsize() < MOST_WAITING:
                    page.put_nowait(message)
                else:
                    self.pages.pop(page, None)
                    page.put_nowait(None)

    async def serve(
        self, socket: WebSocket, greeting: Iterable[str], hear: Callable[[Waiting], Awaitable[None]]
    ) -> None:
        """Send a greeting and then all messages to a page until it disconnects, or `hear` returns."""
        from starlette.websockets import WebSocketDisconnect

        queue: Waiting = asyncio.Queue()
        for message in greeting:
            queue.put_nowait(message)
        self.pages[queue] = None
        self._changed()
        hearing = asyncio.ensure_future(hear(queue))
        try:
            while True:
                getting = asyncio.create_task(queue.get())
                await asyncio.wait({getting, hearing}, return_when=asyncio.FIRST_COMPLETED)
                if not getting.done():
                    getting.cancel()
                    break
                waiting = getting.result()
                if waiting is None:
                    await socket.close(BEHIND)
                    break
                await socket.send_text(waiting)
                queue.task_done()
        except (WebSocketDisconnect, RuntimeError):
            pass  # it is gone
        finally:
            self.pages.pop(queue, None)
            self._changed()
            hearing.cancel()
