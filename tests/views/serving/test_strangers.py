"""What connections without the token cost a server: few files, for a short time, and one line of the log."""

from __future__ import annotations

import asyncio
import logging
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from urllib.request import urlopen

import pytest

from dineros.metamodel.editing import Document
from dineros.metamodel.files import save
from dineros.runtime.connections import BACKLOG, MOST
from dineros.views.editing import serve_editor
from dineros.views.serving import entrance
from dineros.views.serving.handle import PageHandle
from tests.support.programs.crowds import BEGINNINGS, closed, crowd, port_of
from tests.support.systems.talker import talker
from tests.views.editing.pages import Tab
from tests.views.serving.small_page import serve_small_page


@pytest.fixture
def page() -> Iterator[PageHandle]:
    handle = serve_small_page()
    yield handle
    handle.stop()


@pytest.mark.parametrize("beginning", BEGINNINGS.values(), ids=BEGINNINGS)
def test_few_strangers_are_kept_and_those_with_the_token_come_in(
    page: PageHandle, beginning: bytes, caplog: pytest.LogCaptureFixture
) -> None:
    before = len(list(Path("/proc/self/fd").iterdir()))
    with crowd(port_of(page.url), 400, beginning) as connections:
        assert urlopen(page.url, timeout=10).read() == b"page"
        server_side = len(list(Path("/proc/self/fd").iterdir())) - before - len(connections)
        assert server_side <= MOST + BACKLOG
        assert closed(connections) >= 400 - MOST - BACKLOG
    assert len([each for each in caplog.records if each.levelno > logging.DEBUG]) <= 1


def test_a_stranger_has_a_short_time(monkeypatch: pytest.MonkeyPatch, request: pytest.FixtureRequest) -> None:
    monkeypatch.setattr(entrance, "PATIENCE", 0.2)
    page: PageHandle = request.getfixturevalue("page")
    with crowd(port_of(page.url), 3, b"GET /?") as connections:
        end = time.monotonic() + 10
        while closed(connections) < 3 and time.monotonic() < end:
            connections[0].setblocking(True)
            time.sleep(0.05)
        assert closed(connections) == 3


def test_the_editor_saves_in_a_crowd(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setattr(entrance, "PATIENCE", 0.3)
    file = tmp_path / "talker.sym.xmi"
    save(talker(), file)
    document = Document(file)
    handle = serve_editor(document)
    try:
        with Tab(handle, "tabonetab") as tab, crowd(port_of(handle.url), 200, b"GET /?"):
            time.sleep(0.6)  # a page that is open is not a stranger
            command = {"kind": "set", "element": tab.by_id("talker"), "feature": "name", "value": "two"}
            assert tab.ask("do", commands=[command])["type"] == "done"
            assert tab.ask("save")["type"] == "done"
    finally:
        handle.stop()
        document.close()
    assert b'name="two"' in file.read_bytes()


def test_a_server_without_files_says_so_in_a_line(page: PageHandle, caplog: pytest.LogCaptureFixture) -> None:
    """`accept` fails where the process has no file left; asyncio prints a trace for each failure."""
    assert urlopen(page.url, timeout=10).read() == b"page"
    loop = page._server.servers[0].get_loop()
    for _ in range(50):
        error = OSError(24, "Too many open files")
        context = {"message": "socket.accept() out of system resource", "exception": error}
        loop.call_soon_threadsafe(loop.call_exception_handler, context)
    asyncio.run_coroutine_threadsafe(asyncio.sleep(0), loop).result(5)
    lines = [each.getMessage() for each in caplog.records if each.levelno > logging.DEBUG]
    assert lines == ["the page: [Errno 24] Too many open files"]
    assert urlopen(page.url, timeout=10).read() == b"page"


@pytest.mark.long
def test_strangers_do_not_end_a_run(tmp_path: Path) -> None:
    save(talker(), tmp_path / "talker.sym.xmi")
    few_files = "import resource as r; r.setrlimit(r.RLIMIT_NOFILE, (400, 400))"
    main = f"{few_files}; from dineros.cli.main import main; main()"
    command = [sys.executable, "-P", "-c", main, "run", "talker.sym.xmi", "--local", "--view"]
    command += ["--timeout", "8", "--trace", "traces/t"]
    (tmp_path / "traces").mkdir()

    with (tmp_path / "log").open("wb") as log:
        run = subprocess.Popen(
            command,
            cwd=tmp_path,
            stdout=log,
            stderr=log,
            env={**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")},
        )
    try:
        end = time.monotonic() + 60
        while not (found := re.search(r"http\S+(?=\n)", (tmp_path / "log").read_text())):
            assert run.poll() is None and time.monotonic() < end
            time.sleep(0.1)
        with crowd(port_of(found[0]), 600, b"GET /?"):
            assert urlopen(found[0], timeout=10).status == 200
            assert run.wait(60) == 0, (tmp_path / "log").read_text()
    finally:
        run.kill()
        run.wait()
    assert (tmp_path / "log").stat().st_size < 2000
