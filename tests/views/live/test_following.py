"""Snapshots and numbered changes, without a server."""

from __future__ import annotations

import asyncio
import contextlib
import json
import sys
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import watching
from dineros.metamodel.records import Record
from dineros.views.live import following, serving
from dineros.views.live.following import LiveTrace
from dineros.views.serving import streams
from dineros.views.serving.handle import changed
from tests.views.live.test_live_page import script


def run_apart(work: Coroutine[Any, Any, None]) -> None:
    """Run something in a thread of its own: browsers of other tests have a loop in this one."""
    with ThreadPoolExecutor(1) as thread:
        thread.submit(asyncio.run, work).result()


class Feed:
    """Records that come when a test says so."""

    def __init__(self) -> None:
        self.waiting: list[Record] = []

    def new(self) -> list[Record]:
        found, self.waiting = self.waiting, []
        return found


def messages(found: list[str]) -> list[dict[str, Any]]:
    return [json.loads(text) for text in found]


def test_changes_are_numbered_and_those_missed_are_sent_again() -> None:
    feed = Feed()
    trace = LiveTrace(feed, None, "run")
    records = script()
    feed.waiting = records[:8]
    (first,) = messages(trace.poll())
    assert (first["type"], first["number"]) == ("snapshot", 1)
    assert trace.poll() == []
    feed.waiting = records[8:12]
    (second,) = messages(trace.poll())
    feed.waiting = records[12:16]
    (third,) = messages(trace.poll())
    assert [second["number"], third["number"]] == [2, 3]
    assert third["first"] == second["first"] + len(second["steps"])
    assert messages(trace.greeting(trace.epoch, 2)) == [third]
    assert messages(trace.greeting(trace.epoch, 1)) == [second, third]
    (nothing,) = messages(trace.greeting(trace.epoch, 3))
    assert nothing["type"] == "nothing new"


def test_where_the_net_cannot_be_drawn_the_trace_is_shown_and_one_line_says_why(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fails(model: object) -> None:
        raise DinerosError("no V8")

    monkeypatch.setattr(following, "net_content", fails)
    feed = Feed()
    feed.waiting = script()
    trace = LiveTrace(feed, None, "run")
    (first,) = messages(trace.poll())
    while trace.is_waiting:
        trace.poll()
    assert (first["type"], first["net"]) == ("snapshot", None)
    assert first["view"]["steps"]
    assert [record.getMessage() for record in caplog.records] == ["the live page shows no net: no V8"]


def test_who_knows_nothing_or_another_server_gets_everything() -> None:
    feed = Feed()
    trace = LiveTrace(feed, None, "run")
    feed.waiting = script()
    trace.poll()
    for epoch, number in ((None, None), ("other", 1), (trace.epoch, 99)):
        (everything,) = messages(trace.greeting(epoch, number))
        assert everything["type"] == "snapshot"
        assert len(everything["view"]["steps"]) > 10
        assert everything["number"] == trace.number


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere, files are looked at all the time")
def test_files_are_looked_at_when_they_have_changed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, "LONGEST", 3600.0)
    monkeypatch.setattr(serving, "INTERVAL", 0.001)
    looked: asyncio.Queue[None] = asyncio.Queue()

    class Counting(LiveTrace):
        def poll(self) -> list[str]:
            looked.put_nowait(None)
            return super().poll()

    live = serving.LivePages(Counting(Feed(), None, "run"), tmp_path)

    async def follow() -> None:
        following = asyncio.create_task(live._follow())
        await looked.get()
        await asyncio.sleep(0.2)
        assert looked.empty()
        (tmp_path / "arm.jsonl").write_text("{")
        await looked.get()
        following.cancel()
        with contextlib.suppress(asyncio.CancelledError):
            await following

    run_apart(follow())


@pytest.mark.parametrize("turns", range(8))
def test_it_can_be_stopped_while_it_is_told_of_a_change(tmp_path: Path, turns: int) -> None:
    """As at the end of a run, when the last records are written: else the page waits for itself forever."""

    async def follow() -> None:
        with watching.FolderWatch(tmp_path) as files:
            waiting = asyncio.create_task(changed(files))
            await asyncio.sleep(0.01)
            (tmp_path / "arm.jsonl").write_text("{")
            for _ in range(turns):
                await asyncio.sleep(0)
            if waiting.cancel():
                with pytest.raises(asyncio.CancelledError):
                    await waiting

    run_apart(follow())


def test_a_page_that_takes_nothing_is_closed() -> None:
    feed = Feed()
    live = serving.LivePages(LiveTrace(feed, None, "run"), None)
    page: asyncio.Queue[str | None] = asyncio.Queue()
    live.streams.pages[page] = None
    live.streams.tell(*["message"] * (streams.MOST_WAITING + 10))
    waiting = [page.get_nowait() for _ in range(page.qsize())]
    assert waiting == ["message"] * streams.MOST_WAITING + [None]
