"""How long ``dineros --help`` takes in a new process: the median of 20 runs, at most 0.3 s."""

from __future__ import annotations

import statistics
import subprocess
import sys
import time

LIMIT = 0.3
RUNS = 20


def main() -> None:
    """Measure, print, and fail where the limit is exceeded."""
    command = [sys.executable, "-P", "-m", "dineros.cli.main", "--help"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)  # compiles what was not compiled yet
    times = []
    for _ in range(RUNS):
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - start)
    median = statistics.median(times)
    print(f"dineros --help: median {median:.3f} s, slowest {max(times):.3f} s of {RUNS}; limit {LIMIT} s")
    sys.exit(median > LIMIT)


if __name__ == "__main__":
    main()
