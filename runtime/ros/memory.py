"""Shared memory of Fast DDS that was left behind: a process that is killed cannot take its segments down."""

from __future__ import annotations

import contextlib
import time
from pathlib import Path

FOLDER = Path("/dev/shm")
AGE = 5.0
"""Seconds; a younger file may be one that its process is about to map."""


def segments_of(process: int) -> set[Path]:
    """Return the segments of Fast DDS that a process has mapped; empty where it is gone or not ours."""
    with contextlib.suppress(OSError):
        lines = Path(f"/proc/{process}/maps").read_text(encoding="utf-8", errors="replace").splitlines()
        paths = (line.split(maxsplit=5)[-1] for line in lines if "/dev/shm/fastrtps_" in line)
        return {Path(path.removesuffix(" (deleted)")) for path in paths}
    return set()


def remove_abandoned(folder: Path = FOLDER) -> list[Path]:
    """Remove the segments that no process has mapped, and their locks; those of other users stay.

    Returns
    -------
    list of Path
        What was removed.
    """
    candidates = {path for path in folder.glob("fastrtps_*") if _is_old(path)}
    used = set().union(*(segments_of(int(path.name)) for path in Path("/proc").glob("[0-9]*")))
    removed = []
    for path in sorted(candidates):
        owner = path.with_name(path.name.removesuffix("_el").removesuffix("_sl"))
        if owner in used or (owner != path and owner.exists() and owner not in candidates):
            continue
        with contextlib.suppress(OSError):
            path.unlink()
            removed.append(path)
    return removed


def _is_old(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_mtime > AGE
    except OSError:
        return False
