"""``dineros run`` without ROS ends when it is told to, whatever its handlers do, and continues from there."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.cli.conftest import Run

PATIENCE = 60.0
"""Seconds; the handlers block for an hour."""
HANDLERS = """
import asyncio, threading, time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

LOCK = threading.Lock()
LOCK.acquire()

def configure(net):
    if net.id != "talker":
        return
    net.signal("Button").set(True)

    @net.handler("Say"{options})
    {function} say(firing):
        if Path("calm").exists():
            return
        Path("begun").touch()
        {body}
"""
BLOCKERS = {
    "sleep": ("", "def", "time.sleep(3600)"),
    "busy": ("", "def", "while True: pass"),
    "lock": ("", "def", "LOCK.acquire()"),
    "thread": (", thread=True", "def", "time.sleep(3600)"),
    "executor": ("", "def", "ThreadPoolExecutor().submit(time.sleep, 3600).result()"),
    "async": ("", "async def", "await asyncio.to_thread(time.sleep, 3600)"),
    "blocked event loop": ("", "async def", "time.sleep(3600)"),
}


@pytest.mark.long
@pytest.mark.parametrize(
    ("blocker", "way", "number"),
    [(blocker, "--local", signal.SIGTERM) for blocker in BLOCKERS]
    + [("sleep", "--simulate", signal.SIGTERM), ("lock", "--local", signal.SIGINT)],
)
def test_a_run_ends_although_a_handler_does_not(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch, blocker: str, way: str, number: signal.Signals
) -> None:
    monkeypatch.chdir(model.parent)
    options, function, body = BLOCKERS[blocker]
    model.with_name("handlers.py").write_text(HANDLERS.format(options=options, function=function, body=body))
    traces = model.parent / "traces"
    status, output = ended(["run", str(model), way, "--trace", str(traces)], model.with_name("begun"), number)
    assert status == 0, output
    assert output.startswith("interrupted; marked: ")
    last = [json.loads(line) for line in (traces / "talker.jsonl").read_text().splitlines()][-2:]
    assert last[-1]["event"] == "stop"
    if way == "--local" and function == "def" and not options:
        assert (last[0]["event"], last[0]["transition"], last[0]["policy"]) == ("error", "Say", None)
    assert run("conform", model, traces).exit_code == 0
    model.with_name("calm").touch()
    again = run("run", model, "--simulate", "--until", "Noted >= 3", "--trace", traces, "--resume")
    assert again.exit_code == 0, again.stderr
    assert run("conform", model, traces).exit_code == 0


@pytest.mark.long
def test_a_handler_that_swallows_what_ends_it_is_ended_by_force(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(model.parent)
    stubborn = "while True:\n            try: time.sleep(3600)\n            except BaseException: pass"
    model.with_name("handlers.py").write_text(
        HANDLERS.format(options="", function="def", body=stubborn), encoding="utf-8"
    )
    traces = model.parent / "traces"
    status, _ = ended(
        ["run", str(model), "--simulate", "--trace", str(traces)], model.with_name("begun"), signal.SIGTERM
    )
    assert status == 130
    assert run("conform", model, traces).exit_code == 0


def ended(arguments: list[str], begun: Path, number: signal.Signals) -> tuple[int, str]:
    """Start the program, signal it when a file is there, and return its status and what it printed."""
    with subprocess.Popen(
        [sys.executable, "-m", "dineros.cli.main", *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        cwd=begun.parent,
    ) as process:
        try:
            end = time.monotonic() + PATIENCE
            while not begun.exists():
                assert process.poll() is None
                assert time.monotonic() < end
                time.sleep(0.02)
            os.kill(process.pid, number)
            output, _ = process.communicate(timeout=PATIENCE)
        finally:
            process.kill()
    return process.returncode, "\n".join(line for line in output.splitlines() if line.startswith("interr"))


@pytest.mark.parametrize("way", ["--simulate", "--local"])
def test_a_full_disk_ends_a_run_with_one_line(model: Path, way: str) -> None:
    """The journal cannot grow: no stack trace, and the run continues when there is room again."""
    (model.parent / "handlers.py").write_text("def configure(net):\n    pass\n")
    command = ["dineros", "run", model.name, way, "--trace", "tr", "--until", "Noted >= 3", "--timeout", "20"]
    program = (
        "import resource, sys\n"
        "from dineros.cli.main import main\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop(1)),) * 2)\n"
        "main()\n"
    )
    options = ["--set", "Button.initial=true"]
    ended = {}
    for room, more in (("1500", []), ("1000000", ["--resume"])):
        ended[room] = subprocess.run(
            [sys.executable, "-c", program, room, *command[1:], *options, *more],
            cwd=model.parent,
            capture_output=True,
            check=False,
            text=True,
            timeout=120,
        )
    full, after = ended.values()
    assert full.returncode != 0
    assert "Traceback" not in full.stderr and "unexpected" not in full.stderr
    assert "cannot be written: File too large" in full.stderr.splitlines()[-1]
    assert after.returncode == 0, after.stderr
