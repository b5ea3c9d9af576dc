"""Every command that draws, with a layouter that is killed at every use: the same answer, and no picture."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from websockets.sync.client import connect
from websockets.typing import Origin

from tests.cli.conftest import Run
from tests.support.programs.layouter import LINE, VARIABLE
from tests.views.samples import lasso

STARTS = {".svg": "<svg ", ".html": "<!doctype html>"}
LOSES = ["--set", "Chatter.subscriber.Heard.limit=2"]


def started(*arguments: object, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run Python with a layouter that dies."""
    return subprocess.run(
        [sys.executable, *map(str, arguments)],
        cwd=folder,
        env={**os.environ, VARIABLE: "dies"},
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
    )


@pytest.mark.long
@pytest.mark.parametrize(
    ("command", "says"),
    [
        (["check", "MODEL", *LOSES, "-o", "out.html"], f"out.html: without pictures: {LINE}"),
        (["trace", "TRACE", "-o", "out.html"], f"out.html: without the net: {LINE}"),
        (["rules", "T2", "-o", "out.svg"], ""),
    ],
)
def test_the_answer_is_the_same(
    run: Run,
    model: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: list[str],
    says: str,
) -> None:
    files = {"MODEL": model, "TRACE": lasso().save(tmp_path / "trace.jsonl")}
    arguments = [files.get(word, word) for word in command]
    result = started("-m", "dineros.cli.main", *arguments, folder=tmp_path)
    drawn = tmp_path / command[command.index("-o") + 1]
    text = drawn.read_text(encoding="utf-8")
    assert text[:500].lower().find(STARTS[drawn.suffix]) >= 0
    if "check" in command:
        assert "Step by step" in text
        assert "<figure" not in text
    drawn.unlink()
    monkeypatch.chdir(tmp_path)
    usual = run(*arguments)
    assert result.stderr == says + usual.stderr
    assert result.returncode == usual.exit_code == (1 if "check" in command else 0)
    seconds = re.compile(r"\d+\.\d+ s")
    assert seconds.sub("", result.stdout) == seconds.sub("", usual.stdout)


@pytest.mark.long
@pytest.mark.parametrize(
    "command",
    [
        ["convert", "MODEL", "-o", "out.html"],
        ["convert", "MODEL", "-o", "out.svg"],
        ["convert", "MODEL", "-o", "out.png"],
        ["view", "MODEL"],
        ["view", "MODEL", "--width", "180", "-o", "out.svg"],
        ["view", "MODEL", "--compare", "MODEL", "-o", "out.html"],
        ["trace", "TRACE", "-o", "out.svg", "--fold"],
        ["trace", "TRACE", "--compare", "OTHER", "-o", "out.png"],
    ],
)
def test_what_only_draws_says_in_one_line_that_it_cannot(
    model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: list[str]
) -> None:
    files = {
        "MODEL": model,
        "TRACE": lasso().save(tmp_path / "trace.jsonl"),
        "OTHER": lasso(differs=True).save(tmp_path / "other.jsonl"),
    }
    before = sorted(tmp_path.iterdir())
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    result = started("-m", "dineros.cli.main", *(files.get(word, word) for word in command), folder=tmp_path)
    assert (result.returncode, result.stderr) == (2, f"dineros: {LINE}")
    assert result.stdout.startswith("first divergence" if "OTHER" in command else "")
    assert sorted(tmp_path.iterdir()) == before


def test_a_run_with_its_page(model: Path, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "dineros.cli.main", "run", str(model), "--local", "--view"]
    with subprocess.Popen(
        command,
        cwd=tmp_path,
        env={**os.environ, VARIABLE: "dies", "XDG_STATE_HOME": str(tmp_path / "state")},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().removeprefix("follow it at ").strip()
            assert address.startswith("http://127.0.0.1:")
            changes = address.replace("http", "ws").replace("/?", "/changes?")
            with connect(changes, origin=Origin(address.split("/?")[0]), max_size=None) as socket:
                while json.loads(socket.recv(timeout=60))["type"] != "snapshot":
                    pass
                assert process.stderr is not None
                line = process.stderr.readline().removeprefix("[WARNING] [dineros.views.live]: ")
            process.send_signal(signal.SIGINT)
            answer, said = process.communicate(timeout=60)
        finally:
            process.kill()
    assert (process.returncode, line, said) == (0, f"the live page shows no net: {LINE}", "")
    assert answer.startswith("interrupted; marked: ")
