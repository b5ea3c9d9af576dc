"""Sweep of the case study over 0..4 objects per colour and all variants, here and on a Dask cluster.

The cluster has worker processes on this machine, one of which is killed on the way; its table must be that of
the local run. Run it again with the same folder when it was interrupted.

Usage: ``python -m benchmarks.analysis.sweep_case_study [--most 4] [--overflow all] [--workers N]
[--folder DIR]``.
"""

from __future__ import annotations

import argparse
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

from case_study.build import build
from dineros.analysis.sweeps import Axis, Grid, Outcome, Progress, sweep

SIGNALS = ("none", "input-enabled", "io-enabled", "fully-enabled")
MEASURED = ("seconds", "peak_memory_bytes")
COLORS = ("Red", "Blue", "Green")


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--most", type=int, default=4, help="objects per colour")
    parser.add_argument("--overflow", choices=["weighted", "inhibitor", "all"], default="all")
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--folder", type=Path, default=Path("build/sweep"))
    options = parser.parse_args()
    options.folder.mkdir(parents=True, exist_ok=True)
    axes = tuple(Axis.parse(f"{color}Objects.tokens=0..{options.most}") for color in COLORS)
    overflow = ("weighted", "inhibitor") if options.overflow == "all" else (options.overflow,)
    grid = Grid(axes, SIGNALS, overflow)
    local = timed(
        "local", lambda: sweep(build(), grid, options.folder / "local.csv", workers=options.workers)
    )
    cluster = timed(
        f"cluster of {options.workers}", lambda: on_cluster(grid, options.folder, options.workers)
    )
    same = rows(local) == rows(cluster)
    print(f"the tables are {'equal' if same else 'DIFFERENT'}")
    return 0 if same and not local.unknown else 1


def timed(name: str, run: Callable[[], Outcome]) -> Outcome:
    began = time.perf_counter()
    outcome = run()
    wall = time.perf_counter() - began
    seconds = [row["seconds"] for row in outcome.rows if isinstance(row["seconds"], float)]
    memory = [row["peak_memory_bytes"] for row in outcome.rows if isinstance(row["peak_memory_bytes"], int)]
    states = [row["states"] for row in outcome.rows if isinstance(row["states"], int)]
    print(
        f"{name}: {len(outcome.rows)} points ({outcome.resumed} of before, {outcome.unknown} unknown) "
        f"in {wall:.0f} s; a point takes {sum(seconds) / len(seconds):.2f} s, at most {max(seconds):.1f} s "
        f"and {max(memory) / 2**20:.0f} MiB; {max(states):.2e} states at most",
        flush=True,
    )
    return outcome


def on_cluster(grid: Grid, folder: Path, workers: int) -> Outcome:
    """Sweep on a cluster, and kill a worker when a third is done."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as cluster:
        victims = [worker.pid for worker in cluster.workers.values()]

        def kill_one(progress: Progress) -> None:
            if victims and progress.done - progress.resumed >= (progress.points - progress.resumed) // 3:
                print(f"killing a worker at {progress.done} of {progress.points} points", flush=True)
                os.kill(victims[0], signal.SIGKILL)
                victims.clear()

        return sweep(
            build(), grid, folder / "cluster.csv", scheduler=cluster.scheduler_address, progress=kill_one
        )


def rows(outcome: Outcome) -> list[dict[str, object]]:
    """Return what does not depend on the machine."""
    return [{name: row[name] for name in row if name not in MEASURED} for row in outcome.rows]


if __name__ == "__main__":
    sys.exit(main())
