"""Tracing files of strangers: the text that Babeltrace 2 writes, damaged."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from tests.fuzz import seeds
from tests.fuzz.judging import Outcome, run_command
from tests.support.traces import Trace

Attempt = Callable[[bytes], Outcome]


def tracing(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Narrow a model by a damaged trace; return whole ones and what takes one."""
    model, path = seeds.model(folder), folder / "trace.txt"

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("narrow", model, "--tracing", path, "--memory", "600M", "--timeout", "5")

    return [_whole(1).encode(), _whole(12).encode()], attempt


def _whole(rounds: int) -> str:
    trace = Trace()
    talker, listener = trace.node("/talker"), trace.node("/listener")
    chatter = trace.publisher(talker, "/chatter")
    say, heard = trace.timer(talker, 100_000_000), trace.subscription(listener, "/chatter")
    for _ in range(rounds):
        trace.run(say, [chatter])
        trace.run(heard, thread=2)
    return "".join(trace.lines)
