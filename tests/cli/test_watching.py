"""What ends a run that is watched."""

from __future__ import annotations

import os
import signal
from pathlib import Path

from dineros.cli.running.watching import Wanted, watch
from dineros.runtime.application.observer import FolderObserver


class Dying:
    """Is interrupted in its destructor, where an exception comes to nobody."""

    def __del__(self) -> None:
        os.kill(os.getpid(), signal.SIGINT)


def test_an_interrupt_at_a_bad_moment_ends_the_run(tmp_path: Path) -> None:
    wanted = Wanted(None, 20.0, tmp_path, None, None, False, None)
    dying = [Dying()]

    def look_after() -> bool:
        dying.clear()
        return True

    former = signal.signal(signal.SIGINT, wanted.interrupt)
    try:
        assert watch(wanted, FolderObserver(tmp_path), look_after) == "interrupted"
    finally:
        signal.signal(signal.SIGINT, former)
