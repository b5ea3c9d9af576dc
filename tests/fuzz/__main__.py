"""``python -m tests.fuzz --inputs 10000 --seed 1``: the long run, and a table of what came of it.

Each kind has a process of its own, which is started again after an input that ends it. An input that shows a
fault is kept in ``build/fuzz``; ``--replay KIND FILE`` tries one again.
"""

from __future__ import annotations

import argparse
import contextlib
import multiprocessing
import os
import sys
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from tests.fuzz.judging import judge
from tests.fuzz.targets import KINDS
from tests.fuzz.working import prepared, work

FAULTS = Path("build/fuzz")
APART = multiprocessing.get_context("forkserver")
"""Where kinds are worked on: forks of a small process that has imported everything once."""
APART.set_forkserver_preload(["tests.fuzz.working"])


def replay(name: str, path: Path) -> int:
    """Try one input, and say what came of it."""
    with prepared(name) as (_, attempt, folder):
        verdict = judge(attempt, path.read_bytes(), folder)
    print(f"status {verdict.status}, {verdict.seconds:.1f} s\n{verdict.fault or 'no fault'}")
    return 1 if verdict.fault else 0


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
        with tempfile.NamedTemporaryFile() as said:
            receiving, sending = APART.Pipe(duplex=False)
            process = APART.Process(target=work, args=(name, inputs, seed, first, sending, said.name))
            process.start()
            sending.close()
            number: int | None = None
            with receiving, contextlib.suppress(EOFError, OSError):  # the process ended
                while True:
                    found = receiving.recv()
                    if isinstance(found, int):
                        number = found
                        continue
                    _count(row, found, number)
                    if found["fault"]:
                        tell(_keep(name, seed, number or 0, found["fault"]))
                    first, number = (number or 0) + 1, None
            process.join()
            status = process.exitcode
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
    with prepared(name) as (originals, _, _):
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
    given = parser.parse_args()
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
