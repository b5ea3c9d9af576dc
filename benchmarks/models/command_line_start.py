"""How long commands with a small question take in a new process: medians of 20 runs, each with its limit.

``dineros --help`` is measured by the clock, at most 0.3 s; ``check`` and ``statespace`` of the case study by
the time of the processor of all their processes, at most 0.6 s.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

HELP_LIMIT = 0.3
QUESTION_LIMIT = 0.6
RUNS = 20
DINEROS = [sys.executable, "-P", "-m", "dineros.cli.main"]
CASE_STUDY = Path(__file__).parents[2] / "case_study/sorting.sym.xmi"


def processor_seconds_of_children() -> float:
    """Return what the processes have used that this one has waited for, and those they have waited for."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def is_within(limit: float, clock: Callable[[], float], unit: str, *arguments: str) -> bool:
    """Run a command several times, and print its times; return whether their median is within a limit."""
    command = [*DINEROS, *arguments]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # compiles what was not compiled yet
    times = []
    for _ in range(RUNS):
        start = clock()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        times.append(clock() - start)
    median = statistics.median(times)
    name = " ".join(["dineros", *(Path(each).name for each in arguments)])
    print(f"{name}: median {median:.3f} s {unit}, least {min(times):.3f} s of {RUNS}; limit {limit} s")
    return median <= limit


def main() -> None:
    """Measure, print, and fail where a limit is exceeded."""
    within = [is_within(HELP_LIMIT, time.perf_counter, "by the clock", "--help")]
    for command in ("check", "statespace"):
        clock = processor_seconds_of_children
        within.append(is_within(QUESTION_LIMIT, clock, "of the processor", command, str(CASE_STUDY)))
    sys.exit(not all(within))


if __name__ == "__main__":
    main()
