"""A process that tries the inputs of one kind."""

from __future__ import annotations

import contextlib
import faulthandler
import gc
import os
import tempfile
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from tests.fuzz.judging import judge
from tests.fuzz.targets import KINDS

WALL_SECONDS = 300
"""After so much time an input counts as one that hangs, whatever the process waits for."""

BETWEEN_COLLECTIONS = 20
"""Inputs between two collections of garbage: commands put them off, as their process usually ends before."""


def work(name: str, inputs: int, seed: int, first: int, results: Connection, log: str) -> None:
    """Try the inputs of one kind, in a process for it; send the number of each, then its verdict.

    What is printed goes into a file.
    """
    kind = KINDS[name]
    with Path(log).open("ab") as file:
        for stream in (1, 2):
            os.dup2(file.fileno(), stream)
    with prepared(name) as (originals, attempt, folder):
        for number in range(first, inputs):
            if number % BETWEEN_COLLECTIONS == 0:
                gc.collect()
            content = kind.input(originals, name, seed, number)
            (folder / "current").write_bytes(content)
            results.send(number)
            faulthandler.dump_traceback_later(WALL_SECONDS, exit=True)
            verdict = judge(attempt, content, folder)
            faulthandler.cancel_dump_traceback_later()
            results.send(vars(verdict))


@contextlib.contextmanager
def prepared(name: str) -> Any:
    """Prepare a kind: its originals, what tries one input, and a folder, for as long as it is worked on."""
    gc.collect()
    with tempfile.TemporaryDirectory(prefix="dineros-fuzz-") as place:
        folder = Path(place)
        os.environ["XDG_STATE_HOME"] = str(folder / "state")
        with KINDS[name].prepared(folder) as (originals, attempt):
            yield originals, attempt, folder
