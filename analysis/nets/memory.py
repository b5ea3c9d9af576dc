"""Memory: free memory of the machine, a container and the process, and memory in use."""

from __future__ import annotations

import os
import resource
import signal
import sys
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from dineros.metamodel.errors import BudgetError

ROOT = Path("/")
#: Default share of the free memory for a search.
DEFAULT_SHARE = 0.7
WATCHED_SHARE = 0.9
"""Default share of the free memory for all processes together."""
#: Larger limits mean no limit: version 1 of control groups writes a number of pages that fills a word.
NO_LIMIT = 1 << 60
OWN_MEMORY = 320 << 20
"""Memory of Python, its libraries and the compiled engines before a search, in bytes.

The resident size of the libraries depends on how the system cached their files: 185 to 265 MiB were observed.
"""
ENGINE_MEMORY, ENGINE_ADDRESSES = 96 << 20, 128 << 20
"""Part of it that the compiled engines use when they are loaded, and bytes that they map."""
OWN_ADDRESSES = 400 << 20
"""Bytes of the address space that Python, its libraries and the compiled engines map."""
LEAST_FOR_SEARCH = 1 << 20
"""Minimum memory for a search, in bytes."""
WATCH_SECONDS = 0.05
#: Limits of a process (setrlimit(2)), and the values that count against them (proc(5)).
_PROCESS_LIMITS = ((resource.RLIMIT_AS, "VmSize:"), (resource.RLIMIT_DATA, "VmData:"))


def free_memory(root: Path = ROOT) -> int:
    """Return the free memory without swapping: of the machine, control groups, and limits of the process.

    Parameters
    ----------
    root
        Folder in which ``proc`` and ``sys`` are mounted.
    """
    free = _labelled(root / "proc/meminfo", "MemAvailable:")
    available = free * 1024 if free is not None else _half_of_all()
    return max(0, min([available, *_free_in_groups(root), mappable_memory() - ENGINE_ADDRESSES]))


def mappable_memory() -> int:
    """Return how many bytes this process may still map, touched or not; `NO_LIMIT`: there is no limit.

    Batch systems and ``ulimit -v`` limit the address space (RLIMIT_AS), some the private writable part of it
    (RLIMIT_DATA).
    """
    left = [NO_LIMIT]
    for limit, label in _PROCESS_LIMITS:
        most, _ = resource.getrlimit(limit)
        if most != resource.RLIM_INFINITY:
            mapped = _labelled(Path("/proc/self/status"), label)
            left.append(most - (mapped * 1024 if mapped is not None else resident_memory()))
    return max(0, min(left))


class MemoryBudgetError(BudgetError):
    """A process has used all the memory that it may use."""

    def __init__(self, budget: int) -> None:
        is_limited = mappable_memory() < NO_LIMIT
        more = "allow more with --memory" if not is_limited else "allow more with --memory and 'ulimit'"
        self.limit = f"the process may use {budget >> 20} MiB"
        super().__init__(f"memory ran out: {self.limit}", hint=f"{more}, or make the model smaller")
        self.budget = budget


class TimeBudgetError(BudgetError):
    """A process has used all the time that it may use."""

    def __init__(self, seconds: float) -> None:
        message = f"time ran out after {seconds:.1f} s"
        super().__init__(message, hint="allow more with --timeout, or make the model smaller")


def memory_of_process(given: int | None) -> int:
    """Return the memory for this process and its child processes; by default most of the free memory.

    Raises
    ------
    BudgetError
        The limits of the process leave less than it needs.
    """
    if mappable_memory() < OWN_ADDRESSES:
        raise BudgetError(
            f"the limits of this process leave {mappable_memory() >> 20} MiB to map, "
            f"and the program itself needs {OWN_ADDRESSES >> 20} MiB",
            hint="raise the limit, see 'ulimit -a'",
        )
    return given if given is not None else resident_memory() + int(free_memory() * WATCHED_SHARE)


def memory_for_engines(given: int | None) -> int:
    """Return the memory for an engine: the given memory without that of the process itself.

    Raises
    ------
    MemoryBudgetError
        The model uses all of it.
    """
    if given is None:
        budget, left = resident_memory() + free_memory(), int(free_memory() * DEFAULT_SHARE)
    else:
        budget, left = given, given - max(OWN_MEMORY, resident_memory() + ENGINE_MEMORY)
    left = min(left, mappable_memory() - ENGINE_ADDRESSES)
    if left < LEAST_FOR_SEARCH:
        raise MemoryBudgetError(budget)
    return left


@contextmanager
def watched_memory(budget: int, seconds: float | None = None) -> Iterator[None]:
    """Keep this process within a budget during work that has no budget of its own, such as flattening.

    Parameters
    ----------
    budget : int
        Bytes.

    Resident memory is checked every `WATCH_SECONDS` by a signal (SIGALRM), when Python code runs; engines,
    which run for longer, check their memory themselves. It works only in the main thread, and does nothing in
    others.

    Raises
    ------
    MemoryBudgetError
        More memory is resident than the budget. It can be raised anywhere in the program, like
        KeyboardInterrupt.
    TimeBudgetError
        Time ran out; it can be raised anywhere, too.
    """
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    end = None if seconds is None else time.monotonic() + seconds

    def look(*_: object) -> None:
        if resident_memory() > budget:
            raise MemoryBudgetError(budget)
        if end is not None and time.monotonic() >= end:
            raise TimeBudgetError(seconds or 0.0)

    hook = sys.unraisablehook

    def lost(what: sys.UnraisableHookArgs) -> None:
        # If an exception cannot be raised, for example during garbage collection, the next check raises it.
        if not issubclass(what.exc_type, (MemoryBudgetError, TimeBudgetError)):
            hook(what)

    before = signal.signal(signal.SIGALRM, look)
    sys.unraisablehook = lost
    signal.setitimer(signal.ITIMER_REAL, WATCH_SECONDS, WATCH_SECONDS)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
        sys.unraisablehook = hook


def resident_memory() -> int:
    """Resident memory of this process, in bytes."""
    try:
        # Bytes: this may run in a signal handler, during the first import of a text encoding.
        pages = int(Path("/proc/self/statm").read_bytes().split()[1])
    except (OSError, ValueError, IndexError):
        return peak_memory()
    return pages * os.sysconf("SC_PAGE_SIZE")


def peak_memory() -> int:
    """Peak resident memory of this process, in bytes."""
    # `getrusage` starts from the size of the parent process.
    own = _labelled(Path("/proc/self/status"), "VmHWM:")
    if own is not None:
        return own * 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def _half_of_all() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2


def _free_in_groups(root: Path) -> list[int]:
    """Return the free memory in each control group with a limit, of versions 1 and 2, up to the outermost."""
    free = []
    mount = root / "sys/fs/cgroup"
    for controllers, path in _groups(root):
        folder = mount if not controllers else mount / "memory"
        limit_name, usage_name, cache_label = (
            ("memory.max", "memory.current", "inactive_file")
            if not controllers
            else ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        )
        # In a container, the path may be that of the host, and the mount the group itself.
        for group in (PurePosixPath(path), *PurePosixPath(path).parents):
            here = folder / str(group).lstrip("/")
            limit = _number(here / limit_name)
            if limit is None or limit >= NO_LIMIT:
                continue
            # Cached pages of files count as used, but are released on demand.
            cache = _labelled(here / "memory.stat", cache_label) or 0
            free.append(limit - max(0, (_number(here / usage_name) or 0) - cache))
    return free


def _groups(root: Path) -> list[tuple[str, str]]:
    """Return controllers (none in version 2) and paths of this process's groups that may limit memory."""
    try:
        lines = (root / "proc/self/cgroup").read_text(encoding="utf-8").splitlines()
    except OSError:
        return []
    parts = [line.split(":", 2) for line in lines]
    return [
        (part[1], part[2])
        for part in parts
        if len(part) == 3 and (not part[1] or "memory" in part[1].split(","))
    ]


def _number(path: Path) -> int | None:
    try:
        return int(path.read_bytes())
    except (OSError, ValueError):
        return None


def _labelled(path: Path, label: str) -> int | None:
    try:
        for line in path.read_bytes().splitlines():
            words = line.split()
            if len(words) > 1 and words[0] == label.encode():
                return int(words[1])
    except (OSError, ValueError):
        pass
    return None
