"""A run on ROS 2, each node a process of its own, is steered from its live page as others are."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
from playwright.sync_api import expect

from dineros.analysis.conformance import conform
from dineros.metamodel.files import save
from dineros.metamodel.records import Record, Signal, Start, read_trace, traces_of_runs
from tests.support.programs.on_ros import on_ros
from tests.support.systems.talker import talker
from tests.views.browser import Visit

NewVisit = Callable[..., Visit]

PATIENCE = 240.0
"""Seconds: the first run on a machine builds the interfaces."""

HANDLERS = """
import os
from pathlib import Path

def configure(net):
    Path(f"{net.id}.pid").write_text(str(os.getpid()))
"""


@pytest.mark.long
def test_a_signal_is_set_and_nodes_are_paused_killed_and_go_on(tmp_path: Path, visit: NewVisit) -> None:
    model = talker()
    save(model, tmp_path / "greeting.sym.xmi")
    (tmp_path / "handlers.py").write_text(HANDLERS, encoding="utf-8")
    command = [sys.executable, "-P", "-m", "dineros.cli.main", "run", "greeting.sym.xmi", "--view"]
    command += ["--monitor", "--trace", "traces", "--reach", "memory"]
    command += ["--timeout", str(PATIENCE), "--until", "Noted >= 3"]
    one = visit()
    page = one.page

    def shown(node: str, text: str) -> None:
        expect(page.locator(f"#steer [data-node={node}]")).to_contain_text(text, timeout=PATIENCE * 1000)

    def click(role: str, name: str) -> None:
        page.get_by_role(role, name=name).click(timeout=PATIENCE * 1000)  # type: ignore[arg-type]

    with (
        on_ros(),
        subprocess.Popen(
            command, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
        ) as run,
    ):
        try:
            assert run.stdout is not None
            address = next(filter(None, (re.search(r"http://\S+", line) for line in run.stdout)))
            page.goto(address[0])
            click("button", "Pause talker")
            click("button", "Pause listener")
            shown("talker", "halted: paused on the live page")
            shown("listener", "halted: paused on the live page")
            click("switch", "Button: false")
            shown("talker", "enabled: Say")
            # The talker begins again with the signal that was set, and without having been paused.
            os.kill(int((tmp_path / "talker.pid").read_text()), signal.SIGKILL)
            shown("listener", "enabled: Listen")
            shown("talker", "running")
            shown("talker", "Button: true")
            click("button", "Proceed listener")
            said = run.stdout.read()
            assert run.wait(PATIENCE) == 0, said
        finally:
            run.kill()
    assert "the condition holds; marked: Noted 3\nconformance: conforms, " in said
    assert "talker ended with signal SIGKILL" in said
    assert one.problems == []
    parts = traces_of_runs([tmp_path / "traces"])
    talks: list[Record] = list(read_trace(parts["talker"]))
    (pressed,) = [record for record in talks if isinstance(record, Signal)]
    assert (pressed.signal, pressed.value, pressed.source) == ("Button", True, "live page")
    assert [record.resumed for record in talks if type(record) is Start] == [False, True]
    traces = {node: partial(read_trace, each) for node, each in parts.items()}
    assert conform(model, traces).status == "conforms"
