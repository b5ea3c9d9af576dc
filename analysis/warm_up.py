"""Compiles all kernels ahead of the first question, several processes side by side.

A kernel is compiled when it is first called. Each part answers questions about small nets, which call all
kernels of an engine with the types of arguments that are used later. Numba stores the compiled code for all
later processes. Numba compiles one kernel at a time in a process, so processes are used, not threads.
"""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from hashlib import blake2b
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.kernel_cache import ROOM, kept_in
from dineros.metamodel.errors import DinerosError

if TYPE_CHECKING:
    from dineros.analysis.timed.classes import Kind

MEMORY = 1 << 26
"""Bytes that a question of a warm-up may take."""


def is_warm() -> bool:
    """Whether a warm-up went through, for the present versions and processor."""
    mark = _mark()
    return mark is not None and mark.is_file()


def warm_up(processes: int) -> None:
    """Compile what is not compiled yet, with a number of processes at a time.

    Raises
    ------
    DinerosError
        Where a process fails, or where nothing that is compiled can be kept.
    """
    mark = _mark()
    if mark is None:
        raise DinerosError(
            "compiled engines cannot be kept", hint="NUMBA_CACHE_DIR names a folder to write to"
        )
    with ThreadPoolExecutor(max(1, processes)) as pool:
        ended = list(pool.map(_in_a_process, PARTS))
    failed = [process for process in ended if process.returncode != 0]
    if failed:
        lines = failed[0].stderr.strip().splitlines() or [f"exit status {failed[0].returncode}"]
        raise DinerosError(f"the engines cannot be compiled: {lines[-1]}")
    mark.touch()


def _mark() -> Path | None:
    """Return the file which shows that all is compiled; None if no folder is writable."""
    from llvmlite.binding import get_host_cpu_name
    from numba import __version__

    folder = kept_in()
    # Kernels are kept by the path of their module, too: a copy of a package has none of its own yet.
    place = blake2b(str(ROOM).encode(), digest_size=4).hexdigest()
    name = f"warm-{sys.implementation.cache_tag}-{__version__}-{get_host_cpu_name()}-{place}"
    return None if folder is None else folder / name


def _in_a_process(part: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-P", "-m", __name__, part],
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        errors="replace",
        check=False,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )


def rings(count: int) -> CompiledNet:
    """Return a net of rings of two places with a token each: a bit of a stored marking for every ring.

    In a last ring two tokens go around, so that the net has several markings however a search goes.
    """
    places = {f"p{k}": k % 2 for k in range(2 * count)} | {"here": 2, "there": 0}
    moves = [(f"t{k}", {f"p{k}": 1}, {f"p{k ^ 1}": 1}) for k in range(2 * count)]
    return CompiledNet.build(
        places, [*moves, ("go", {"here": 1}, {"there": 1}), ("back", {"there": 2}, {"here": 2})]
    )


def _search(count: int) -> None:
    """Compile explicit search for markings as wide as those of a number of rings."""
    from dineros.analysis.explicit import explore

    net = rings(count)
    for order in ("breadth-first", "depth-first"):
        explore(net, Budget(MEMORY, states=4), order=order, workers=1)


def _search_growing() -> None:
    """Compile again, for wider markings, if a place outgrows its bits."""
    from dineros.analysis.explicit import explore

    net = CompiledNet.build({"p": 1, "q": 0}, [("make", {"p": 1}, {"p": 1, "q": 1})])
    explore(net, Budget(MEMORY, states=1_000), workers=1)


def _diagrams() -> None:
    """Compile decision diagrams: saturation, operations on sets, counting, garbage collection."""
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.level_starts import starts
    from dineros.analysis.symbolic.levels import encode
    from dineros.analysis.symbolic.relations import EventTables
    from dineros.analysis.symbolic.saturation import Diagram
    from dineros.analysis.symbolic.stages.contraction import contracted
    from dineros.analysis.symbolic.vector_sets import VectorSets

    # Some transition is always enabled in rings; here a deadlock is counted.
    meeting = symbolic_state_space(
        CompiledNet.build({"a": 1, "b": 1, "c": 0}, [("meet", {"a": 1, "b": 1}, {"c": 2})]), Budget(MEMORY)
    )
    meeting.arcs(), meeting.deadlocks()
    space = symbolic_state_space(rings(3), Budget(MEMORY))
    space.arcs(), space.deadlocks(), space.largest_place(), space.is_stable(0)
    list(starts(space.encoding, EventTables.of(space.encoding)))  # easy nets need no other order
    levels = range(len(space.encoding.levels))
    diagram = Diagram(space.encoding, levels, MEMORY, first_cache=4, first_buckets=1)
    diagram.run()
    diagram.collect([])
    sets = VectorSets(space.diagram)
    at, everything = [level.initial for level in space.encoding.levels], space.diagram.root
    sets.contains(everything, at)
    sets.descent(at, [sets.image(sets.single(at), everything, backwards=False), everything])
    step = encode(CompiledNet.build({"a": 1, "b": 0}, [("step", {"a": 1}, {"b": 1})]), keep=range(2))
    contraction = contracted(step)
    assert contraction is not None
    small = Diagram(contraction.encoding, range(len(step.levels)), MEMORY)
    small.run()
    contraction.expanded(small)


def _formulas() -> None:
    """Compile branching time, on markings stored one by one and on diagrams."""
    from dineros.analysis.portfolio.branching_time import check_ctl

    net = rings(1)
    for engine in ("explicit", "symbolic"):
        for formula in ("AG EF there >= 2", "EG here >= 1", "A[here >= 1 U there >= 2]", "AX there >= 1"):
            check_ctl(net, formula, budget=Budget(MEMORY), engine=engine)


def _runs() -> None:
    """Compile linear time, with fair transitions and the way to a counterexample."""
    from dineros.analysis.logic.ltl.verification import verify_ltl

    net = rings(1)
    for formula in ("G F here >= 2", "F G there >= 1", "G (here >= 1 | (there >= 2 & enabled(back)))"):
        for weak, strong in (((), ()), (("go",), ("back",))):
            verify_ltl(net, formula, weak=weak, strong=strong, budget=Budget(MEMORY))
    # A component without a fair run that only the search of its graph rejects.
    moves = [("press", {"off": 1}, {"on": 1}), ("release", {"on": 1}, {"off": 1})]
    moves += [("go", {"left": 1, "on": 1}, {"on": 1}), ("rest", {"off": 1}, {"off": 1})]
    net = CompiledNet.build({"left": 1, "on": 0, "off": 1}, moves)
    verify_ltl(net, "F left == 0", strong=["go", "press"], budget=Budget(MEMORY))


def _walks() -> None:
    """Compile walks at random and along a solution of the state equation."""
    from dineros.analysis.portfolio.walker import Walker, follow
    from dineros.analysis.walks.scouting import Scout

    Scout(rings(1)).walk()
    walks = Walker(rings(1))
    walks.walk()
    follow(walks.arrays, np.ones(len(walks.net.transitions), dtype=np.int64), 1)


def _state_classes() -> None:
    """Compile the search through state classes of all kinds, and schedules of runs."""
    from fractions import Fraction

    from dineros.analysis.timed.atomic import AtomicSearch
    from dineros.analysis.timed.nets import Interval, TimedNet
    from dineros.analysis.timed.schedules import schedule
    from dineros.analysis.timed.search import ClassSearch

    work = Transition("work", {"p": 1}, {"q": 1})
    rest = Transition("rest", {"q": 1}, {"p": 1})
    late = Interval(Fraction(1))
    net = TimedNet.build(
        {"p": 1, "q": 0}, [work, rest], {"work": Interval(Fraction(1), Fraction(2)), "rest": late}
    )
    kinds: tuple[Kind, ...] = ("W", "M", "S", "E")
    for kind in kinds:
        search = ClassSearch(net, kind, Budget(MEMORY), keeps_parents=True)
        search.run()
        search.enlarge_tables(always=True)
        search.domain(0)
        if kind in "WS":
            ClassSearch(net, kind, Budget(MEMORY), keeps_edges=True, workers=2, least_for_threads=0).run()
    cutting = AtomicSearch(net, Budget(MEMORY))
    cutting.run()
    cutting.enlarge_table()
    schedule(net, [0, 1])


PARTS: dict[str, Callable[[], None]] = {
    "state classes": _state_classes,
    "search": partial(_search, 8),
    "diagrams": _diagrams,
    "runs": _runs,
    "search, two words": partial(_search, 80),
    "search, wide": partial(_search, 160),
    "formulas": _formulas,
    "search, growing": _search_growing,
    "walks": _walks,
}
"""The parts that are compiled by separate processes, the longest first."""


if __name__ == "__main__":
    PARTS[sys.argv[1]]()
