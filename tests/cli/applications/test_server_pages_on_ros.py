"""Server instances that call a service on real ROS 2: each gets its own answer, also after a crash."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from dineros.metamodel.records import Request, Response, read_trace, traces_of_runs
from tests.support.programs.on_ros import on_ros
from tests.support.systems.bakery import bakery

HANDLERS = """
import asyncio
import os
import signal
from pathlib import Path


def configure(net):
    if net.id == "oven":

        @net.handler("Heat")
        async def heat(firing):  # what was asked first is answered last
            await asyncio.sleep(0.4 if firing.instance == 1 else 0.1)

    if net.id == "shop":

        @net.handler("HandOver")
        def hand_over(firing):
            if not Path("crashed").exists():  # with the other instance's call under way
                Path("crashed").touch()
                os.kill(os.getpid(), signal.SIGKILL)
"""


@pytest.mark.long
def test_answers_come_back_to_the_instance_that_asked(tmp_path: Path) -> None:
    save(bakery(), tmp_path / "bakery.sym.xmi")
    (tmp_path / "handlers.py").write_text(HANDLERS, encoding="utf-8")
    until = "Gotann >= 2 & Gotbob >= 2 & Printed >= 4"
    command = [sys.executable, "-m", "dineros.cli.main", "run", "bakery.sym.xmi", "--until", until]
    options = ["--trace", "traces", "--reach", "memory", "--timeout", "150", "--monitor"]
    with on_ros():
        done = subprocess.run([*command, *options], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "conformance: conforms" in done.stdout
    assert "20 firings, 0 drops, 0 errors, 1 restart" in done.stdout
    traces = traces_of_runs([tmp_path / "traces"])
    records = [record for parts in traces.values() for record in read_trace(parts)]
    answers = [record for record in records if isinstance(record, Response)]
    for name in ("ann", "bob"):
        labels = {record.data["label"] for record in answers if record.client == name}
        assert labels == {f"{name}1", f"{name}2"}
    baking = [record for record in records if isinstance(record, Request) and record.channel == "Bake"]
    assert {record.client for record in baking} == {"Order[1].baker", "Order[2].baker"}
