"""Which files in shared memory belong to which processes, as the Linux kernel tells in /proc."""

from __future__ import annotations

import contextlib
import re
import time
from pathlib import Path

FOLDER = Path("/dev/shm")

File = tuple[str, int]
"""Name and inode: a name that is given again is another file."""


def listing() -> set[File]:
    """Return all files in shared memory."""
    found = set()
    for path in FOLDER.iterdir():
        with contextlib.suppress(FileNotFoundError):
            found.add((path.name, path.stat().st_ino))
    return found


def used_by(process: int | str) -> set[File]:
    """Return the files that a process has mapped or open; none where it is gone or not ours to look into."""
    found = set()
    with contextlib.suppress(OSError):
        for line in Path(f"/proc/{process}/maps").read_text(errors="replace").splitlines():
            fields = line.split(maxsplit=5)
            if fields[-1].startswith(f"{FOLDER}/"):
                found.add((fields[-1].removeprefix(f"{FOLDER}/"), int(fields[4])))
        for link in Path(f"/proc/{process}/fd").iterdir():
            with contextlib.suppress(FileNotFoundError):
                target = link.readlink()
                if target.parent == FOLDER:
                    found.add((target.name, link.stat().st_ino))
    return found & listing()


def used_by_anybody() -> set[File]:
    """Return the files that some living process has mapped or open."""
    return set().union(*(used_by(path.name) for path in Path("/proc").glob("[0-9]*")))


class Belongings:
    """The files of the processes of one test, among those of all other processes of the machine.

    Other ROS processes come and go at the same time, so that a file which is new is not ours for that. Ours
    is what one of our processes was seen to have open, told by name and inode, what guards it, and all ports
    of our domain, which nobody shares with us. Ports below 7400 are shared out among all domains of the
    machine, so that their names say nothing.

    Parameters
    ----------
    domain : int
        The ROS domain of the test.
    """

    def __init__(self, domain: int) -> None:
        first = 7400 + 250 * domain  # of RTPS, section 9.6.1.1
        self._ports = range(first, first + 250)
        self._seen: set[File] = set()

    @property
    def names(self) -> set[str]:
        """Names of the files that our processes were seen to have."""
        return {name for name, _ in self._seen}

    def look(self, *processes: int) -> None:
        """Note what our processes have now."""
        used = set().union(*(used_by(process) for process in processes))
        names = {name for name, _ in used}
        self._seen |= used | {file for file in listing() if _guarded(file[0]) in names}

    def left(self) -> set[str]:
        """Return which of our files are still there, without those that a living process uses.

        A process of another domain that starts may have a port of the shared numbers in its hands just now:
        for those, and for no other file, this waits a little.
        """
        end = time.monotonic() + 3
        while True:
            found = self._unused()
            if not found or any(map(self._is_ours_alone, found)) or time.monotonic() > end:
                return found
            time.sleep(0.05)

    def _unused(self) -> set[str]:
        living = used_by_anybody()
        busy = {name for name, _ in living}
        return {
            file[0]
            for file in listing()
            if (file in self._seen or self._is_port(file[0]))
            and file not in living
            and _guarded(file[0]) not in busy
        }

    def _is_ours_alone(self, name: str) -> bool:
        return self._is_port(name) or re.match(r"fastrtps_[0-9a-f]{16}", name) is not None

    def _is_port(self, name: str) -> bool:
        number = re.search(r"_port(\d+)", name)
        return number is not None and int(number[1]) in self._ports


def _guarded(name: str) -> str | None:
    """Return the name of what a lock or a semaphore guards."""
    match = re.fullmatch(r"(?:sem\.(.+)_mutex|(.+)_[es]l)", name)
    return match and (match[1] or match[2])
