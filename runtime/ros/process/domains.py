"""ROS domains of this machine that no other run has claimed."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from dineros.metamodel.errors import DinerosError
from dineros.runtime.ros.process.environment import DOMAINS


@contextmanager
def claimed_domain(first: int = 1) -> Iterator[int]:
    """Claim the first domain from a number on that nobody has claimed, until the block ends.

    Two runs in one domain hear each other. A claim is a lock on a file, which ends with its process: whoever
    does not ask, such as a node that was started by hand, is not noticed.

    Parameters
    ----------
    first
        Where the search begins; after 101 it continues at 1. Domain 0, which is everybody's, is never
        claimed.

    Raises
    ------
    DinerosError
        All are taken.
    """
    numbers = [number for number in (*range(first, DOMAINS.stop), *range(1, first)) if number in DOMAINS]
    for number in numbers:
        path = Path(tempfile.gettempdir()) / f"dineros-ros-domain-{number}"
        try:
            # The file stays: one that is removed while somebody waits to lock it would be claimed twice.
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
        except OSError:  # of another user, or no file
            continue
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(file)
            continue
        try:
            yield number
        finally:
            os.close(file)
        return
    raise DinerosError("every ROS domain of this machine is claimed", hint="end runs that hang")
