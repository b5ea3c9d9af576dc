"""What must not happen, whatever comes in: a stack trace, a hang, another exit status, much memory."""

from __future__ import annotations

import io
import signal
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from dineros.cli.main import main
from dineros.metamodel.errors import DinerosError

ACCEPTED, REFUSED = 0, 2
CPU_SECONDS = 60
"""After so much time of the processor, an input counts as one that hangs."""
MEMORY = 700 << 20
"""Bytes that one input may add to the process; commands with a budget are given less."""
_BAD = ("Traceback", "unexpected", "report it", "Error:", "AssertionError")


class HangError(BaseException):
    """Time was over; no `except Exception` catches it."""


@dataclass(frozen=True)
class Outcome:
    """How one input ended.

    Attributes
    ----------
    status : int
        An exit status of the command line: 0 to 3.
    said : str
        What stood on standard error.
    """

    status: int
    said: str = ""


@dataclass(frozen=True)
class Verdict:
    """How one input was judged; `fault` is None where all was well."""

    status: int | None
    fault: str | None
    seconds: float


def run_command(*arguments: object) -> Outcome:
    """Run ``dineros`` in this process."""
    out, error = (
        io.TextIOWrapper(io.BytesIO(), encoding="utf-8", errors=errors)
        for errors in ("strict", "backslashreplace")
    )
    former, former_arguments = (sys.stdout, sys.stderr), sys.argv
    sys.stdout, sys.stderr = out, error
    try:
        main.main([str(argument) for argument in arguments])
    except SystemExit as ended:
        status = int(ended.code or 0)
    finally:
        (sys.stdout, sys.stderr), sys.argv = former, former_arguments
    error.flush()
    return Outcome(status, error.buffer.getvalue().decode("utf-8"))


def refused_or(work: Callable[[], object]) -> Outcome:
    """Do something that no command line does; a `DinerosError` is what may come of it."""
    try:
        work()
    except DinerosError as error:
        return Outcome(REFUSED, f"{error}\n")
    return Outcome(ACCEPTED)


def judge(attempt: Callable[[bytes], Outcome], content: bytes, folder: Path | None = None) -> Verdict:
    """Try one input, and say what is wrong with what came of it.

    Parameters
    ----------
    attempt : callable
        Given the input.
    content : bytes
        The input.
    folder : Path, optional
        Where no half-written file may be left.
    """
    _forget_peak()
    before, begun = _memory("VmRSS"), time.monotonic()
    outcome: Outcome | None = None
    fault: str | None = None
    try:
        with _limited_time():
            outcome = attempt(content)
    except HangError:
        fault = f"hangs: {CPU_SECONDS} s of the processor"
    except Exception:
        fault = traceback.format_exc()
    seconds = time.monotonic() - begun
    grown = _memory("VmHWM") - before
    if outcome is not None:
        fault = _fault_of(outcome)
    if fault is None and grown > MEMORY:
        fault = f"memory: {grown >> 20} MiB more"
    if fault is None and folder is not None:
        left = [path.name for path in folder.rglob("*") if ".dineros-tmp" in path.name]
        fault = f"left over: {', '.join(left)}" if left else None
        for name in left:
            with suppress(OSError):
                (folder / name).unlink()
    return Verdict(outcome.status if outcome else None, fault, seconds)


def _fault_of(outcome: Outcome) -> str | None:
    if outcome.status not in (0, 1, 2, 3):
        return f"exit status {outcome.status}: {outcome.said}"
    if any(word in line for line in outcome.said.splitlines() for word in _BAD if not _quotes(line, word)):
        return f"says: {outcome.said}"
    if outcome.status == REFUSED and not outcome.said.strip():
        return "is refused without a word"
    if any(line[:1].isspace() for line in outcome.said.splitlines()):
        return f"says more than lines of their own: {outcome.said}"
    if len(outcome.said) > 10_000:
        return f"says {len(outcome.said)} characters: {outcome.said[:500]}"
    return None


def _quotes(line: str, word: str) -> bool:
    """Return whether a message of ours only uses such a word."""
    return word == "unexpected" and "dineros: unexpected" not in line


@contextmanager
def _limited_time() -> Iterator[None]:
    """Raise where the processor has worked too long; other programs that take it do not count.

    SIGALRM is the commands' own, which watch over their memory by it.
    """

    def over(*_: object) -> None:
        raise HangError

    former = signal.signal(signal.SIGPROF, over)
    signal.setitimer(signal.ITIMER_PROF, CPU_SECONDS, 1)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, former)


def _forget_peak() -> None:
    """Let the peak begin again (proc(5), clear_refs)."""
    with suppress(OSError):
        Path("/proc/self/clear_refs").write_text("5")


def _memory(label: str) -> int:
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith(f"{label}:"):
            return int(line.split()[1]) * 1024
    return 0
