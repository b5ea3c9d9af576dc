"""Memory: what is free on this machine or in this container, and what this process has taken."""

from __future__ import annotations

import os
import resource
import sys
from pathlib import Path, PurePosixPath

ROOT = Path("/")
#: Part of the free memory that a search may take unless told otherwise.
DEFAULT_SHARE = 0.7
#: Limits from here on are none: version 1 of control groups writes a number of pages that fills a word.
NO_LIMIT = 1 << 60


def free_memory(root: Path = ROOT) -> int:
    """Bytes that can be had without swapping, in this machine and in every control group around the process.

    Parameters
    ----------
    root
        Where ``proc`` and ``sys`` are mounted.
    """
    free = _labelled(root / "proc/meminfo", "MemAvailable:")
    available = free * 1024 if free is not None else _half_of_all()
    return max(0, min([available, *_free_in_groups(root)]))


def resident_memory() -> int:
    """Bytes of this process that are in memory now."""
    try:
        pages = int(Path("/proc/self/statm").read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        return peak_memory()
    return pages * os.sysconf("SC_PAGE_SIZE")


def peak_memory() -> int:
    """Most bytes of this process that were in memory at a time."""
    # What `getrusage` tells starts from the size of the process that started this one.
    own = _labelled(Path("/proc/self/status"), "VmHWM:")
    if own is not None:
        return own * 1024
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def _half_of_all() -> int:
    return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2


def _free_in_groups(root: Path) -> list[int]:
    """What each control group that limits memory leaves, of version 1 and 2, up to the outermost one."""
    free = []
    mount = root / "sys/fs/cgroup"
    for controllers, path in _groups(root):
        folder = mount if not controllers else mount / "memory"
        limit_name, usage_name, cache_label = (
            ("memory.max", "memory.current", "inactive_file")
            if not controllers
            else ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file")
        )
        # In a container the path may be that of the host, and the mount already the group itself.
        for group in (PurePosixPath(path), *PurePosixPath(path).parents):
            here = folder / str(group).lstrip("/")
            limit = _number(here / limit_name)
            if limit is None or limit >= NO_LIMIT:
                continue
            # Pages of files count as used, and are given up for the asking.
            cache = _labelled(here / "memory.stat", cache_label) or 0
            free.append(limit - max(0, (_number(here / usage_name) or 0) - cache))
    return free


def _groups(root: Path) -> list[tuple[str, str]]:
    """Controllers (none in version 2) and path of the groups of this process that may limit memory."""
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
        return int(path.read_text(encoding="ascii"))
    except (OSError, ValueError):
        return None


def _labelled(path: Path, label: str) -> int | None:
    try:
        for line in path.read_text(encoding="ascii").splitlines():
            words = line.split()
            if len(words) > 1 and words[0] == label:
                return int(words[1])
    except (OSError, ValueError):
        pass
    return None
