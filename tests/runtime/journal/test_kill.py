"""Nodes of the case study are killed fifty times, in the middle of things: nothing is lost or done twice."""

from __future__ import annotations

import contextlib
import queue
import random
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.elements import node_nets
from dineros.metamodel.files import load
from dineros.metamodel.records import Fire, Record, Start, read_trace, traces_of_runs
from dineros.metamodel.settings import apply
from dineros.runtime.journal import rebuild_at
from tests.support.programs.socket_transport import Broker
from tests.support.ros2_systems.mortal_nodes import CASE_STUDY

ROOT = Path(__file__).resolve().parents[3]
KILLS = 50
OBJECTS = 5
DEADLINE = 150.0


class Nodes:
    """The process that forks nodes, and what it says."""

    def __init__(self, folder: Path, broker: Path) -> None:
        self._process = subprocess.Popen(
            [sys.executable, "-m", "tests.support.ros2_systems.mortal_nodes", str(folder), str(broker)],
            cwd=ROOT,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        self.said: queue.Queue[str] = queue.Queue()
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            self.said.put(line.strip())

    def tell(self, *words: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.write(" ".join(map(str, words)) + "\n")
        self._process.stdin.flush()

    def close(self) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        try:
            self._process.wait(20)
        finally:
            self._process.kill()
            self._process.wait()
            self._reader.join()


@contextlib.contextmanager
def running(folder: Path) -> Iterator[Nodes]:
    with tempfile.TemporaryDirectory() as short:  # the path of a socket must be short
        path = Path(short) / "broker"
        with Broker(path):
            nodes = Nodes(folder, path)
            try:
                assert nodes.said.get(timeout=60) == "ready"
                yield nodes
            finally:
                nodes.close()


def model() -> sym.SystemModel:
    loaded = load(CASE_STUDY)
    assert isinstance(loaded, sym.SystemModel)
    for setting in ("RedObjects.tokens=2", "GreenObjects.tokens=2"):
        apply(loaded, setting)
    return loaded


def shown(folder: Path) -> int:
    with contextlib.suppress(Exception):  # the file is being rotated
        return rebuild_at(folder, "feedback").counts().get("Shown", 0)
    return 0


@pytest.mark.long
def test_fifty_kills(tmp_path: Path) -> None:
    draw = random.Random(20)
    system = model()
    names = [node.id for node in node_nets(system)]
    folder = tmp_path / "run"
    deaths: Counter[str] = Counter()
    end = time.monotonic() + DEADLINE
    with running(folder) as nodes:

        def start(name: str) -> None:
            point = 0
            if not deaths[name]:
                point = draw.randint(1, 3)  # header, checkpoint, start
            elif sum(deaths.values()) + len(names) <= KILLS + 5:
                point = draw.choice([draw.randint(1, 6), draw.randint(4, 60)])
            nodes.tell(
                "start", name, draw.randrange(10**6), point, draw.choice([0, draw.randint(1, 999), 1000])
            )

        for name in names:
            start(name)
        while sum(deaths.values()) < KILLS or shown(folder) < OBJECTS:
            assert time.monotonic() < end, (deaths, shown(folder))
            try:
                said, name = nodes.said.get(timeout=0.1).split()
            except queue.Empty:
                continue
            assert said == "died", (said, name)
            deaths[name] += 1
            start(name)
        nodes.tell("stop")
        left = set(names)
        while left:
            said, name = nodes.said.get(timeout=30).split()
            if said == "died":  # at its point, just when it was told to stop
                nodes.tell("start", name, draw.randrange(10**6), 0, 0)
                nodes.tell("stop")
            else:
                assert said == "ended", (said, name)
                left.remove(name)

    traces = traces_of_runs([folder])
    records: dict[str, list[Record]] = {name: list(read_trace(parts)) for name, parts in traces.items()}
    assert set(traces) == set(deaths) == set(names)
    assert len(traces["executor"]) > 1, "no part was rotated"
    # Every object was sorted once; nothing is left over, and nothing is there twice.
    assert rebuild_at(folder, "feedback").counts() == {"Shown": OBJECTS}
    fired = Counter(
        record.transition for trace in records.values() for record in trace if isinstance(record, Fire)
    )
    assert fired["TShowResult"] == OBJECTS
    assert fired["TReportL"] + fired["TReportR"] == OBJECTS
    # Each restart continued where the journal ended.
    resumed = [
        record
        for trace in records.values()
        for record in trace
        if isinstance(record, Start) and record.resumed
    ]
    assert len(resumed) >= KILLS // 2
    verdict = conform(system, {name: partial(read_trace, parts) for name, parts in traces.items()})
    assert verdict.status == "conforms", (verdict.violations, verdict.unknown)
