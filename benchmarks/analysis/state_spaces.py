"""Every engine on every net: a table of markings, times and memory, as Markdown.

Each row runs in a process of its own, so that peak memory is its own; kernels are loaded before the clock
starts. Seconds of wall-clock time mean something on a quiet machine only: processor seconds and the load
are beside them. The engines are `symbolic`, `explicit-1` and `explicit-2` (workers), `depth-first`, and
`reduced` (rules that keep the number of markings, then the symbolic engine; markings are those of the whole
net).

Usage: ``python -m benchmarks.analysis.state_spaces [--long] [words to choose rows by]``. With ``--long`` the
rows come too that take the explicit engine minutes and gigabytes.
"""

from __future__ import annotations

import multiprocessing
import os
import platform
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from decimal import Decimal
from functools import partial
from importlib.metadata import version
from pathlib import Path

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.memory import peak_memory
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import SIGNAL_VARIANTS, reference_case_study

NETS: dict[str, Callable[[], CompiledNet]] = {
    "philosophers-10": lambda: classic.philosophers(10),
    "philosophers-12": lambda: classic.philosophers(12),
    "philosophers-20": lambda: classic.philosophers(20),
    "philosophers-100": lambda: classic.philosophers(100),
    "philosophers-1000": lambda: classic.philosophers(1_000),
    "kanban-5": lambda: classic.kanban(5),
    "kanban-50": lambda: classic.kanban(50),
    "kanban-200": lambda: classic.kanban(200),
    "fms-5": lambda: classic.flexible_manufacturing(5),
    "fms-10": lambda: classic.flexible_manufacturing(10),
    "fms-20": lambda: classic.flexible_manufacturing(20),
    "fms-100": lambda: classic.flexible_manufacturing(100),
    "round-robin-10": lambda: classic.round_robin_mutex(10),
    "round-robin-14": lambda: classic.round_robin_mutex(14),
    "round-robin-100": lambda: classic.round_robin_mutex(100),
    "round-robin-200": lambda: classic.round_robin_mutex(200),
    "swimming-pool-1": lambda: classic.swimming_pool(1),
    "swimming-pool-2": lambda: classic.swimming_pool(2),
    "swimming-pool-5": lambda: classic.swimming_pool(5),
    "swimming-pool-10": lambda: classic.swimming_pool(10),
}
for _variant in SIGNAL_VARIANTS:
    for _n in (1, 3, 5, 10):
        NETS[f"case-study-{_variant}-{_n}"] = partial(reference_case_study, (_n, _n, _n), _variant)
#: What the explicit engine takes minutes for.
LONG = ["case-study-io-1", "case-study-fully-1"]
#: Classic nets that the explicit engine counts too.
SMALL = (
    "philosophers-10",
    "philosophers-12",
    "kanban-5",
    "fms-5",
    "round-robin-10",
    "round-robin-14",
    "swimming-pool-1",
    "swimming-pool-2",
)
EXPLICIT = [*SMALL, "case-study-none-1", "case-study-input-1", *LONG]
MEMORY = 8 << 30
COLUMNS = (
    "net",
    "engine",
    "markings",
    "arcs",
    "deadlocks",
    "seconds",
    "processor s",
    "M/s",
    "peak MiB",
    "load",
)


def count(net: CompiledNet, engine: str) -> tuple[int | None, int | None, int | None, bool]:
    """Markings, arcs, deadlocks and whether these are all."""
    if engine == "reduced":
        from dineros.analysis.questions.reduced_space import reduced_state_space

        counted = reduced_state_space(net, "symbolic", Budget(MEMORY))
        return counted.states, None, counted.deadlocks, counted.complete
    if engine == "symbolic":
        from dineros.analysis.symbolic.engine import symbolic_state_space

        space = symbolic_state_space(net, Budget(MEMORY))
        return space.markings, space.arcs(), space.deadlocks(), space.complete
    from dineros.analysis.explicit import explore

    if engine == "depth-first":
        seen = explore(net, Budget(MEMORY), order="depth-first")
    else:
        seen = explore(net, Budget(MEMORY), workers=int(engine.removeprefix("explicit-")))
    return seen.markings, seen.arcs, seen.deadlocks, seen.complete


def measure(name: str, engine: str) -> str:
    """One row of the table."""
    net = NETS[name]()
    warm_up(net, engine)
    load = os.getloadavg()[0]
    used, began = resource.getrusage(resource.RUSAGE_SELF), time.perf_counter()
    markings, arcs, deadlocks, complete = count(net, engine)
    seconds = time.perf_counter() - began
    now = resource.getrusage(resource.RUSAGE_SELF)
    processor = now.ru_utime + now.ru_stime - used.ru_utime - used.ru_stime
    rate = f"{Decimal(markings or 0) / Decimal(seconds) / 10**6:.3g}"
    cells = (
        name,
        engine,
        _number(markings),
        _number(arcs),
        _number(deadlocks),
        f"{seconds:.2f}",
        f"{processor:.2f}",
        rate,
        f"{peak_memory() >> 20}",
        f"{load:.1f}",
    )
    return f"| {' | '.join(cells)} |" + ("" if complete else " incomplete")


def warm_up(net: CompiledNet, engine: str) -> None:
    """Load the kernels of an engine; explicit search has kernels for each width of markings."""
    if engine in ("symbolic", "reduced"):
        count(classic.philosophers(3), engine)
        return
    from dineros.analysis.explicit import explore

    order = "depth-first" if engine == "depth-first" else "breadth-first"
    for small in (classic.philosophers(3), replace(net)):  # a copy: what is found out of a net, it keeps
        explore(small, Budget(1 << 24, states=1), order=order)  # type: ignore[arg-type]


def _number(value: int | None) -> str:
    if value is None:
        return ""
    return f"{value:,}" if value < 10**11 else f"{Decimal(value):.3e}"


def machine() -> str:
    """Processor, versions and load."""
    model = platform.processor() or platform.machine()
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
        model = next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        pass
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return (
        f"{model}, {cores} processors, Python {platform.python_version()}, Numba {version('numba')};"
        f" load {', '.join(f'{value:.1f}' for value in os.getloadavg())}"
    )


def main(words: list[str]) -> None:
    """Print the table."""
    rows = [(name, "symbolic") for name in NETS]
    rows += [(name, "reduced") for name in NETS]
    rows += [(name, f"explicit-{workers}") for name in EXPLICIT for workers in (1, 2)]
    rows += [(name, "depth-first") for name in EXPLICIT if name not in LONG]
    rows.sort(key=lambda row: list(NETS).index(row[0]))
    if "--long" not in words:
        rows = [row for row in rows if row[0] not in LONG or not row[1].startswith("explicit")]
    chosen = [word for word in words if word != "--long"]
    print(machine(), end="\n\n")
    print(f"| {' | '.join(COLUMNS)} |\n|{'---|' * len(COLUMNS)}")
    context = multiprocessing.get_context("spawn")
    for name, engine in rows:
        if all(word in f"{name} {engine}" for word in chosen):
            with ProcessPoolExecutor(1, mp_context=context) as pool:
                print(pool.submit(measure, name, engine).result(), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
