"""The Model Checking Contest's nets: every examination, compared with the verdicts that are known.

``python -m benchmarks.contest.run FOLDER`` wants a folder with ``nets/NAME.tgz`` (``model.pnml`` and the
contest's formula files) and ``expected.json`` (net -> examination -> id -> verdict). Each net runs in a
process of its own, which is ended when it has used up the processor time of all its questions together, or
takes more memory than it may; what it has said until then counts. Results are JSON Lines, to which a second
run only adds what is missing.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from benchmarks._processes import mebibytes, processor_seconds
from benchmarks.contest.archives import unpack
from benchmarks.contest.tables import print_tables
from dineros.analysis.properties.property import GLOBAL_PROPERTIES

EXAMINATIONS = (
    "StateSpace",
    "ReachabilityCardinality",
    "ReachabilityFireability",
    "UpperBounds",
    "CTLCardinality",
    "CTLFireability",
    "LTLCardinality",
    "LTLFireability",
    *GLOBAL_PROPERTIES,
)
#: Seconds on top of what the questions may take: start of Python, compiled kernels, reading.
GRACE = 5.0
WATCH_SECONDS = 0.1
#: How many times its processor time a process may last.
PATIENCE = 20
Expected = dict[str, dict[str, dict[str, Any]]]


def main(arguments: list[str] | None = None) -> int:
    """Run what was not run yet, print the tables; 1 where an answer is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument(
        "--seconds", type=float, default=30.0, help="of processor time for each question (30)"
    )
    parser.add_argument("--memory", type=float, default=4.0, help="GiB for each process (4)")
    parser.add_argument("--nets", nargs="+", help="words in the names of nets; all by default")
    parser.add_argument("--examinations", nargs="+", choices=EXAMINATIONS, default=list(EXAMINATIONS))
    parser.add_argument("--results", type=Path, default=Path("build/contest.jsonl"))
    given = parser.parse_args(arguments)
    expected: Expected = json.loads((given.folder / "expected.json").read_text())
    given.results.parent.mkdir(parents=True, exist_ok=True)
    known = list(records(given.results))
    done = {(record["net"], record["examination"]) for record in known}
    chosen = [name for name in expected if not given.nets or any(word in name for word in given.nets)]
    for number, name in enumerate(chosen, 1):
        todo = [e for e in given.examinations if (name, e) not in done and expected[name].get(e)]
        counted, asked = [e for e in todo if e == "StateSpace"], [e for e in todo if e != "StateSpace"]
        for group in filter(None, (counted, asked)):
            print(f"{number}/{len(chosen)} {name}: {', '.join(group)}", file=sys.stderr)
            new = run(given.folder, name, group, expected[name], given.seconds, int(given.memory * 2**30))
            known += new
            with given.results.open("a") as file:
                file.writelines(json.dumps(record) + "\n" for record in new)
    shown = [r for r in known if r["net"] in set(chosen) and r["examination"] in set(given.examinations)]
    return 1 if print_tables(shown) else 0


def records(path: Path) -> Iterator[dict[str, Any]]:
    """Return the records of earlier runs."""
    if path.exists():
        yield from map(json.loads, path.read_text().splitlines())


def run(
    folder: Path,
    name: str,
    examinations: Sequence[str],
    expected: dict[str, dict[str, Any]],
    seconds: float,
    memory: int,
) -> list[dict[str, Any]]:
    """Run some examinations of a net; return a record for every verdict that is known."""
    questions = sum(len(expected[e]) if e != "StateSpace" else 1 for e in examinations)
    with tempfile.TemporaryDirectory() as place:
        unpack(folder / "nets" / f"{name}.tgz", Path(place))
        program = str(Path(__file__).with_name("answer_one.py"))
        command = [sys.executable, "-P", program, f"{place}/{name}"]
        command += ["--examinations", *examinations, "--seconds", str(seconds), "--memory", str(memory)]
        began = os.times()
        answers, ended = _watched(command, seconds * questions + GRACE, memory)
        used = os.times()
    processor = used.children_user + used.children_system - began.children_user - began.children_system
    share = {"processor": round(processor / questions, 3), "budget": seconds, "ended": ended}
    found = {(answer["examination"], answer["id"]): answer for answer in answers}
    result = []
    for examination in examinations:
        for id, verdict in expected[examination].items():
            answer = found.get((examination, id), {})
            value = answer.get("value")
            outcome = "unknown" if value is None else "right" if value == verdict else "wrong"
            record: dict[str, Any] = {"net": name, "examination": examination, "id": id, "outcome": outcome}
            record |= {"value": value, "expected": verdict, "seconds": answer.get("seconds")}
            result.append({**record, "technique": answer.get("technique", ""), **share})
    return result


def _watched(command: list[str], seconds: float, memory: int) -> tuple[list[dict[str, Any]], str]:
    """Run a command within time and memory; return what it said, and how it ended."""
    answers: list[dict[str, Any]] = []
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    lines = process.stdout

    def listen() -> None:
        answers.extend(json.loads(line) for line in lines if line.endswith("}\n"))

    reader = threading.Thread(target=listen)
    reader.start()
    until, ended = time.monotonic() + PATIENCE * seconds, ""
    while not ended:
        try:
            status = process.wait(WATCH_SECONDS)
            ended = "done" if status == 0 else f"status {status}"
        except subprocess.TimeoutExpired:
            with suppress(OSError, IndexError):  # it has just ended
                if processor_seconds(process.pid) > seconds or time.monotonic() > until:
                    ended = "time"
                elif mebibytes(process.pid) * 2**20 > memory:
                    ended = "memory"
    process.kill()
    process.wait()
    reader.join()
    return answers, ended


if __name__ == "__main__":
    sys.exit(main())
