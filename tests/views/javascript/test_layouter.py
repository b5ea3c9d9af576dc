"""The process of JavaScript: it ends, hangs or is not there, and what asked it continues."""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from dineros.views.javascript.client import Layouter, LayouterError, ScriptError

ENDLESS = "() => { for (;;) {} }"


@pytest.fixture
def layouter() -> Iterator[Layouter]:
    made = Layouter()
    yield made
    made.close()


def busy(process: int) -> bool:
    """Tell whether a process has worked for a second, of which half a second is its start."""
    fields = Path(f"/proc/{process}/stat").read_text().rsplit(")")[1].split()
    return int(fields[11]) + int(fields[12]) > os.sysconf("SC_CLK_TCK")


def is_gone(process: int) -> bool:
    try:
        return Path(f"/proc/{process}/stat").read_text().rsplit(")")[1].split()[0] == "Z"
    except (FileNotFoundError, ProcessLookupError):
        return True


def test_killed_in_the_middle_it_is_said_and_the_next_one_answers(layouter: Layouter) -> None:
    with ThreadPoolExecutor(1) as thread:
        asked = thread.submit(layouter.evaluate, [], ENDLESS)
        while layouter.process is None or not busy(layouter.process):
            time.sleep(0.02)
        os.kill(layouter.process, signal.SIGSEGV)
        with pytest.raises(LayouterError, match=r"the layouter ended \(SIGSEGV\)"):
            asked.result()
    assert layouter.evaluate([], "(a, b) => a + b", 1, 2) == 3


def test_killed_between_two_requests_nobody_notices(layouter: Layouter) -> None:
    for number in range(3):
        assert layouter.evaluate([], "(a) => a", number) == number
        assert layouter.process is not None
        os.kill(layouter.process, signal.SIGKILL)


def test_one_that_always_ends_is_not_started_for_ever(
    layouter: Layouter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("DINEROS_LAYOUTER", "dies")
    for _ in range(3):
        with pytest.raises(LayouterError, match="SIGSEGV"):
            layouter.evaluate([], "() => 1")
    with pytest.raises(LayouterError, match="ended 3 times"):
        layouter.evaluate([], "() => 1")


def test_one_that_hangs_is_killed() -> None:
    layouter = Layouter(seconds=2)
    with pytest.raises(LayouterError, match="did not answer within 2 s"):
        layouter.evaluate([], ENDLESS)
    assert layouter.process is None


def test_an_error_of_a_script_is_that_of_its_request_only(layouter: Layouter) -> None:
    assert layouter.evaluate([], "() => [1]") == [1]
    before = layouter.process
    for function in ("() => { throw new Error('so not') }", "async () => { throw new Error('so not') }"):
        with pytest.raises(ScriptError, match=r"^so not$"):
            layouter.evaluate([], function)
    with pytest.raises(ScriptError, match="SyntaxError"):
        layouter.evaluate([], "((")
    with pytest.raises(ScriptError, match="no answer"):
        layouter.evaluate([], "() => new Promise(() => 0)")
    assert layouter.evaluate([], "async (a) => a", {"__proto__": "a\u2028\ud800'"}) == {
        "__proto__": "a\u2028\ud800'"
    }
    assert layouter.process == before


def test_its_memory_is_bounded() -> None:
    layouter = Layouter(heap=64)
    with pytest.raises(LayouterError, match="the layouter ended"):
        layouter.evaluate([], "() => { const a = []; for (let i = 0; ; i++) a.push({ i }); }")
    assert layouter.evaluate([], "() => 1") == 1
    layouter.close()


def test_threads_get_their_own_answers(layouter: Layouter) -> None:
    with ThreadPoolExecutor(8) as threads:
        found = threads.map(lambda number: layouter.evaluate([], "(a) => a", number), range(64))
        assert list(found) == list(range(64))


def _evaluate_forked(layouter: Layouter, results: object) -> None:
    results.put((layouter.evaluate([], "() => 'child'"), layouter.process))  # type: ignore[attr-defined]
    layouter.close()


def test_a_forked_process_has_its_own(layouter: Layouter) -> None:
    os.register_at_fork(after_in_child=layouter.forget)
    assert layouter.evaluate([], "() => 'parent'") == "parent"
    forking = multiprocessing.get_context("fork")
    results = forking.SimpleQueue()
    child = forking.Process(target=_evaluate_forked, args=(layouter, results))
    child.start()
    said, process = results.get()
    child.join()
    assert said == "child"
    assert process != layouter.process
    assert layouter.evaluate([], "() => 'parent'") == "parent"


def test_processes_are_started_while_a_thread_waits_for_an_answer(layouter: Layouter) -> None:
    """As the supervisor of a run starts a node again while the live page's net is laid out."""
    os.register_at_fork(after_in_child=layouter.forget)
    layouter.evaluate([], "() => 1")
    with ThreadPoolExecutor(1) as threads:
        answer = threads.submit(layouter.evaluate, [], ENDLESS)
        assert layouter.process is not None
        process = layouter.process
        while not busy(process):
            time.sleep(0.01)
        forked = os.fork()
        if forked == 0:
            os._exit(0)
        ended = (0, 0)
        deadline = time.monotonic() + 60
        while ended == (0, 0) and time.monotonic() < deadline:
            ended = os.waitpid(forked, os.WNOHANG)
            time.sleep(0.01)
        if ended == (0, 0):
            os.kill(forked, signal.SIGKILL)
            os.waitpid(forked, 0)
        layouter.close()
        assert isinstance(answer.exception(60), LayouterError)
    assert ended == (forked, 0)


def test_where_no_process_can_be_started_that_is_said(
    layouter: Layouter, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with pytest.raises(LayouterError, match="cannot be started: No such file"):
        layouter.evaluate([], "() => 1")


def test_the_terminal_does_not_reach_it_and_the_folder_is_not_searched(
    layouter: Layouter, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    for module in ("json", "py_mini_racer", "socket"):
        (tmp_path / f"{module}.py").write_text("open('searched', 'w')")
    monkeypatch.chdir(tmp_path)
    assert layouter.evaluate([], "() => 1") == 1
    assert not (tmp_path / "searched").exists()
    assert layouter.process is not None
    assert os.getsid(layouter.process) != os.getsid(0)


COMMAND = """
import sys, threading
from pathlib import Path
from dineros.views.javascript import client
threading.Thread(target=client.evaluate, args=([], sys.argv[1]), daemon=True).start()
while client._LAYOUTER.process is None:
    pass
assert "mini_racer" not in Path("/proc/self/maps").read_text()
print(client._LAYOUTER.process, flush=True)
sys.stdin.readline()
"""


@pytest.mark.parametrize("killed", [True, False])
def test_it_ends_with_its_command(killed: bool) -> None:
    command = subprocess.Popen(
        [sys.executable, "-c", COMMAND, ENDLESS],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert command.stdin and command.stdout and command.stderr
    process = int(command.stdout.readline())
    while not busy(process):  # in the middle of a request
        time.sleep(0.02)
    if killed:
        command.kill()
    else:
        command.stdin.write("\n")
        command.stdin.flush()
    command.wait(60)
    while not is_gone(process):
        time.sleep(0.02)
    assert (command.returncode, command.stderr.read()) == (-signal.SIGKILL if killed else 0, "")
    for stream in (command.stdin, command.stdout, command.stderr):
        stream.close()
