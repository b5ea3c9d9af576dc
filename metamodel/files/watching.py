"""Waiting until files change in a folder, instead of looking again and again.

Linux reports changes by a descriptor that can be waited for with others (inotify(7)). It does not report what
other machines write into a shared folder, and other systems have other means. So the caller also looks at the
files every `FolderWatch.longest` seconds.
"""

from __future__ import annotations

import contextlib
import ctypes
import os
import select
import sys
from collections.abc import Iterable
from pathlib import Path

LONGEST = 1.0
"""Seconds between two checks if the system reports changes."""

LONGEST_BLIND = 0.15
"""Seconds between two checks if the system does not report changes, or the folder does not exist yet."""

# Of sys/inotify.h.
_MODIFY, _MOVED_TO, _CREATE, _ONLY_FOLDERS = 0x2, 0x80, 0x100, 0x01000000


class FolderWatch:
    """Reports when files in a folder are made, written or renamed; to be closed, or used in a ``with`` block.

    Parameters
    ----------
    folder : Path
        The folder itself, without those in it; it may come later.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._descriptor = -1
        self._try_to_watch()

    def _try_to_watch(self) -> None:
        if sys.platform != "linux":
            return
        library = ctypes.CDLL(None)
        descriptor = library.inotify_init1(os.O_NONBLOCK | os.O_CLOEXEC)
        if descriptor < 0:  # the user has too many
            return
        mask = _MODIFY | _MOVED_TO | _CREATE | _ONLY_FOLDERS
        if library.inotify_add_watch(descriptor, os.fsencode(self._folder), mask) < 0:
            os.close(descriptor)
        else:
            self._descriptor = descriptor

    @property
    def descriptors(self) -> list[int]:
        """Becomes readable after a change since the last `forget`; empty if changes are not reported."""
        return [] if self._descriptor < 0 else [self._descriptor]

    @property
    def longest(self) -> float:
        """Seconds after which to look although no change was reported."""
        return LONGEST_BLIND if self._descriptor < 0 else LONGEST

    def forget(self) -> None:
        """Forget the changes up to now; to be called before looking at what has changed."""
        if self._descriptor < 0:
            self._try_to_watch()
            return
        with contextlib.suppress(BlockingIOError):
            while os.read(self._descriptor, 1 << 16):
                pass

    def close(self) -> None:
        """Watch no more."""
        descriptor, self._descriptor = self._descriptor, -1
        if descriptor >= 0:
            os.close(descriptor)

    def __enter__(self) -> FolderWatch:
        return self

    def __exit__(self, *exception: object) -> None:
        self.close()


def wait_readable(descriptors: Iterable[int], seconds: float) -> set[int]:
    """Wait until a descriptor is readable; return the readable ones, or none after a time-out in seconds."""
    poll = select.poll()
    for descriptor in descriptors:
        poll.register(descriptor, select.POLLIN)
    return {descriptor for descriptor, _ in poll.poll(max(0.0, seconds) * 1000)}
