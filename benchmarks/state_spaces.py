"""Every engine on every net: a table of markings, times and memory.

Each row runs in a process of its own, so that peak memory is its own.
Usage: ``python -m benchmarks.state_spaces [words to choose rows by]``.
"""

from __future__ import annotations

import multiprocessing
import resource
import sys
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial

from dineros.analysis.compiled import CompiledNet
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import SIGNAL_VARIANTS, reference_case_study

NETS: dict[str, Callable[[], CompiledNet]] = {
    "philosophers-10": lambda: classic.philosophers(10),
    "philosophers-20": lambda: classic.philosophers(20),
    "kanban-5": lambda: classic.kanban(5),
    "fms-5": lambda: classic.flexible_manufacturing(5),
    "round-robin-10": lambda: classic.round_robin_mutex(10),
    "swimming-pool-1": lambda: classic.swimming_pool(1),
}
EXPLICIT = [name for name in NETS if name != "philosophers-20"]
for _variant in SIGNAL_VARIANTS:
    for _n in (1, 3, 5, 10):
        NETS[f"case-study-{_variant}-{_n}"] = partial(reference_case_study, (_n, _n, _n), _variant)
EXPLICIT += ["case-study-none-1", "case-study-input-1"]
HEADER = f"{'net':24}{'engine':12}" + "".join(
    f"{title:>{width}}"
    for title, width in (
        ("markings", 12),
        ("arcs", 12),
        ("deadlocks", 10),
        ("seconds", 9),
        ("M/s", 9),
        ("MiB", 6),
    )
)


def measure(name: str, engine: str) -> str:
    """One row of the table; kernels are loaded before the clock starts."""
    net = NETS[name]()
    warm = classic.philosophers(3)
    if engine == "symbolic":
        from dineros.analysis.symbolic import symbolic_state_space

        symbolic_state_space(warm).deadlocks()
        symbolic_state_space(warm).arcs()
        began = time.perf_counter()
        space = symbolic_state_space(net)
        counts = (space.markings, space.arcs(), space.deadlocks())
        complete = space.complete
    else:
        from dineros.analysis.explicit import explore

        workers = int(engine.removeprefix("explicit-"))
        explore(warm, workers=workers)
        began = time.perf_counter()
        seen = explore(net, workers=workers, memory=4 << 30)
        counts, complete = (seen.markings, seen.arcs, seen.deadlocks), seen.complete
    seconds = time.perf_counter() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss >> 10
    rate = counts[0] / seconds / 1e6
    shown = [f"{value:12d}" if value < 10**11 else f"{value:12.4g}" for value in counts[:2]]
    row = f"{name:24}{engine:12}{''.join(shown)}{counts[2]!s:>10}{seconds:9.2f}{rate:9.2g}{peak:6d}"
    return row if complete else row + " incomplete"


def main(words: list[str]) -> None:
    """Print the table."""
    print(HEADER)
    rows = [(name, "symbolic") for name in NETS]
    rows += [(name, f"explicit-{workers}") for name in EXPLICIT for workers in (1, 2)]
    context = multiprocessing.get_context("spawn")
    for name, engine in rows:
        if all(word in f"{name} {engine}" for word in words):
            with ProcessPoolExecutor(1, mp_context=context) as pool:
                print(pool.submit(measure, name, engine).result(), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
