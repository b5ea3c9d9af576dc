"""Another checkout next to this one: rows of `benchmarks.analysis.state_spaces`, each by turns on both sides.

Machines are shared and noisy: two tables made one after the other say little about a few percent. Here a row
is measured on one side, then on the other, again and again, each time in a new process forked from one that
has its kernels loaded; the least processor times of each side are compared. Rows that cost over 5 % more are
marked.

Usage: ``python -m benchmarks.beside CHECKOUT [--seconds S] [words to choose rows by]``. The other checkout
has an environment of its own (``make install``).
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from benchmarks.analysis.state_spaces import EXPLICIT, LONG, NETS, machine

HERE = Path(__file__).resolve().parents[1]
LEAST, MOST = 3, 41
"""How often a row is measured on each side."""

TOLERATED = 1.05

WORKER = """
import gc, json, os, resource, sys, time
try:
    from benchmarks.analysis.state_spaces import NETS, count, warm_up
except ModuleNotFoundError:  # where it stood before
    from benchmarks.state_spaces import NETS, count, warm_up
from tests.analysis import classic_nets as classic
def used():
    own, ended = resource.getrusage(resource.RUSAGE_SELF), resource.getrusage(resource.RUSAGE_CHILDREN)
    return own.ru_utime + own.ru_stime + ended.ru_utime + ended.ru_stime
warm = set()
for line in sys.stdin:
    name, engine = line.split()
    net = NETS[name]()
    if (name, engine) not in warm:
        warm_up(net, engine)
        count(classic.philosophers(3), engine)
        warm.add((name, engine))
    gc.collect()  # so that no collection of what others left falls into the count by chance
    reader, writer = os.pipe()
    if not os.fork():
        before, began = used(), time.perf_counter()
        markings = count(net, engine)[0]
        result = [used() - before, time.perf_counter() - began, str(markings)]
        os.write(writer, json.dumps(result).encode())
        os._exit(0)
    os.close(writer)
    print(os.read(reader, 9999).decode(), flush=True)
    os.close(reader)
    os.wait()
"""


Measure = Callable[[str, str], tuple[float, float, str]]
"""Counts a net once by an engine: processor seconds, seconds and markings."""


@contextmanager
def measuring(checkout: Path) -> Iterator[Measure]:
    """Start the process that measures in a checkout, and end it."""
    command = [str(checkout / ".venv/bin/python"), "-c", WORKER]
    with subprocess.Popen(
        command, cwd=checkout, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        asked, answers = process.stdin, process.stdout
        assert asked is not None and answers is not None

        def measure(name: str, engine: str) -> tuple[float, float, str]:
            print(name, engine, file=asked, flush=True)
            answer = answers.readline()
            if not answer.strip():
                raise SystemExit(f"{name} {engine} did not end")
            processor, seconds, markings = json.loads(answer)
            return processor, seconds, markings

        yield measure
        process.kill()


def rows() -> list[tuple[str, str]]:
    """Return nets with engines."""
    return [
        (name, engine)
        for name in NETS
        for engine in ("symbolic", "reduced", "explicit-1", "explicit-2", "depth-first")
        if engine in ("symbolic", "reduced") or (name in EXPLICIT and name not in LONG)
    ]


def main() -> int:
    """Print the table; 1 where a row costs more."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("checkout", type=Path)
    parser.add_argument("--seconds", type=float, default=6.0, help="for each row and side, at least (6)")
    parser.add_argument("words", nargs="*")
    given = parser.parse_intermixed_args()
    print(machine(), end="\n\n")
    print("| net | engine | there | here | here / there | by the clock | measured |\n|" + "---|" * 7)
    slower = 0
    for name, engine in rows():
        if not all(word in f"{name} {engine}" for word in given.words):
            continue
        with ExitStack() as stack:  # a process for each row: memory of one row is not part of the next
            there, here = (stack.enter_context(measuring(each)) for each in (given.checkout.resolve(), HERE))
            found: list[tuple[tuple[float, float, str], ...]] = []
            while len(found) < LEAST or (
                len(found) < MOST and sum(each[0][1] for each in found) < given.seconds
            ):
                pair = there(name, engine), here(name, engine)
                if pair[0][2] != pair[1][2]:
                    raise SystemExit(f"{name} {engine}: {pair[0][2]} there, {pair[1][2]} here")
                found.append(pair)
        processor = [min(each[side][0] for each in found) for side in (0, 1)]
        seconds = [min(each[side][1] for each in found) for side in (0, 1)]
        quotient = processor[1] / processor[0]
        slower += quotient > TOLERATED
        print(
            f"| {name} | {engine} | {processor[0]:.4f} | {processor[1]:.4f} | {quotient:.2f}"
            f"{' slower' if quotient > TOLERATED else ''} | {seconds[1] / seconds[0]:.2f} | {len(found)} |",
            flush=True,
        )
    return 1 if slower else 0


if __name__ == "__main__":
    sys.exit(main())
