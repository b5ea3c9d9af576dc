"""Callbacks that wait for what they run in threads and coroutines."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.sources.libraries.idioms import Idiom, does_of

IDIOMS = {
    "timer_thread_join": Idiom("""
t = threading.Timer(0.1, self.ask)
t.start()
t.join()
"""),
    "pool_submit_result": Idiom(
        "self.pool.submit(self.ask).result()",
        init="self.pool = ThreadPoolExecutor(2)",
        before="from concurrent.futures import ThreadPoolExecutor",
    ),
    "pool_map_list": Idiom(
        "list(self.pool.map(self.one, [1, 2]))",
        init="self.pool = ThreadPoolExecutor(2)",
        methods="def one(self, x): return self.ask()",
        before="from concurrent.futures import ThreadPoolExecutor",
    ),
    "mp_pool_map": Idiom(
        "self.pool.map(self.one, [1, 2])",
        init="self.pool = ThreadPool(2)",
        methods="def one(self, x): return self.ask()",
        before="from multiprocessing.pool import ThreadPool",
    ),
    "mp_pool_apply": Idiom(
        "self.pool.apply(self.ask)",
        init="self.pool = ThreadPool(2)",
        before="from multiprocessing.pool import ThreadPool",
    ),
    "mp_pool_apply_async_get": Idiom(
        "self.pool.apply_async(self.ask).get()",
        init="self.pool = ThreadPool(2)",
        before="from multiprocessing.pool import ThreadPool",
    ),
    "asyncio_to_thread": Idiom(
        "asyncio.run(self.go())",
        methods="""
async def go(self):
    await asyncio.to_thread(self.ask)
""",
    ),
    "asyncio_run_in_executor": Idiom(
        "asyncio.run(self.go())",
        methods="""
async def go(self):
    loop = asyncio.get_running_loop()
    await loop.run_in_executor(None, self.ask)
""",
    ),
    "asyncio_run_gather": Idiom(
        "asyncio.run(self.go())",
        methods="""
async def one(self):
    self.ask()
async def go(self):
    await asyncio.gather(self.one(), self.one())
""",
    ),
    "sched": Idiom(
        """
s = sched.scheduler()
s.enter(1, 1, self.ask)
s.run()
""",
        before="import sched",
    ),
}


@pytest.mark.parametrize("name", IDIOMS)
def test_the_callback_makes_the_call(tmp_path: Path, name: str) -> None:
    """The call was lost, or belonged to an event that may come at any time."""
    assert "call" in does_of(tmp_path, IDIOMS[name])
