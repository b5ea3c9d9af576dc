"""``dineros run`` without ROS."""

from __future__ import annotations

import json
import logging
import os
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from tests.cli.conftest import Run

HANDLERS = '''
"""Presses the button, and writes what was heard."""

from pathlib import Path


def configure(net):
    if net.id == "talker":
        net.signal("Button").set(True)

        @net.handler("Say")
        def say(firing):
            Path("said.txt").open("a").write("said\\n")
'''


@pytest.fixture
def spoken(model: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the model's file, with handlers next to it, in the current folder."""
    model.with_name("handlers.py").write_text(HANDLERS, encoding="utf-8")
    monkeypatch.chdir(model.parent)
    return model


@pytest.mark.parametrize("way", ["--local", "--simulate"])
def test_until_a_condition_holds(run: Run, spoken: Path, way: str) -> None:
    result = run("run", spoken, way, "--seed", 1, "--until", "Noted >= 3", "--monitor", "--timeout", 60)
    assert result.exit_code == 0, result.stderr
    assert result.stdout.splitlines()[0] == "the condition holds; marked: Noted 3"
    assert "conformance: conforms, " in result.stdout
    assert "6 firings, 0 drops, 0 errors, 0 restarts" in result.stdout
    assert (spoken.parent / "said.txt").read_text() == "said\n" * 3


LOGGING = """
import asyncio, logging
LOG = logging.getLogger("talk")
def configure(net):
    if net.id == "talker":
        net.signal("Button").set(True)
        @net.handler("Say")
        def say(firing):
            LOG.debug("a debug")
            LOG.info("an info")
            LOG.warning("a warning")
            asyncio.new_event_loop().close()  # which asyncio logs
"""


@pytest.mark.parametrize("way", ["--local", "--simulate"])
def test_what_handlers_log_is_shown_once(run: Run, spoken: Path, way: str) -> None:
    spoken.with_name("handlers.py").write_text(LOGGING, encoding="utf-8")
    arguments = ("run", spoken, way, "--until", "Noted >= 3", "--timeout", 60)
    for options in ([], ["-q"]):
        assert run(*arguments, *options).stderr == "[WARNING] [talk]: a warning\n" * 3
    shown = "[INFO] [talk]: an info\n[WARNING] [talk]: a warning\n"
    assert run(*arguments, "-v").stderr == f"read {spoken}\n" + shown * 3
    spoken.with_name("handlers.py").write_text(
        LOGGING + 'LOG.setLevel(logging.DEBUG)\nlogging.basicConfig(level="DEBUG")\n', encoding="utf-8"
    )
    assert run(*arguments).stderr == f"[DEBUG] [talk]: a debug\n{shown}" * 3
    logging.getLogger("talk").setLevel(logging.NOTSET)


def test_json_and_traces_that_conform(run: Run, spoken: Path) -> None:
    folder = spoken.parent / "traces"
    arguments = ("--simulate", "--until", "Noted >= 1", "--trace", folder, "--set", "Words.tokens=1")
    report = json.loads(run("run", spoken, *arguments, "--json").stdout)
    assert report["ending"] == "reached"
    assert report["marking"] == {"Noted": 1}
    assert report["signals"] == {"Button": True}
    assert sorted(path.name for path in folder.glob("*.jsonl")) == ["listener.jsonl", "talker.jsonl"]
    assert run("conform", spoken, folder, "--set", "Words.tokens=1").exit_code == 0


def test_the_same_seed_gives_the_same_run(run: Run, spoken: Path) -> None:
    def transitions(folder: Path) -> list[str]:
        run("run", spoken, "--simulate", "--seed", 5, "--until", "Noted >= 3", "--trace", folder)
        lines = [json.loads(line) for path in sorted(folder.glob("*.jsonl")) for line in path.open()]
        return [line["event"] + line.get("transition", "") for line in lines]

    assert transitions(spoken.parent / "one") == transitions(spoken.parent / "two")


def test_a_condition_that_cannot_come_true_any_more(run: Run, spoken: Path) -> None:
    result = run("run", spoken, "--simulate", "--until", "Noted >= 4")
    assert result.exit_code == 1
    assert result.stdout.startswith("nothing is left to do; marked: Noted 3\n")


def test_signal_that_nobody_sets(run: Run, model: Path) -> None:
    """A silent source is noticed after simulated time, and what was chosen is done; the run conforms."""
    arguments = ("run", model, "--simulate", "--monitor", "--until", "Noted >= 3", "--timeout", 60)
    result = run(*arguments, "--stale-after", "Button=2:true")
    assert result.exit_code == 0, result.stderr
    assert "6 firings, 0 drops, 1 error," in result.stdout
    assert "the signal Button is stale: not set for 2 s; it becomes true" in result.stderr
    assert run(*arguments, "--stale-after", "Button=2").exit_code == 3


def test_time_that_is_over(run: Run, model: Path) -> None:
    result = run("run", model, "--local", "--until", "Noted >= 1", "--timeout", 0.3)
    assert result.exit_code == 3
    assert result.stdout.startswith("time is over; marked: Words 3\n")


def test_going_on_from_traces(run: Run, spoken: Path) -> None:
    folder = spoken.parent / "traces"
    nothing_under_way = "Noted >= 1 & Words >= 1 & Noted + Words == 3"
    first = run("run", spoken, "--simulate", "--seed", 3, "--until", nothing_under_way, "--trace", folder)
    assert first.exit_code == 0
    again = run("run", spoken, "--simulate", "--until", "Noted >= 3", "--trace", folder, "--resume")
    assert again.exit_code == 0, again.stderr
    assert (spoken.parent / "said.txt").read_text() == "said\n" * 3
    assert run("conform", spoken, folder).exit_code == 0


def test_going_on_from_nothing_is_refused(run: Run, spoken: Path) -> None:
    folder = spoken.parent / "traces"
    result = run("run", spoken, "--simulate", "--trace", folder, "--resume")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "traces: holds no traces to continue from" in result.stderr


def test_a_run_that_was_ended_before_anything_was_recorded_begins_again(run: Run, spoken: Path) -> None:
    """Its supervisor had started: that is how a killed run looks which no node has reached."""
    folder = spoken.parent / "traces"
    folder.mkdir()
    (folder / "supervisor.log.jsonl").touch()
    result = run("run", spoken, "--simulate", "--until", "Noted >= 3", "--trace", folder, "--resume")
    assert result.exit_code == 0, result.stderr
    assert result.stderr.count("has no trace, so it begins with its initial marking") == 2
    assert run("conform", spoken, folder).exit_code == 0


def test_a_trace_that_is_missing_is_missed(run: Run, spoken: Path) -> None:
    folder = spoken.parent / "traces"
    assert run("run", spoken, "--simulate", "--until", "Words <= 2", "--trace", folder).exit_code == 0
    (folder / "talker.jsonl").unlink()
    result = run("run", spoken, "--simulate", "--trace", folder, "--resume")
    assert (result.exit_code, result.stderr.count("\n")) == (2, 1)
    assert "the trace of node talker is missing" in result.stderr
    (folder / ".journals").write_text("listener\n")  # as if it had been killed before it began
    result = run("run", spoken, "--simulate", "--until", "Noted >= 3", "--trace", folder, "--resume")
    assert "node talker has no trace, so it begins with its initial marking" in result.stderr


def test_ctrl_c_ends_a_run_cleanly(spoken: Path) -> None:
    folder = spoken.parent / "traces"
    program = (
        "import signal; signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from dineros.cli.main import main; main()"
    )
    command = [sys.executable, "-c", program, "run", str(spoken), "--local", "--trace", str(folder)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        deadline = time.monotonic() + 60
        while "Noted" not in (path.read_text() if (path := folder / "listener.jsonl").exists() else ""):
            assert process.poll() is None and time.monotonic() < deadline
            time.sleep(0.05)
        os.kill(process.pid, signal.SIGINT)
        output, errors = process.communicate(timeout=60)
    assert (process.returncode, errors) == (0, "")
    assert output.startswith("interrupted; marked: ")
    assert '"event":"stop"' in (folder / "talker.jsonl").read_text()


def test_a_page_that_follows_the_run_is_served_to_those_who_have_its_address(spoken: Path) -> None:
    command = [sys.executable, "-u", "-m", "dineros.cli.main", "run", str(spoken), "--local", "--view"]
    with subprocess.Popen([*command, "--timeout", "120"], stdout=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().split()[-1]
            assert address.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(address) as page:
                assert b"<html" in page.read()
            with pytest.raises(urllib.error.HTTPError, match="403"):
                urllib.request.urlopen(address.partition("?")[0])
        finally:
            process.terminate()
        assert process.wait(60) == 0


@pytest.mark.parametrize(
    ("handlers", "said"),
    [
        ("def configure(net) print()", r":1: no Python: expected ':'"),
        ("import nowhere", r":1: ModuleNotFoundError: No module named 'nowhere'"),
        ("x = 1", "defines no function configure(net)"),
        (
            "def configure(net):\n    net.handler('Sai')(print)",
            ":2: the node talker has no transition 'Sai' (did you mean 'Say'?)",
        ),
    ],
)
def test_handlers_that_cannot_be_used(run: Run, model: Path, handlers: str, said: str) -> None:
    model.with_name("handlers.py").write_text(handlers, encoding="utf-8")
    result = run("run", model, "--simulate")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(str(model.with_name("handlers.py")))
    assert said in result.stderr
    assert result.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--until", "Notd >= 1"], "no place is named 'Notd'"),
        (["--until", "fired(Say)"], "fired"),
        (["--resume"], "--resume needs the traces"),
        (["--with", "echo"], "--with needs ROS"),
        (["--handlers", "nothing.py"], "nothing.py"),
        (["--stale-after", "Buton=1"], "no node has a signal 'Buton' (did you mean 'Button'?)"),
        (["--stale-after", "Button"], "gives no time"),
        (["--stale-after", "Button=soon"], "'soon' is not a time in seconds"),
        (["--stale-after", "Button=1:maybe"], "a stale signal cannot be handled by 'maybe'"),
    ],
)
def test_wrong_options(run: Run, model: Path, options: list[str], said: str) -> None:
    result = run("run", model, "--simulate", *options)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (2, "", 1)
    assert said in result.stderr


def test_traces_of_another_run_are_not_overwritten(run: Run, spoken: Path) -> None:
    folder = spoken.parent / "traces"
    assert run("run", spoken, "--simulate", "--until", "Words <= 2", "--trace", folder).exit_code == 0
    result = run("run", spoken, "--simulate", "--trace", folder)
    assert result.exit_code == 2
    assert "has a trace of node 'talker' already" in result.stderr


def test_a_pace_is_for_simulations(run: Run, spoken: Path) -> None:
    result = run("run", spoken, "--simulate", "--speed", 100, "--until", "Noted >= 3", "--timeout", 60)
    assert result.exit_code == 0, result.stderr
    result = run("run", spoken, "--local", "--speed", 2, "--timeout", 1)
    assert result.exit_code == 2
    assert result.stderr.startswith("dineros: --speed needs --simulate (")
    assert run("run", spoken, "--simulate", "--speed", 0).exit_code == 2
