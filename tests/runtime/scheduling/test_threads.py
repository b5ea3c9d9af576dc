"""Waiting for threads that may not have been started."""

from __future__ import annotations

import threading
from collections.abc import Callable

import pytest

from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.scheduling.threads import join


def in_time(action: Callable[[], None]) -> bool:
    """Tell whether an action returns within 20 seconds, without an error."""
    returned: list[bool] = []

    def run() -> None:
        action()
        returned.append(True)

    thread = threading.Thread(target=run, daemon=True)
    thread.start()
    thread.join(20)
    return returned == [True]


def test_a_thread_that_was_not_started_is_not_waited_for() -> None:
    """Ctrl-C may come between making a thread and starting it; cleaning up must not fail."""
    assert in_time(lambda: join(threading.Thread(target=threading.Event().wait)))
    assert in_time(lambda: join(None))


def test_a_thread_that_runs_is_waited_for() -> None:
    ends, seen = threading.Event(), []
    thread = threading.Thread(target=lambda: seen.append(ends.wait(20)), daemon=True)
    thread.start()
    join(thread, 0.01)
    assert seen == []
    ends.set()
    assert in_time(lambda: join(thread))
    assert seen == [True]


def test_a_network_whose_start_was_interrupted_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    def start(_: threading.Thread) -> None:
        raise KeyboardInterrupt

    network = LocalNetwork()
    with monkeypatch.context() as patch, pytest.raises(KeyboardInterrupt):
        patch.setattr(threading.Thread, "start", start)
        network.start()
    assert in_time(network.stop)
