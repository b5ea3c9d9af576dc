"""ROS domains of this machine that are not used by another run."""

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
    """Claim the first unclaimed domain from a number on, until the block ends.

    Two runs in one domain receive each other's messages. A claim is a lock on a file, which ends with its
    process. Programs that claim no domain, such as a node started by hand, are not detected.

    Parameters
    ----------
    first
        First domain to try; after 101 the search continues at 1. Domain 0, the default of all programs, is
        never claimed.

    Raises
    ------
    DinerosError
        All domains are claimed.
    """
    numbers = [number for number in (*range(first, DOMAINS.stop), *range(1, first)) if number in DOMAINS]
    for number in numbers:
        path = Path(tempfile.gettempdir()) / f"dineros-ros-domain-{number}"
        try:
            # The file is kept: if it were removed while another process waits for its lock, both would get a
            # lock.
            file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW | os.O_CLOEXEC, 0o600)
        except OSError:  # of another user, or not a regular file
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
    raise DinerosError("every ROS domain of this machine is claimed", hint="stop runs that hang")
