"""Free memory of a machine and of containers, and budgets measured by the peak of a process."""

from __future__ import annotations

import json
import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from dineros.analysis.nets.memory import (
    ENGINE_ADDRESSES,
    NO_LIMIT,
    WATCH_SECONDS,
    MemoryBudgetError,
    free_memory,
    mappable_memory,
    peak_memory,
    resident_memory,
    watched_memory,
)

MIB = 1 << 20
FILES = {
    "machine": {"proc/meminfo": "MemTotal: 9000000 kB\nMemAvailable: 8000000 kB\n"},
    "version 2": {
        "proc/self/cgroup": "0::/jobs/mine\n",
        "sys/fs/cgroup/jobs/mine/memory.max": "max\n",
        "sys/fs/cgroup/jobs/memory.max": f"{900 * MIB}\n",
        "sys/fs/cgroup/jobs/memory.current": f"{500 * MIB}\n",
        "sys/fs/cgroup/jobs/memory.stat": f"anon {200 * MIB}\ninactive_file {300 * MIB}\n",
    },
    "version 2 in a container": {
        "proc/self/cgroup": "0::/\n",
        "sys/fs/cgroup/memory.max": f"{900 * MIB}\n",
        "sys/fs/cgroup/memory.current": f"{200 * MIB}\n",
    },
    "version 1": {
        "proc/self/cgroup": "5:cpu,cpuacct:/\n4:memory:/jobs/mine\n0::/\n",
        "sys/fs/cgroup/memory/jobs/mine/memory.limit_in_bytes": f"{900 * MIB}\n",
        "sys/fs/cgroup/memory/jobs/mine/memory.usage_in_bytes": f"{200 * MIB}\n",
        "sys/fs/cgroup/memory/memory.limit_in_bytes": "9223372036854771712\n",
    },
    "version 1 in a container": {
        "proc/self/cgroup": "4:memory:/docker/of/the/host\n",
        "sys/fs/cgroup/memory/memory.limit_in_bytes": f"{900 * MIB}\n",
        "sys/fs/cgroup/memory/memory.usage_in_bytes": f"{300 * MIB}\n",
        "sys/fs/cgroup/memory/memory.stat": f"total_inactive_file {100 * MIB}\n",
    },
}


def mount(root: Path, *kinds: str) -> Path:
    for kind in kinds:
        for name, text in FILES[kind].items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="ascii")
    return root


def test_a_machine_without_groups(tmp_path: Path) -> None:
    assert free_memory(mount(tmp_path, "machine")) == 8_000_000 * 1024


@pytest.mark.parametrize("kind", [kind for kind in FILES if kind != "machine"])
def test_groups_limit_what_is_free(tmp_path: Path, kind: str) -> None:
    assert free_memory(mount(tmp_path, "machine", kind)) == 700 * MIB


def test_a_full_group_leaves_nothing(tmp_path: Path) -> None:
    root = mount(tmp_path, "machine", "version 2 in a container")
    (root / "sys/fs/cgroup/memory.current").write_text(f"{950 * MIB}\n", encoding="ascii")
    assert free_memory(root) == 0


def test_without_any_of_these_files_half_of_all_is_taken_for_free(tmp_path: Path) -> None:
    total = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE")
    assert free_memory(tmp_path) == total // 2


@pytest.mark.parametrize("limit", ["RLIMIT_AS", "RLIMIT_DATA"])
def test_limits_of_the_process_limit_what_is_free(limit: str) -> None:
    program = """
import json, resource, sys
from dineros.analysis.nets.memory import free_memory, mappable_memory
before = mappable_memory()
resource.setrlimit(getattr(resource, sys.argv[1]), (512 << 20, 512 << 20))
print(json.dumps([before, mappable_memory(), free_memory()]))
"""
    answer = subprocess.run(
        [sys.executable, "-c", program, limit], capture_output=True, text=True, check=True
    )
    before, mappable, free = json.loads(answer.stdout)
    assert before == NO_LIMIT == mappable_memory()
    assert 300 * MIB < mappable < 512 * MIB
    assert abs(free - (mappable - ENGINE_ADDRESSES)) < MIB


def test_a_watch_ends_what_takes_more() -> None:
    """In a process of its own: one that has freed much takes that again before it grows."""
    program = """
import json, os
from dineros.analysis.nets.memory import MemoryBudgetError, resident_memory, watched_memory
budget = resident_memory() + (64 << 20)
taken = []
try:
    with watched_memory(budget):
        for _ in range(10_000):
            taken.append(bytearray(os.urandom(1 << 20)))
except MemoryBudgetError as error:
    print(json.dumps([str(error), budget >> 20, len(taken)]))
"""
    answer = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    said, budget, taken = json.loads(answer.stdout)
    assert f"the process may use {budget} MiB" in said
    assert 32 < taken < 512  # how much is taken between two looks hangs on the machine


def test_a_watch_that_cannot_raise_says_nothing_and_looks_again(capfd: pytest.CaptureFixture[str]) -> None:
    """While an object is thrown away errors are lost, with a stack trace; the next look raises it."""
    before = sys.unraisablehook

    class Slow:
        def __del__(self) -> None:
            time.sleep(4 * WATCH_SECONDS)

    def throw_away() -> None:
        Slow()
        for _ in range(1_000):
            time.sleep(WATCH_SECONDS / 10)

    with pytest.raises(MemoryBudgetError), watched_memory(1):
        throw_away()
    assert capfd.readouterr().err == ""
    assert sys.unraisablehook is before


def test_a_watch_is_over_when_it_ends() -> None:
    handler, timer = signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)
    with watched_memory(NO_LIMIT):
        assert signal.getitimer(signal.ITIMER_REAL)[1] > 0
    assert (signal.getsignal(signal.SIGALRM), signal.getitimer(signal.ITIMER_REAL)) == (handler, timer)


def test_memory_of_this_process() -> None:
    assert 10 * MIB < resident_memory() <= peak_memory() + MIB
    assert peak_memory() <= resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 + MIB


PROGRAM = """
import json, sys
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.explicit import Budget, explore
from dineros.analysis.nets.memory import peak_memory
order, workers, budget = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
names = "abcdefgh"
def chain(tokens):
    moves = [(f"t{i}", {names[i]: 1}, {names[i + 1]: 1}) for i in range(7)]
    return CompiledNet.build(dict.fromkeys(names, 0) | {"a": tokens}, moves)
explore(chain(10), Budget(budget), order=order, workers=workers)  # tables grow: all is compiled
before = peak_memory()
space = explore(chain(60), Budget(budget), order=order, workers=workers)
print(json.dumps([space.reason, space.markings, before, peak_memory()]))
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("order", "workers", "budget"),
    [("breadth-first", 1, 24 * MIB), ("breadth-first", 2, 100 * MIB), ("depth-first", 1, 24 * MIB)],
)
def test_the_budget_of_a_search_holds(order: str, workers: int, budget: int) -> None:
    """The net has 869 648 208 markings; the peak is that of a process of its own."""
    arguments = [sys.executable, "-c", PROGRAM, order, str(workers), str(budget)]
    answer = subprocess.run(arguments, capture_output=True, text=True, check=True, timeout=300)
    reason, markings, before, after = json.loads(answer.stdout)
    assert reason == "memory"
    assert markings * 8 > budget // 8
    assert after - before < budget + 4 * MIB
    assert after - before > budget // 4
