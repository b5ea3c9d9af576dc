"""Process trees: their memory, and how to end them (Linux, proc(5))."""

from __future__ import annotations

import ctypes
import os
import signal
import time
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import subprocess

PROCESSES = Path("/proc")
LOOK_SECONDS = 0.25
"""Seconds between searches for new processes of a tree; memory is read at each call."""

_SET_PARENT_DEATH_SIGNAL = 1  # PR_SET_PDEATHSIG of prctl(2)


def die_with(parent: int) -> None:
    """Have the kernel end this process when the thread that started it ends for any reason (Linux)."""
    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, int(signal.SIGKILL), 0, 0, 0)
    if os.getppid() != parent:  # the parent ended before
        os._exit(1)


def end_group(process: subprocess.Popen[Any]) -> None:
    """End a program that leads a process group, and the processes of the group, if any still runs."""
    with suppress(ProcessLookupError, PermissionError):
        os.killpg(process.pid, signal.SIGKILL)
    process.wait()
    for stream in (process.stdout, process.stderr):
        if stream is not None:
            stream.close()


class ProcessTree:
    """A process with all its descendants."""

    def __init__(self, root: int) -> None:
        self.root = root
        self._known = [root]
        self._looked = 0.0

    def memory(self, most: int) -> int:
        """Return resident bytes; shared pages are counted exactly only if the cheap sum exceeds the limit.

        `most`: the limit. Pages are counted one by one only if the sum with shared pages counted several
        times exceeds it, and there are more than two processes: of two, the small one waits for the other.
        """
        if time.monotonic() - self._looked > LOOK_SECONDS:
            self._look()
        taken = sum(_resident(process) for process in self._known)
        if taken <= most or len(self._known) == 1:
            return taken
        return sum(_share(process) for process in self._known)

    def end(self) -> None:
        """End all processes at once; the caller waits for the root."""
        with suppress(ProcessLookupError):
            os.kill(self.root, signal.SIGSTOP)  # so that it starts no further processes
        self._look(is_exact=True)
        for process in reversed(self._known):
            with suppress(ProcessLookupError):
                os.kill(process, signal.SIGKILL)

    def _look(self, is_exact: bool = False) -> None:
        self._looked = time.monotonic()
        self._known = [self.root]
        # The kernel's own lists are cheap to read, but may miss a process while others end.
        all_children = _all_children() if is_exact or not _lists_children(self.root) else None
        for process in self._known:  # the list grows meanwhile
            more = _children(process) if all_children is None else all_children.get(process, ())
            self._known += more


def _lists_children(process: int) -> bool:
    return (PROCESSES / f"{process}/task/{process}/children").is_file()


def _children(process: int) -> list[int]:
    found: list[int] = []
    with suppress(OSError, ValueError):
        for thread in (PROCESSES / f"{process}/task").iterdir():
            found += map(int, (thread / "children").read_bytes().split())
    return found


def _all_children() -> dict[int, list[int]]:
    found: dict[int, list[int]] = {}
    for folder in PROCESSES.iterdir() if PROCESSES.is_dir() else ():
        if folder.name.isdigit():
            with suppress(OSError, ValueError, IndexError):
                # The name of a program, in brackets, may contain any characters.
                words = (folder / "stat").read_bytes().rpartition(b")")[2].split()
                found.setdefault(int(words[1]), []).append(int(folder.name))
    return found


def _resident(process: int) -> int:
    with suppress(OSError, ValueError, IndexError):
        return int((PROCESSES / str(process) / "statm").read_bytes().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    return 0


def _share(process: int) -> int:
    """Return the resident bytes of a process, with its share of shared pages (smaps_rollup of proc(5))."""
    with suppress(OSError, ValueError, IndexError):
        for line in (PROCESSES / str(process) / "smaps_rollup").read_bytes().splitlines():
            if line.startswith(b"Pss:"):
                return int(line.split()[1]) * 1024
    return _resident(process)


def running_seconds() -> float:
    """Return the seconds since this process was started."""
    with suppress(OSError, ValueError, IndexError, AttributeError):
        words = (PROCESSES / "self/stat").read_bytes().rpartition(b")")[2].split()
        return time.clock_gettime(time.CLOCK_BOOTTIME) - int(words[19]) / os.sysconf("SC_CLK_TCK")
    return time.process_time()
