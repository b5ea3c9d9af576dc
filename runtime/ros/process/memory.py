"""Removes files in shared memory that ROS processes leave behind.

Fast DDS keeps a segment for each participant (``fastrtps_0123456789abcdef``), one for each port
(``fastrtps_port7410``), a lock file for each of both (``_el``, ``_sl``), and a semaphore for each port
(``sem.fastrtps_port7410_mutex``). A killed process leaves all of them. Processes that end at the same time
may leave ports and semaphores, because each assumes that another one owns them. ROS also loads LTTng, which
leaves two files.

``fastdds shm clean`` tests the locks. It misses ports that are only written to, and may remove files that a
process is about to open. This module asks the kernel whether any process has a file open or mapped, of any
user and in any container: the kernel grants a write lease (fcntl(2), "Leases") only if there is none, and
delays processes that open the file meanwhile.
"""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import signal
import time
from collections.abc import Iterator
from pathlib import Path

FOLDER = Path("/dev/shm")
PATIENCE = 5.0
"""Seconds to wait for another process that removes files."""

_ASIDE = ".unused"
_SEGMENT = re.compile(r"fast(rtps|dds)_[0-9a-f]{16}")
_FILE = re.compile(
    rf"(?:sem\.)?(?P<owner>{_SEGMENT.pattern}|fast(rtps|dds)_port\d+|lttng-ust-wait-\d+(-\d+)?)"
    rf"(?:_el|_sl|_mutex)?(?P<aside>{re.escape(_ASIDE)})?"
)


def remove_abandoned(folder: Path = FOLDER) -> list[Path]:
    """Remove the files of Fast DDS and LTTng that no living process needs; files of other users are kept.

    A port is removed if no process has it open, then its locks and its semaphore, which store its state. A
    segment is removed if no process has its lock open; its owner has it open while it lives. Peers that have
    the segment mapped can still use it, and Fast DDS itself removes it after five seconds.

    Returns
    -------
    list of Path
        The removed files.
    """
    removed: list[Path] = []
    with contextlib.suppress(OSError), _one_at_a_time(folder):
        groups: dict[str, list[Path]] = {}
        for file in sorted(folder.iterdir()):  # a lock or semaphore sorts after its file
            if match := _FILE.fullmatch(file.name):
                groups.setdefault(file.name if match["aside"] else match["owner"], []).append(file)
        for owner, files in groups.items():
            removed += _remove_segment(files) if _SEGMENT.fullmatch(owner) else _remove_port(files)
    return removed


def _remove_segment(files: list[Path]) -> list[Path]:
    """Remove the lock of a segment, then the segment; nothing if its owner lives."""
    if not _remove_unused(files[-1]):
        return []
    for file in files[:-1]:
        file.unlink(missing_ok=True)
    return files


def _remove_port(files: list[Path]) -> list[Path]:
    """Remove a port, then its locks and semaphore; nothing if it is in use."""
    removed = []
    for file in files:
        if _remove_unused(file):
            removed.append(file)
        elif file.exists():
            break
    return removed


@contextlib.contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Prevent other processes from doing the same: they would count as users of the files."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_DIRECTORY)
    try:
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            with contextlib.suppress(BlockingIOError):
                fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            time.sleep(0.001)
        yield
    finally:
        os.close(descriptor)


def _remove_unused(path: Path) -> bool:
    """Remove a file if no process has it open; return whether it was removed."""
    aside = path.with_name(path.name.removesuffix(_ASIDE) + _ASIDE)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        if os.fstat(descriptor).st_uid != os.geteuid():
            return False
        # A process that opens the file from now on waits, and we get a signal; the default one would end
        # us.
        fcntl.fcntl(descriptor, fcntl.F_SETSIG, signal.SIGURG)
        fcntl.fcntl(descriptor, fcntl.F_SETLEASE, fcntl.F_WRLCK)
        # No process opens the file under the other name; if one opened it just before, the name is restored.
        path.rename(aside)
        is_unused = fcntl.fcntl(descriptor, fcntl.F_GETLEASE) == fcntl.F_WRLCK
        if not is_unused:
            with contextlib.suppress(FileExistsError):
                path.hardlink_to(aside)
        aside.unlink()
    except OSError:  # a process has it open, or the system has no leases
        return False
    finally:
        os.close(descriptor)
    return is_unused
