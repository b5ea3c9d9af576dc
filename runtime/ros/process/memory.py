"""Files in shared memory that ROS processes leave behind, and how they are taken down.

Fast DDS keeps a segment for each participant (``fastrtps_0123456789abcdef``), one for each port
(``fastrtps_port7410``), a lock file beside either (``_el``, ``_sl``), and a semaphore for each port
(``sem.fastrtps_port7410_mutex``). A process that is killed leaves all of them; processes that end together
may leave ports and semaphores, because each takes another for their owner. ROS also loads LTTng, whose two
files stay forever.

``fastdds shm clean`` tries the locks. It misses ports that are only written to, and removes what a process
is just about to open. Here the kernel tells whether anybody has a file open or mapped, whoever it is and in
whichever container: it grants a write lease (fcntl(2), "Leases") only where nobody has, and lets those wait
that open the file meanwhile.
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
"""Seconds to wait for another process that does the same."""

_ASIDE = ".unused"
_SEGMENT = re.compile(r"fast(rtps|dds)_[0-9a-f]{16}")
_FILE = re.compile(
    rf"(?:sem\.)?(?P<owner>{_SEGMENT.pattern}|fast(rtps|dds)_port\d+|lttng-ust-wait-\d+(-\d+)?)"
    rf"(?:_el|_sl|_mutex)?(?P<aside>{re.escape(_ASIDE)})?"
)


def remove_abandoned(folder: Path = FOLDER) -> list[Path]:
    """Remove the files of Fast DDS and LTTng that no living process needs; those of other users stay.

    A port goes when nobody has it open, then its locks and its semaphore, which say in which state it is. A
    segment goes when nobody has its lock open, as its owner has while it lives; peers that have it mapped
    keep it, and Fast DDS itself removes it after five seconds.

    Returns
    -------
    list of Path
        What was removed.
    """
    removed: list[Path] = []
    with contextlib.suppress(OSError), _one_at_a_time(folder):
        groups: dict[str, list[Path]] = {}
        for file in sorted(folder.iterdir()):  # locks and semaphores come after what they guard
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
    """Remove a port, then what guards it; nothing if it is in use."""
    removed = []
    for file in files:
        if _remove_unused(file):
            removed.append(file)
        elif file.exists():
            break
    return removed


@contextlib.contextmanager
def _one_at_a_time(folder: Path) -> Iterator[None]:
    """Keep others from doing the same: they would take each other for users of the files."""
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
    """Remove a file if nobody has it open; return whether it was removed."""
    aside = path.with_name(path.name.removesuffix(_ASIDE) + _ASIDE)
    try:
        descriptor = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    except OSError:
        return False
    try:
        if os.fstat(descriptor).st_uid != os.geteuid():
            return False
        # Who opens the file from now on waits, and we are told: by default with a signal that ends us.
        fcntl.fcntl(descriptor, fcntl.F_SETSIG, signal.SIGURG)
        fcntl.fcntl(descriptor, fcntl.F_SETLEASE, fcntl.F_WRLCK)
        # Nobody comes any more under the other name; one who came just before gets the file back.
        path.rename(aside)
        is_unused = fcntl.fcntl(descriptor, fcntl.F_GETLEASE) == fcntl.F_WRLCK
        if not is_unused:
            with contextlib.suppress(FileExistsError):
                path.hardlink_to(aside)
        aside.unlink()
    except OSError:  # somebody has it open, or the system knows no leases
        return False
    finally:
        os.close(descriptor)
    return is_unused
