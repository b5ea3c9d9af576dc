"""``dineros edit``: its address, its end, its exit statuses; what a browser says is said over the stream."""

from __future__ import annotations

import json
import os
import signal
import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from urllib.request import urlopen

import pytest

from dineros.metamodel.editing.journal import journal_of
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from dineros.views.serving.handle import PageHandle
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.systems.talker import talker
from tests.views.editing.pages import Tab

PROGRAM = (
    "import signal; signal.signal(signal.SIGINT, signal.default_int_handler); "
    "from dineros.cli.main import main; main()"
)
"""The command line; what runs in the background of a shell would not hear of an interruption."""

Start = Callable[..., tuple["subprocess.Popen[str]", PageHandle]]


@pytest.fixture
def file(tmp_path: Path) -> Path:
    save(talker(), tmp_path / "talker.sym.xmi")
    return tmp_path / "talker.sym.xmi"


@pytest.fixture
def start(tmp_path: Path) -> Iterator[Start]:
    """Return what starts an editor in a process of its own, and where its page is."""
    started: list[subprocess.Popen[str]] = []

    def begin(*arguments: str) -> tuple[subprocess.Popen[str], PageHandle]:
        process = subprocess.Popen(
            [sys.executable, "-c", PROGRAM, "edit", *arguments, "--no-browser"],
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
            env={**os.environ, "XDG_STATE_HOME": str(tmp_path / "state")},
        )
        started.append(process)
        assert process.stdout is not None
        line = ""
        while "http://" not in line:
            line = process.stdout.readline()
            assert line, process.stderr and process.stderr.read()
        return process, PageHandle(line.split()[-1], None, None)  # type: ignore[arg-type]

    yield begin
    for process in started:
        process.kill()
        process.communicate()


def interrupted(process: subprocess.Popen[str]) -> tuple[int, str, str]:
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=30)
    return process.returncode, out.strip(), err


def test_it_begins_saves_and_ends(file: Path, start: Start) -> None:
    process, page = start(str(file))
    with urlopen(page.url, timeout=30) as answer:
        assert answer.status == 200
    with Tab(page, "taboneone") as tab:
        command = {"kind": "set", "element": tab.by_id("Words"), "feature": "tokens", "value": 7}
        tab.ask("do", commands=[command])
        tab.ask("save")
    assert interrupted(process) == (0, f"{file}: saved", "")
    assert not journal_of(file).exists()
    assert getattr(find(load(file), "Words"), "tokens", None) == 7


@pytest.mark.long
def test_what_was_not_saved_is_kept_whatever_ends_it(file: Path, start: Start) -> None:
    before = file.read_bytes()
    process, page = start(str(file))
    with Tab(page, "taboneone") as tab:
        for tokens in range(4, 9):
            command = {"kind": "set", "element": tab.by_id("Words"), "feature": "tokens", "value": tokens}
            assert tab.ask("do", commands=[command])["type"] == "done"
        process.kill()
        process.wait()
    assert file.read_bytes() == before
    process, page = start(str(file))
    with Tab(page, "tabtwotwo") as tab:
        assert tab.model["objects"][tab.by_id("Words")]["values"]["tokens"] == 8
        assert tab.said[0]["recovered"] == 5
        tab.ask("undo")
    status, said, _ = interrupted(process)
    assert (status, said) == (0, f"{file}: not saved; the journal keeps the changes")
    assert journal_of(file).exists() and file.read_bytes() == before


def test_wrong_use_is_one_line(file: Path, tmp_path: Path, start: Start, run: Run) -> None:
    start(str(file))
    assert is_one_line_of_wrong_use(run("edit", str(file), "--no-browser"), "edited by another process")
    (tmp_path / "net.net").write_text("net n\npl a (1)\n")
    assert is_one_line_of_wrong_use(run("edit", str(tmp_path / "net.net")), "not a suffix of a model")
    (tmp_path / "broken.xmi").write_text("<a/>")
    assert is_one_line_of_wrong_use(run("edit", str(tmp_path / "broken.xmi")), "broken.xmi")
    assert is_one_line_of_wrong_use(run("edit", str(tmp_path / "no/folder.xmi")), "folder.xmi")
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert is_one_line_of_wrong_use(
            run("edit", str(tmp_path / "new.xmi"), "--port", port), f"port {port}"
        )
    assert sorted(each.name for each in tmp_path.iterdir() if "journal" in each.name) == [
        journal_of(file).name
    ]
    assert json.loads(journal_of(file).read_text())["version"] == 1
