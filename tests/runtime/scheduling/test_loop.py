"""The loop: whoever waits elsewhere can be woken."""

from __future__ import annotations

import threading

from dineros.runtime import Net
from dineros.runtime.scheduling.loop import Loop
from tests.runtime.tiny import tiny


def test_what_is_posted_wakes_whoever_asked_for_it() -> None:
    loop, woken, done = Loop(), [], []

    def wake() -> None:
        woken.append(threading.current_thread().name)
        loop.run_actions()  # the action is there when the waker is called

    loop.wake_by(wake)
    poster = threading.Thread(target=lambda: loop.post(lambda: done.append(1)), name="poster", daemon=True)
    poster.start()
    poster.join(20)
    assert not poster.is_alive()
    assert (woken, done) == (["poster"], [1])
    loop.wake_by(None)
    loop.post(lambda: done.append(2))
    assert woken == ["poster"]
    assert loop.run_actions()
    assert done == [1, 2]


def test_a_net_that_another_loop_drives_is_woken_by_signals() -> None:
    """As by ROS: the thread that drives the net waits for something of its own."""
    net = Net(tiny({"go": "a -> b"}, {"a": 1}, signals="s", clauses={"go": "s"}))
    loop, bell, is_over = net.core.loop, threading.Event(), threading.Event()
    loop.wake_by(bell.set)
    loop.begin()

    def drive() -> None:
        loop.adopt()
        while not is_over.is_set():
            loop.run_actions()
            while net.core.execution.fire_one():
                pass
            bell.wait()
            bell.clear()

    driver = threading.Thread(target=drive, daemon=True)
    driver.start()
    net.signal("s").set(True)
    net.wait_for(lambda state: state.count("b") == 1, timeout=20)
    is_over.set()
    bell.set()
    driver.join(20)
    assert not driver.is_alive()
    loop.abandon()
