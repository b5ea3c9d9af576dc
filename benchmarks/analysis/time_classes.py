"""State classes and time as a counter: which construction is small and quick for which time net, as Markdown.

Each row runs in a process of its own, so that peak memory is its own; kernels are loaded before the clock
starts. Classes of W and S are compared by equality, those of M and E by inclusion; A are atomic; `integer`
counts units of time and has only markings. The markings of all engines must be the same.

Usage: ``python -m benchmarks.analysis.time_classes [--long] [words to choose rows by]``. With ``--long`` the
rows come too that have millions of classes. Each row has two minutes.
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from fractions import Fraction
from functools import partial
from pathlib import Path
from typing import cast

from benchmarks.analysis.state_spaces import machine
from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import Transition
from dineros.analysis.nets.memory import peak_memory
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.nets import Interval, TimedNet, compile_timed_net
from dineros.analysis.timed.state_space import timed_state_space
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load

FOLDER = Path(__file__).resolve().parents[3] / "shared/tpn/nets"
PUBLISHED = ("trains2", "trains3", "trains4", "countertrains3", "countertrains4", "train3fault")
ENGINES = ("W", "M", "S", "E", "A", "integer")
LIMITS = Budget(seconds=120, memory_bytes=8 << 30)
COLUMNS = ("net", "engine", "classes", "edges", "markings", "processor s", "peak MiB")


def between(earliest: int, latest: int | None = None) -> Interval:
    """Return a closed interval."""
    return Interval(Fraction(earliest), None if latest is None else Fraction(latest))


def camera(longest: int) -> TimedNet:
    """A timer of 100 and a handler of 30 up to a longest time, with a history of depth 10."""
    steps = [
        Transition("strike", {"clock": 1}, {"clock": 1, "due": 1}),
        Transition("arrive", {"due": 1, "free": 1}, {"queue": 1}),
        Transition("lose", {"due": 1}, {}, {"free": 1}),
        Transition("begin", {"queue": 1, "idle": 1}, {"busy": 1, "free": 1}),
        Transition("end", {"busy": 1}, {"idle": 1}),
    ]
    now = between(0, 0)
    times = {
        "strike": between(100, 100),
        "end": between(30, longest),
        "arrive": now,
        "lose": now,
        "begin": now,
    }
    places = {"clock": 1, "due": 0, "free": 10, "queue": 0, "idle": 1, "busy": 0}
    return TimedNet.build(places, steps, times)


def line(cells: int, parts: int) -> TimedNet:
    """A manufacturing line: parts go through cells, one vehicle moves them, each cell holds one."""
    places, steps = {"stock": parts, "vehicle": 1}, []
    times: dict[str, Interval] = {}
    before = "stock"
    for cell in range(1, cells + 1):
        idle, moving, busy, done = (f"{what} {cell}" for what in ("idle", "moving", "busy", "done"))
        places |= {idle: 1, moving: 0, busy: 0, done: 0}
        steps += [
            Transition(f"fetch {cell}", {before: 1, "vehicle": 1, idle: 1}, {moving: 1}),
            Transition(f"arrive {cell}", {moving: 1}, {"vehicle": 1, busy: 1}),
            Transition(f"finish {cell}", {busy: 1}, {done: 1, idle: 1}),
        ]
        times |= {f"fetch {cell}": between(0, 1), f"arrive {cell}": between(1, 2)}
        times[f"finish {cell}"] = between(2 + cell % 3, 4 + cell % 2 * 2 + cell % 3)
        before = done
    steps.append(Transition("ship", {before: 1}, {"stock": 1}))
    times["ship"] = between(1, 3)
    return TimedNet.build(places, steps, times)


def tasks(count: int) -> TimedNet:
    """Periodic tasks on one processor; those with shorter periods have priority."""
    places, steps, pairs = {"processor": 1}, [], []
    times: dict[str, Interval] = {}
    for task in range(1, count + 1):
        clock, ready, runs = (f"{what} {task}" for what in ("clock", "ready", "runs"))
        places |= {clock: 1, ready: 0, runs: 0}
        steps += [
            Transition(f"strike {task}", {clock: 1}, {clock: 1, ready: 1}, {ready: 1}),
            Transition(f"miss {task}", {clock: 1}, {clock: 1}, {}, {ready: 1}),
            Transition(f"begin {task}", {ready: 1, "processor": 1}, {runs: 1}),
            Transition(f"end {task}", {runs: 1}, {"processor": 1}),
        ]
        period = 4 * task + 2
        times |= {f"strike {task}": between(period, period), f"miss {task}": between(period, period)}
        times |= {f"begin {task}": between(0, 0), f"end {task}": between(1, 2)}
        pairs += [(f"begin {other}", f"begin {task}") for other in range(1, task)]
    return TimedNet.build(places, steps, times, pairs)


def published(name: str) -> TimedNet:
    """Read a net from the folder next to the project."""
    return compile_timed_net(load(FOLDER / f"{name}.net"))


NETS: dict[str, Callable[[], TimedNet]] = {
    **{name: partial(published, name) for name in PUBLISHED if FOLDER.exists()},
    "camera-90": partial(camera, 90),
    "camera-120": partial(camera, 120),
    "camera-121": partial(camera, 121),
    "line-4-4": partial(line, 4, 4),
    "line-5-5": partial(line, 5, 5),
    "line-7-5": partial(line, 7, 5),
    "tasks-2": partial(tasks, 2),
    "tasks-3": partial(tasks, 3),
    "tasks-4": partial(tasks, 4),
}
LONG = ("line-7-5",)


def measure(name: str, engine: str) -> tuple[str, int | None]:
    """Return a row of the table, and the markings if all of them were counted."""
    net, kind = NETS[name](), cast(Kind, engine if engine != "integer" else "W")
    way = "integer" if engine == "integer" else "classes"
    try:
        timed_state_space(tasks(1) if net.has_priorities else line(1, 1), kind, way)  # type: ignore[arg-type]
        before = used()
        space = timed_state_space(net, kind, way, LIMITS.begun())  # type: ignore[arg-type]
    except DinerosError as error:
        return f"| {name} | {engine} | {error.message} | | | | |", None
    counts = [f"{n:,}" if n is not None else "" for n in (space.classes, space.edges, space.markings)]
    if not space.complete:
        counts = [f"not all: {space.reason}", "", ""]
    cells = (name, engine, *counts, f"{used() - before:.2f}", f"{peak_memory() >> 20}")
    return f"| {' | '.join(cells)} |", space.markings if space.complete else None


def used() -> float:
    """Seconds of the processor of this process so far."""
    now = resource.getrusage(resource.RUSAGE_SELF)
    return now.ru_utime + now.ru_stime


def main(words: list[str]) -> int:
    """Print the table; 1 if two engines count different markings."""
    chosen = [word for word in words if word != "--long"]
    context, wrong, began = multiprocessing.get_context("spawn"), 0, time.perf_counter()
    print(machine(), end="\n\n")
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    for name in NETS:
        if name in LONG and "--long" not in words:
            continue
        markings = set()
        for engine in ENGINES:
            if not all(word in f"{name} {engine}" for word in chosen):
                continue
            with ProcessPoolExecutor(1, mp_context=context) as pool:
                row, counted = pool.submit(measure, name, engine).result()
            print(row, flush=True)
            markings |= {counted} - {None}
        if len(markings) > 1:
            print(f"{name}: the engines count different markings")
            wrong = 1
    print(f"\n{time.perf_counter() - began:.0f} s in all")
    return wrong


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
