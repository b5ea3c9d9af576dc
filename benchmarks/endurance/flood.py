"""Memory, disk and file descriptors of the running case study under a flood of messages, over time.

``python -m benchmarks.endurance.flood --hours 1 -o flood`` runs the workspace of the case study on ROS 2,
one process per node, with a safety loop that asks the sensor as fast as the rate allows, while a human
walks in and out without end. All is recorded. It writes ``flood.csv`` (a line every few seconds) and
``flood.svg``, and replays on the model what is kept of the traces. The three must stay flat, disk once the
parts that are kept are full. With ``--stranger RATE``, another program publishes so many messages a second on
a topic that a node reads.
"""

from __future__ import annotations

import argparse
import csv
import json
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from benchmarks._processes import mebibytes
from benchmarks.endurance.applications import APPLICATIONS
from dineros.analysis.conformance import conform
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.metamodel.records.files import parts_of
from dineros.runtime.ros.process.domains import claimed_domain

SORTING = APPLICATIONS["sorting"]
#: The safety loop without a pace of its own.
SETTINGS = ("TRetry.interval.earliest=0", "TSense.interval.earliest=0")
PATIENCE = 300.0
#: The node that reads what the stranger publishes.
READER = "feedback"
#: The end of a trace in which the number of the last request is looked for.
TAIL_BYTES = 1 << 16


class Sample(NamedTuple):
    """What was used at a moment.

    Attributes
    ----------
    seconds : float
        Since the nodes are there.
    messages : int
        Requests and responses of the safety loop so far.
    records : int
        What the node that reads the stranger's topic has recorded: each message is taken, or dropped.
    memory : float
        Anonymous memory of all processes, MiB: pages of files come and go as others on the machine need room.
    executor, reader, supervisor : float
        That of the node with the loop, of the node that reads from the stranger, and of the supervisor, MiB.
    disk : float
        All files of the run, MiB.
    descriptors : int
        Open files of all processes.
    """

    seconds: float
    messages: int
    records: int
    memory: float
    executor: float
    reader: float
    supervisor: float
    disk: float
    descriptors: int


class FloodError(Exception):
    """The application does not run."""


def flood(
    seconds: float, rate: float, every: float, folder: Path, domain: int, stranger: float = 0.0
) -> Iterator[Sample]:
    """Run the flooded case study and yield what it uses.

    Parameters
    ----------
    seconds : float
        How long.
    rate : float
        Messages a second, about: the sensor is asked half as often, and answers.
    every : float
        Seconds between two samples.
    folder : Path
        Takes the workspace and the traces.
    domain : int
        ROS domain.
    stranger : float
        Messages a second that another program publishes.

    Raises
    ------
    FloodError
        The application ended, or did not begin.
    """
    workspace, traces = folder / "workspace", folder / "traces"
    SORTING.workspace(workspace, SETTINGS)
    handlers = workspace / "src/sorting_executor/sorting_executor/handlers.py"
    text = handlers.read_text(encoding="utf-8")
    if "\nPAUSE = 0.2 " not in text:
        raise FloodError(f"{handlers}: the pause of the safety loop is not where it was")
    handlers.write_text(text.replace("\nPAUSE = 0.2 ", f"\nPAUSE = {2 / rate} "), encoding="utf-8")
    command = [sys.executable, "-P", "-m", "dineros.cli.main", "run", str(workspace), "--trace", str(traces)]
    command += ["--domain", str(domain), "--reach", "memory", "--restarts", "0"]
    command += ["--with", f"python {Path(__file__).with_name('world.py').resolve()}"]
    if stranger:
        command += ["--with", f"python {Path(__file__).with_name('stranger.py').resolve()} {stranger}"]
    log = folder / "run.log"
    with log.open("wb") as file:
        run = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=file, stderr=file)
    try:
        _await_messages(run, traces, log)
        started, first = time.monotonic(), _calls(traces)
        while (now := time.monotonic() - started) < seconds:
            time.sleep(min(every, seconds - now))
            if run.poll() is not None:
                raise FloodError(log.read_text(encoding="utf-8"))
            messages = 2 * (_calls(traces) - first)
            used = _measure(run.pid, traces)
            yield Sample(time.monotonic() - started, messages, _reader_records(traces), *used)
    finally:
        run.send_signal(signal.SIGINT)
        run.wait(PATIENCE)


def _await_messages(run: subprocess.Popen[bytes], traces: Path, log: Path) -> None:
    """Wait until the loop turns; interfaces may have to be built before."""
    end = time.monotonic() + PATIENCE
    while not _calls(traces):
        if run.poll() is not None or time.monotonic() > end:
            raise FloodError(log.read_text(encoding="utf-8"))
        time.sleep(0.1)


def _calls(traces: Path) -> int:
    """Return how often the sensor was asked, by the number of the last request."""
    for record in _latest_records(traces, "executor"):
        if record["event"] == "request":
            return int(record["message"].rpartition("/")[2])
    return 0


def _reader_records(traces: Path) -> int:
    """Return the number of the reader's latest record."""
    return next((int(record["sequence"]) for record in _latest_records(traces, READER)), 0)


def _latest_records(traces: Path, node: str) -> Iterator[dict[str, Any]]:
    """Yield the records at the end of each part of a node's trace, the latest first."""
    for path in reversed(parts_of(traces, node)) if traces.is_dir() else ():
        try:
            with path.open("rb") as file:
                file.seek(max(0, path.stat().st_size - TAIL_BYTES))
                lines = file.read().splitlines()
        except FileNotFoundError:  # renamed or pruned meanwhile
            continue
        for line in reversed(lines):
            with suppress(ValueError):
                yield json.loads(line)


def _measure(supervisor: int, traces: Path) -> tuple[float, float, float, float, float, int]:
    """Return memory of all, of executor, reader and supervisor, disk in MiB, and open files."""
    processes = {supervisor: "supervisor"}
    for line in (traces / "supervisor.log.jsonl").read_text("utf-8").splitlines():
        event = json.loads(line)
        if event["event"] == "started":
            processes[event["process"]] = event["name"]
    memory: Mapping[str, float] = {name: mebibytes(process, "RssAnon") for process, name in processes.items()}
    disk = 0
    for path in traces.rglob("*"):
        with suppress(FileNotFoundError):  # pruned meanwhile
            disk += path.stat().st_size
    descriptors = sum(len(list(Path(f"/proc/{process}/fd").iterdir())) for process in processes)
    own = memory["executor"], memory[READER], memory["supervisor"]
    return sum(memory.values()), *own, disk / 2**20, descriptors


def draw(samples: list[Sample], path: Path) -> None:
    """Draw memory, disk and open files over time."""
    from matplotlib import rc_context
    from matplotlib.figure import Figure

    panels = [
        ("memory (MiB)", "memory"),
        ("journals (MiB)", "disk"),
        ("open files", "descriptors"),
    ]
    figure = Figure(figsize=(7.2, 5.0), layout="constrained")
    for panel, (title, name) in zip(figure.subplots(len(panels), sharex=True), panels, strict=True):
        values = [getattr(sample, name) for sample in samples]
        panel.plot([sample.seconds / 60 for sample in samples], values)
        panel.set(ylabel=title, ylim=(0, 1.15 * max(values)))
        panel.grid(alpha=0.3)
    panel.set_xlabel("minutes")
    with rc_context({"svg.fonttype": "none", "svg.hashsalt": "dineros"}):
        figure.savefig(path, metadata={"Date": None})


def main() -> int:
    """Flood, measure, draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--rate", type=float, default=200.0, help="messages a second, about")
    parser.add_argument("--stranger", type=float, default=0.0, help="messages a second of another program")
    parser.add_argument("--every", type=float, default=10.0, help="seconds between two samples")
    parser.add_argument("-o", "--output", type=Path, default=Path("flood"), help="name without its suffix")
    options = parser.parse_args()
    samples: list[Sample] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="dineros-flood-")))
        table = stack.enter_context(
            options.output.with_suffix(".csv").open("w", newline="", encoding="utf-8")
        )
        writer = csv.writer(table)
        writer.writerow(Sample._fields)
        domain = stack.enter_context(claimed_domain())
        seconds = 3600 * options.hours
        for sample in flood(seconds, options.rate, options.every, folder, domain, options.stranger):
            samples.append(sample)
            writer.writerow([round(value, 2) for value in sample])
            table.flush()
        conforms = bool(options.stranger)  # what a stranger publishes is not in the model
        if not conforms:
            paths = traces_of_runs([folder / "traces"])
            kept = {node: partial(read_trace, parts) for node, parts in paths.items()}
            verdict = conform(SORTING.model_with(SETTINGS), kept)
            print(f"conformance: {verdict.status}, {verdict.steps} steps replayed")
            conforms = verdict.status == "conforms"
    draw(samples, options.output.with_suffix(".svg"))
    last, half = samples[-1], samples[len(samples) // 2]
    print(f"{last.seconds:.0f} s, {last.messages} messages ({last.messages / last.seconds:.0f} a second)")
    for name in Sample._fields[2:]:
        print(f"{name}: {getattr(half, name):.1f} at half time, {getattr(last, name):.1f} at the end")
    return 0 if conforms else 1


if __name__ == "__main__":
    sys.exit(main())
