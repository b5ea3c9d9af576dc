"""Every command that draws, with a layouter that is killed at every use: the same answer, another picture."""

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
from tests.support.layouter import LINE, VARIABLE
from tests.views.samples import lasso

ROOT = Path(__file__).resolve().parents[2]
STARTS = {".svg": b"<svg ", ".png": b"\x89PNG", ".html": b"<!doctype html>"}
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
        (["convert", "MODEL", "-o", "out.html"], "nets are laid out by Graphviz"),
        (["convert", "MODEL", "-o", "out.svg"], "nets are laid out by Graphviz"),
        (["convert", "MODEL", "-o", "out.png"], "nets are laid out by Graphviz"),
        (["view", "MODEL", "--around", "Listen", "-o", "out.svg"], "nets are laid out by Graphviz"),
        (["view", "MODEL", "--compare", "MODEL", "-o", "out.html"], "nets are laid out by Graphviz"),
        (["check", "MODEL", *LOSES, "-o", "out.html"], "nets are laid out by Graphviz"),
        (["trace", "TRACE", "-o", "out.html"], "nets are laid out by Graphviz"),
        (["trace", "TRACE", "-o", "out.svg", "--fold"], "traces are drawn plainly"),
        (["trace", "TRACE", "--compare", "OTHER", "-o", "out.png"], "traces are drawn plainly"),
        (["rules", "T2", "-o", "out.svg"], None),
    ],
)
def test_the_answer_is_the_same(
    run: Run,
    model: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    command: list[str],
    says: str | None,
) -> None:
    files = {
        "MODEL": model,
        "TRACE": lasso().save(tmp_path / "trace.jsonl"),
        "OTHER": lasso(differs=True).save(tmp_path / "other.jsonl"),
    }
    arguments = [files.get(word, word) for word in command]
    result = started("-m", "dineros.cli.main", *arguments, folder=tmp_path)
    drawn = tmp_path / command[command.index("-o") + 1]
    assert drawn.read_bytes()[:500].lower().find(STARTS[drawn.suffix].lower()) >= 0
    if "check" in command:
        report = drawn.read_text(encoding="utf-8")
        for what in (
            'class="lane queue" data-id="Heard"',
            'class="place marked" data-id="Heard"',
            "Step by step",
        ):
            assert what in report, what
    for made in tmp_path.glob("out.*"):
        made.unlink()
    monkeypatch.chdir(tmp_path)
    usual = run(*arguments)
    assert result.stderr == (f"{says}: {LINE}" if says else usual.stderr)
    assert result.returncode == usual.exit_code == (1 if "check" in command else 0)
    seconds = re.compile(r"\d+\.\d+ s")
    assert seconds.sub("", result.stdout) == seconds.sub("", usual.stdout)


GUIDE = """
import sys
from pathlib import Path
sys.path.insert(0, "docs/hooks")
import pictures, trace_pictures
made = {**pictures.pictures(), **trace_pictures.pictures()}
assert all("<svg" in str(text) or "<html" in str(text) for text in made.values())
assert not [name for name, text in made.items() if len(text) < 5000]
print(len(made))
"""


@pytest.mark.long
def test_the_guide_is_complete() -> None:
    result = started("-c", GUIDE, folder=ROOT)
    assert (result.returncode, result.stdout) == (0, "16\n"), result.stderr
    assert result.stderr == f"nets are laid out by Graphviz: {LINE}"


FOLLOWED = """
import sys, time, urllib.request
from pathlib import Path
from dineros.metamodel.files import load
from dineros.views.live import serve_live
from tests.views.samples import CASE_STUDY, save_run
from websockets.sync.client import connect
import json
handle = serve_live(save_run(Path(sys.argv[1])), load(CASE_STUDY))
with connect(handle.url.replace("http", "ws").replace("/?", "/changes?"), origin=handle.url.split("/?")[0],
             max_size=None) as socket:
    while True:
        message = json.loads(socket.recv(timeout=120))
        if message.get("net"):
            break
assert any(node["id"] == "SelectRed" for node in message["net"]["nodes"])
handle.stop()
"""


def test_the_live_page_shows_the_net(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    result = started("-c", FOLLOWED, tmp_path / "run", folder=tmp_path)
    assert (result.returncode, result.stderr) == (0, f"nets are laid out by Graphviz: {LINE}")


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
                while not (net := json.loads(socket.recv(timeout=60)).get("net")):
                    pass
            process.send_signal(signal.SIGINT)
            answer, said = process.communicate(timeout=60)
        finally:
            process.kill()
    assert {"Say", "Heard"} <= {node["id"] for node in net["nodes"]}
    said = said.removeprefix("[WARNING] [dineros.views]: ")
    assert (process.returncode, said) == (0, f"nets are laid out by Graphviz: {LINE}")
    assert answer.startswith("interrupted; marked: ")
