"""``python -m tests.fuzz --inputs 10000 --seed 1``: the long run, and a table of what came of it.

Each kind has a process of its own, which is started again after an input that ends it. An input that shows a
fault is kept in ``build/fuzz``; ``--replay KIND FILE`` tries one again.
"""

from __future__ import annotations

import argparse
import contextlib
import faulthandler
import gc
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.fuzz.judging import judge
from tests.fuzz.targets import KINDS

FAULTS = Path("build/fuzz")
WALL_SECONDS = 300
"""After so much time an input counts as one that hangs, whatever the process waits for."""

BETWEEN_COLLECTIONS = 20
"""Inputs between two collections of garbage: commands put them off, as their process usually ends before."""


def work(name: str, inputs: int, seed: int, first: int) -> None:
    """Try the inputs of one kind; print a line of JSON for each."""
    kind = KINDS[name]
    results = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    with _prepared(name) as (originals, attempt, folder):
        for number in range(first, inputs):
            if number % BETWEEN_COLLECTIONS == 0:
                gc.collect()
            content = kind.input(originals, name, seed, number)
            (folder / "current").write_bytes(content)
            print(json.dumps({"number": number}), file=results, flush=True)
            faulthandler.dump_traceback_later(WALL_SECONDS, exit=True)
            verdict = judge(attempt, content, folder)
            faulthandler.cancel_dump_traceback_later()
            print(json.dumps(vars(verdict)), file=results, flush=True)


def replay(name: str, path: Path) -> int:
    """Try one input, and say what came of it."""
    with _prepared(name) as (_, attempt, folder):
        verdict = judge(attempt, path.read_bytes(), folder)
    print(f"status {verdict.status}, {verdict.seconds:.1f} s\n{verdict.fault or 'no fault'}")
    return 1 if verdict.fault else 0


@contextlib.contextmanager
def _prepared(name: str) -> Any:
    gc.collect()
    with tempfile.TemporaryDirectory(prefix="dineros-fuzz-") as place:
        folder = Path(place)
        os.environ["XDG_STATE_HOME"] = str(folder / "state")
        with KINDS[name].prepared(folder) as (originals, attempt):
            yield originals, attempt, folder


def watch(name: str, inputs: int, seed: int, tell: Callable[[str], None]) -> dict[str, Any]:
    """Let processes work until all inputs of a kind are tried; return the row of the table."""
    row: dict[str, Any] = {
        "kind": name,
        "inputs": 0,
        "number": 0,
        "accepted": 0,
        "refused": 0,
        "seconds": 0.0,
        "slowest": 0.0,
        "faults": 0,
    }
    first = 0
    while first < inputs:
        options = [name, "--inputs", str(inputs), "--seed", str(seed), "--first", str(first)]
        with tempfile.TemporaryFile() as said:
            process = subprocess.Popen(
                [sys.executable, "-m", "tests.fuzz", "--work", *options],
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
            )
            assert process.stdout is not None
            number: int | None = None
            for line in process.stdout:
                found = json.loads(line)
                if "number" in found:
                    number = found["number"]
                    continue
                _count(row, found, number)
                if found["fault"]:
                    tell(_keep(name, seed, number or 0, found["fault"]))
                first, number = (number or 0) + 1, None
            status = process.wait()
            said.seek(0)
            end = said.read().decode("utf-8", "replace")[-6000:]
        if number is not None:
            row["inputs"] += 1
            row["faults"] += 1
            tell(_keep(name, seed, number, f"the process ended with {status}: {end}"))
            first = number + 1
        elif first < inputs:
            tell(f"{name}: cannot be prepared: {end}")
            row["faults"] += 1
            break
    return row


def _count(row: dict[str, Any], verdict: dict[str, Any], number: int | None) -> None:
    row["inputs"] += 1
    row["seconds"] += verdict["seconds"]
    if verdict["seconds"] > row["slowest"]:
        row["slowest"], row["number"] = verdict["seconds"], number
    what = "faults" if verdict["fault"] else "refused" if verdict["status"] == 2 else "accepted"
    row[what] += 1


def _keep(name: str, seed: int, number: int, fault: str) -> str:
    """Keep an input, and what came of it; return a line about it."""
    FAULTS.mkdir(parents=True, exist_ok=True)
    path = FAULTS / f"{name.strip('-.').replace(' ', '_')}-{seed}-{number}"
    path.write_bytes(_input(name, seed, number))
    path.with_name(f"{path.name}.txt").write_text(fault, encoding="utf-8", errors="backslashreplace")
    lines = fault.strip().splitlines()
    return f"{name}: {path}: {lines[0][:100]} ... {lines[-1][:200]}"


def _input(name: str, seed: int, number: int) -> bytes:
    with _prepared(name) as (originals, _, _):
        return KINDS[name].input(originals, name, seed, number)


def main() -> int:
    """Read the command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.fuzz", description="Fuzz every kind of input.")
    parser.add_argument("--inputs", type=int, default=10_000, help="inputs of all kinds together")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--kind", action="append", choices=list(KINDS), help="only this kind; repeatable")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="kinds at a time")
    parser.add_argument("--show", nargs=2, metavar=("KIND", "NUMBER"), help="print one input of the seed")
    parser.add_argument("--replay", nargs=2, metavar=("KIND", "FILE"), help="try one input again")
    parser.add_argument("--work", help=argparse.SUPPRESS)
    parser.add_argument("--first", type=int, default=0, help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.work:
        work(given.work, given.inputs, given.seed, given.first)
        return 0
    if given.show:
        sys.stdout.buffer.write(_input(given.show[0], given.seed, int(given.show[1])))
        return 0
    if given.replay:
        return replay(given.replay[0], Path(given.replay[1]))
    names = given.kind or list(KINDS)
    shares = sum(KINDS[name].share for name in names)
    begun = time.monotonic()
    rows = []
    print(
        f"{'kind':22}{'inputs':>8}{'accepted':>10}{'refused':>9}{'seconds':>9}{'slowest s':>11}{'number':>8}"
        f"{'faults':>8}",
        flush=True,
    )
    with ThreadPoolExecutor(given.jobs) as pool:
        tell = lambda line: print(line, file=sys.stderr, flush=True)  # noqa: E731
        inputs = {name: -(-given.inputs * KINDS[name].share // shares) for name in names}
        begun_kinds = [pool.submit(watch, name, inputs[name], given.seed, tell) for name in names]
        for done in as_completed(begun_kinds):
            rows.append(row := done.result())
            print(
                f"{row['kind']:22}{row['inputs']:8}{row['accepted']:10}{row['refused']:9}{row['seconds']:9.0f}"
                f"{row['slowest']:11.1f}{row['number']:8}{row['faults']:8}",
                flush=True,
            )
    total, faults = sum(row["inputs"] for row in rows), sum(row["faults"] for row in rows)
    print(f"{total} inputs in {time.monotonic() - begun:.0f} s: {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
