"""Work in a process of its own: what it tells arrives, it ends when it shall, and leaves nothing behind."""

from __future__ import annotations

import contextlib
import ctypes
import os
import signal
import subprocess
import threading
import time
from pathlib import Path
from typing import Any

import pytest

from dineros.analysis.answers.apart import Apart, ApartDiedError, Tell, ready
from dineros.analysis.answers.processes import ProcessTree

FOR_EVER = 600.0


def is_running(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[0] not in (b"Z", b"X")
    except OSError:
        return False


def first(apart: Apart) -> Any:
    return next(apart.messages())


def sleeping(tell: Tell) -> None:
    tell("begun")
    time.sleep(FOR_EVER)


def ends(process: int) -> bool:
    until = time.monotonic() + 60
    while is_running(process) and time.monotonic() < until:
        time.sleep(0.01)
    return not is_running(process)


class UntellableError(Exception):
    """Cannot be pickled, whatever libraries teach `pickle` about errors."""

    def __init__(self, one: int, two: int) -> None:
        super().__init__(f"{one} and {two}")
        self.cause = lambda: None


def test_what_is_told_and_returned_arrives_in_order() -> None:
    def work(tell: Tell) -> object:
        for number in range(100):
            tell(number)
        tell("x" * 3_000_000)  # more than the pipe holds
        return os.getpid()

    with Apart(work) as apart:
        *numbers, long = apart.messages()
        assert numbers == list(range(100)) and len(long) == 3_000_000
        assert apart.value() == apart.process != os.getpid()
    assert not is_running(apart.process)


def test_threads_of_the_work_do_not_tear_what_is_told() -> None:
    def work(tell: Tell) -> None:
        def say(sign: str) -> None:
            for _ in range(20):
                tell(sign * 70_000)

        threads = [threading.Thread(target=say, args=sign) for sign in "abc"]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()

    with Apart(work) as apart:
        told = list(apart.messages())
    assert sorted(told) == sorted(sign * 70_000 for sign in "abc" for _ in range(20))


@pytest.mark.parametrize(
    ("error", "kind", "text"),
    [
        (ValueError("no"), ValueError, "^no$"),
        (UntellableError(1, 2), RuntimeError, "UntellableError: 1 and 2"),
        (KeyboardInterrupt(), KeyboardInterrupt, "^$"),
    ],
)
def test_what_the_work_raises_is_raised(error: BaseException, kind: type[Exception], text: str) -> None:
    def work(_: Tell) -> None:
        raise error

    with Apart(work) as apart:
        assert list(apart.messages()) == []
        with pytest.raises(kind, match=text):
            apart.value()


def test_what_cannot_be_told_is_said() -> None:
    with Apart(lambda _: lambda: None) as apart:
        assert list(apart.messages()) == []
        with pytest.raises(RuntimeError, match="function cannot be sent"):
            apart.value()


def test_asked_to_end_it_may_say_what_it_has_and_only_once() -> None:
    def work(tell: Tell) -> str:
        try:
            tell("begun")
            time.sleep(FOR_EVER)
        except KeyboardInterrupt:
            tell("asked")
        return "what there is"

    with Apart(work) as apart:
        assert first(apart) == "begun"
        apart.ask_to_end()
        apart.ask_to_end()
        assert list(apart.messages()) == ["asked"]
        assert apart.value() == "what there is"


def test_an_interrupt_that_a_library_swallows_ends_it_all_the_same() -> None:
    """As in a callback from C: the interrupt is printed there, and something else fails for it."""

    def work(tell: Tell) -> None:
        tell("begun")
        with contextlib.suppress(KeyboardInterrupt):
            time.sleep(FOR_EVER)
        raise RuntimeError("no compiled object yet")

    with Apart(work) as apart:
        assert first(apart) == "begun"
        apart.ask_to_end()
        assert list(apart.messages()) == []
        with pytest.raises(KeyboardInterrupt):
            apart.value()


def test_an_interrupt_in_a_callback_from_c_is_not_lost_and_says_nothing(
    capfd: pytest.CaptureFixture[str],
) -> None:
    """Kernels are loaded by callbacks; what these raise, C cannot pass on."""

    called = ctypes.CFUNCTYPE(None)(lambda: time.sleep(0.3))

    def work(tell: Tell) -> None:
        tell("begun")
        called()
        time.sleep(FOR_EVER)

    with Apart(work) as apart:
        assert first(apart) == "begun"
        time.sleep(0.1)
        apart.ask_to_end()
        assert list(apart.messages(30)) == []
        with pytest.raises(KeyboardInterrupt):
            apart.value()
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("is_asked", [True, False])
def test_what_an_interrupt_left_unfinished_is_destroyed_without_a_word(
    capfd: pytest.CaptureFixture[str], is_asked: bool
) -> None:
    """Its destructor may fail, as that of a compiler's object does; else such an error is shown."""

    class Half:
        def __del__(self) -> None:
            raise AttributeError("half")

    def work(tell: Tell) -> None:
        half = Half()
        with contextlib.suppress(KeyboardInterrupt):
            tell("begun")
            time.sleep(30.0 if is_asked else 0.0)
        del half

    with Apart(work) as apart:
        first(apart)
        if is_asked:
            apart.ask_to_end()
        list(apart.messages())
        assert apart.value() is None
    assert ("half" in capfd.readouterr().err) is not is_asked


def test_it_is_asked_between_two_messages_never_within_one() -> None:
    def work(tell: Tell) -> None:
        while True:
            tell("y" * 200_000)

    with Apart(work) as apart:
        assert first(apart) == "y" * 200_000
        apart.ask_to_end()
        assert set(apart.messages()) <= {"y" * 200_000}
        with pytest.raises(KeyboardInterrupt):
            apart.value()


def test_ended_it_is_gone_with_all_it_started_and_what_it_told_is_there() -> None:
    def work(tell: Tell) -> None:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)
        own = subprocess.Popen(["sleep", str(FOR_EVER)], start_new_session=True)
        tell(own.pid)
        with Apart(sleeping) as nested:
            tell(nested.process)
            time.sleep(FOR_EVER)

    with Apart(work) as apart:
        started = [next(apart.messages()) for _ in range(2)]
        assert all(is_running(process) for process in started)
        assert list(apart.messages(0)) == []
        apart.end()
        assert list(apart.messages()) == []
        with pytest.raises(ApartDiedError) as died:
            apart.value()
        assert died.value.signal == signal.SIGKILL
    assert all(ends(process) for process in [apart.process, *started])


def test_leaving_the_context_ends_it() -> None:
    with Apart(sleeping) as apart:
        assert first(apart) == "begun"
        with pytest.raises(ValueError, match="still runs"):
            apart.value()
    assert not is_running(apart.process)


def test_it_ends_with_the_process_that_started_it() -> None:
    def parent(tell: Tell) -> None:
        with Apart(sleeping) as apart:
            tell((first(apart), apart.process))
            os.kill(os.getpid(), signal.SIGKILL)

    with Apart(parent) as apart:
        said, process = first(apart)
        assert said == "begun"
        assert ends(process)


def test_interrupts_from_the_terminal_are_for_the_parent() -> None:
    def work(tell: Tell) -> str:
        tell("begun")
        os.kill(os.getpid(), signal.SIGINT)
        return "continued"

    with Apart(work) as apart:
        assert list(apart.messages()) == ["begun"]
        assert apart.value() == "continued"


def test_of_several_the_first_that_knows_is_ready() -> None:
    def silent(_: Tell) -> None:
        time.sleep(FOR_EVER)

    with Apart(silent) as slow, Apart(lambda _: 1) as quick:
        assert ready([slow, quick]) == [quick]
        assert list(quick.messages()) == [] and quick.value() == 1


def test_the_memory_of_a_tree_counts_shared_pages_once_if_it_matters() -> None:
    size = 64 << 20
    shared = bytearray(b"x" * size)

    def idle(tell: Tell) -> None:
        tell(shared[0])
        time.sleep(FOR_EVER)

    def work(tell: Tell) -> None:
        with Apart(idle) as one, Apart(idle) as two:
            tell((first(one), first(two)))
            time.sleep(FOR_EVER)

    with Apart(work) as apart:
        first(apart)
        tree = ProcessTree(apart.process)
        counted_often, counted_once = tree.memory(1 << 60), tree.memory(0)
        # All of them share what this process has, so nothing but each one's own comes to the one count.
        assert counted_often - counted_once >= 2 * size
        assert 0 < counted_once < counted_often / 2
