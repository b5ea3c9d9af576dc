"""Explicit engine: markings a second on the case study and classic nets, by one worker and by all.

Run with ``python -m benchmarks.explicit [NAME...]``. The first search of each width compiles kernels
and is not shown; figures name the load of the machine, without which they mean little.
"""

from __future__ import annotations

import os
import sys

from dineros.analysis.compiled import CompiledNet
from dineros.analysis.explicit import ExplicitStateSpace, explore
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import SIGNAL_VARIANTS, reference_case_study


def instances() -> dict[str, CompiledNet]:
    nets = {
        "kanban-5": classic.kanban(5),
        "fms-5": classic.flexible_manufacturing(5),
        "philosophers-12": classic.philosophers(12),
        "mutex-14": classic.round_robin_mutex(14),
        "swimming-pool-2": classic.swimming_pool(2),
    }
    for signals in SIGNAL_VARIANTS:
        nets[f"case-study-110-{signals}"] = reference_case_study((1, 1, 0), signals)
    nets["case-study-111-none"] = reference_case_study((1, 1, 1), "none")
    nets["case-study-111-input"] = reference_case_study((1, 1, 1), "input")
    return nets


def line(name: str, workers: int, space: ExplicitStateSpace) -> str:
    return (
        f"{name:22} {workers} {space.markings:>10} {space.arcs:>11} {space.seconds:7.2f} s"
        f" {space.rate / 1e6:6.2f} M/s {space.memory / space.markings:6.1f} B/marking"
        f" load {os.getloadavg()[0]:.1f}{'' if space.complete else ' ' + str(space.reason)}"
    )


def main(names: list[str]) -> None:
    for name, net in instances().items():
        if names and name not in names:
            continue
        for workers in sorted({1, len(os.sched_getaffinity(0))}):
            explore(net, workers=workers, states=1)
            print(line(name, workers, explore(net, workers=workers)), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
