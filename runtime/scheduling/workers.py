"""Threads for long handlers: one event loop for all coroutines, and one thread for each function."""

from __future__ import annotations

import threading
from collections.abc import Awaitable, Callable
from typing import TYPE_CHECKING, Any

from dineros.runtime.scheduling.threads import join

if TYPE_CHECKING:  # a slow import that most nodes do not need
    import asyncio

PATIENCE = 1.0
"""Seconds for the cleanup of cancelled coroutines when the node ends."""

Done = Callable[[Any, BaseException | None], None]
"""Called with the result, or the exception, when the handler has ended; from any thread."""

_Outcome = tuple[Any, BaseException | None]


class Workers:
    """Runs coroutines and functions; the first coroutine starts the event loop."""

    def __init__(self) -> None:
        self._loop: asyncio.AbstractEventLoop | None = None
        self._thread: threading.Thread | None = None
        self._tasks: set[asyncio.Task[_Outcome]] = set()

    def start_coroutine(self, make: Callable[[], Awaitable[Any]], done: Done) -> Callable[[], None]:
        """Run an awaitable; return a function that cancels it."""
        import asyncio

        loop = self._started()
        task: list[asyncio.Task[_Outcome]] = []

        async def run() -> _Outcome:
            try:
                return await make(), None
            except (KeyboardInterrupt, SystemExit) as error:  # they would end the event loop
                return None, error

        def finish(over: asyncio.Task[_Outcome]) -> None:
            """Report the result, even if the task was cancelled before its first step."""
            self._tasks.discard(over)
            if over.cancelled():
                done(None, asyncio.CancelledError())
            elif (error := over.exception()) is not None:
                done(None, error)
            else:
                done(*over.result())

        def begin() -> None:
            started = loop.create_task(run())
            task.append(started)
            self._tasks.add(started)
            started.add_done_callback(finish)

        def cancel() -> None:
            if not loop.is_closed():
                loop.call_soon_threadsafe(lambda: [each.cancel() for each in task])

        loop.call_soon_threadsafe(begin)
        return cancel

    def start_thread(self, function: Callable[[], Any], name: str, done: Done) -> Callable[[], None]:
        """Run a function on a thread; the result cancels nothing, since a thread cannot be stopped."""

        def run() -> None:
            try:
                result = function()
            except BaseException as error:
                done(None, error)
            else:
                done(result, None)

        # A daemon, so that a handler that never returns does not keep the process from ending.
        threading.Thread(target=run, name=name, daemon=True).start()
        return lambda: None

    def close(self) -> None:
        """Cancel all coroutines and end the event loop. Threads continue until they return."""
        loop, thread = self._loop, self._thread
        if loop is None or thread is None:
            return
        import asyncio

        self._loop = self._thread = None

        async def end() -> None:
            tasks = list(self._tasks)
            for task in tasks:
                task.cancel()
            await asyncio.wait(tasks, timeout=PATIENCE) if tasks else None
            loop.stop()

        asyncio.run_coroutine_threadsafe(end(), loop)
        if thread is not threading.current_thread():
            join(thread, PATIENCE + 0.5)

    def _started(self) -> asyncio.AbstractEventLoop:
        if self._loop is None:
            import asyncio

            loop = self._loop = asyncio.new_event_loop()

            def run() -> None:
                asyncio.set_event_loop(loop)
                try:
                    loop.run_forever()
                finally:
                    loop.close()

            self._thread = threading.Thread(target=run, name="dineros handlers", daemon=True)
            self._thread.start()
        return self._loop
