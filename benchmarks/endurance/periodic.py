"""Memory of the commonest ROS program over time: a timer that publishes, and a logger, too slow for it.

``python -m benchmarks.endurance.periodic --seconds 3600 -o periodic.csv`` runs both nodes on ROS 2 under its
rules, a process each. The logger takes longer than the period, so that all queues are full all the time and
lose messages. It prints the resident memory of both processes every now and then, and at the end by how much
it grew an hour (least squares, without the first tenth), of all of it and of what is not a page of a file:
those come and go as others on the machine need room. `-o` writes the figures as CSV. With ``--journal`` both
record what they do, and what is kept of that is replayed on the model.
"""

from __future__ import annotations

import argparse
import csv
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from statistics import linear_regression
from typing import NamedTuple

from benchmarks._processes import mebibytes, processor_seconds
from dineros.analysis.conformance import Verdict, conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.transformations.flattening.split import split

LIMIT = 1.0
"""MiB an hour by which the anonymous memory of a process may grow, and noise."""
LONG = 3000.0
"""Seconds after which that is judged."""
WARMING = 0.1
"""Share of the time that is not fitted: buffers fill."""
PATIENCE = 60.0
NODES = "talker", "logger"
HANDLERS = """
import logging
import time
LOG = logging.getLogger("dineros.logger")
def configure(net):
    @net.handler("Log", thread=True)
    def log(firing):
        LOG.debug("heard %s", firing.data["text"])
        time.sleep({slowness})
"""


class Sample(NamedTuple):
    """What the processes use at a moment.

    Attributes
    ----------
    seconds : float
        Since both are there.
    talker, logger : float
        Resident memory, MiB.
    talker_anonymous, logger_anonymous : float
        What of it is not a page of a file.
    processor : float
        Processor time of both so far, seconds.
    """

    seconds: float
    talker: float
    logger: float
    talker_anonymous: float
    logger_anonymous: float
    processor: float


class PeriodicError(Exception):
    """A node does not run."""


def model(period: float, depth: int = 10) -> sym.SystemModel:
    """Return a timer that publishes a text each period, and a logger."""
    made = sym.SystemModel(id="periodic", middleware="ros2")
    made.tokenType = sym.TokenType(id="Line", fields=[sym.TokenField(name="text", default='"tick"')])
    talker, logger = (sym.NodeNet(id=name, net=made) for name in NODES)
    timer = sym.CallbackPage(id="OnTimer", kind="timer", timer=period, page=talker)
    said = sym.Place(id="Said", page=timer)
    flow(sym.Transition(id="Tick", page=timer), said)
    heard = sym.Place(id="Heard", page=logger)
    flow(heard, sym.Transition(id="Log", page=logger))
    made.channels.append(
        sym.TopicChannel(
            id="Talk",
            topic="/talk",
            type="std_msgs/msg/String",
            mappings=[sym.FieldMapping(part="message", messageField="data", tokenField="text")],
            publishers=[sym.PublisherPort(place=said, limit=depth)],
            subscribers=[sym.SubscriberPort(place=heard, limit=depth)],
        )
    )
    return made


def run(
    seconds: float, every: float, period: float, slowness: float, folder: Path, domain: int, *, journal: bool
) -> Iterator[Sample]:
    """Run both nodes and yield what they use.

    Parameters
    ----------
    seconds : float
        How long.
    every : float
        Seconds between two samples.
    period, slowness : float
        Seconds between two messages, and what the logger takes for one.
    folder : Path
        Takes models, handlers and logs.
    domain : int
        ROS domain.
    journal : bool
        Whether the nodes record.

    Raises
    ------
    PeriodicError
        A node ended, or did not begin.
    """
    for part in split(model(period)):
        assert part.node is not None
        save(part, folder / f"{part.node.id}.rtm.xmi")
    (folder / "handlers.py").write_text(HANDLERS.format(slowness=slowness), encoding="utf-8")
    processes: dict[str, subprocess.Popen[bytes]] = {}
    environment = ros_environment(folder, domain)
    try:
        for name in NODES:
            command = [sys.executable, "-P", "-m", "dineros.runtime.ros.node_main", f"{name}.rtm.xmi"]
            command += ["--handlers", "handlers.py"] if name == "logger" else []
            command += ["--ros-args", "-p", "journal:=journal"] if journal else []
            with (folder / f"{name}.log").open("wb") as log:
                processes[name] = subprocess.Popen(
                    command, cwd=folder, env=environment, stdin=subprocess.DEVNULL, stdout=log, stderr=log
                )
        time.sleep(min(5.0, seconds / 2))  # they start, and find each other
        started = time.monotonic()
        while (now := time.monotonic() - started) < seconds:
            time.sleep(min(every, seconds - now))
            for name, process in processes.items():
                if process.poll() is not None:
                    raise PeriodicError((folder / f"{name}.log").read_text(encoding="utf-8"))
            both = [processes[name].pid for name in NODES]
            memory = [mebibytes(process, name) for name in ("VmRSS", "RssAnon") for process in both]
            used = sum(map(processor_seconds, both))
            yield Sample._make([time.monotonic() - started, *memory, used])
    finally:
        for process in processes.values():
            process.send_signal(signal.SIGINT)
        for process in processes.values():
            process.wait(PATIENCE)


def replayed(period: float, folder: Path) -> Verdict:
    """Replay what a run with a journal has kept on the model."""
    paths = traces_of_runs([folder / "journal"])
    return conform(model(period), {node: partial(read_trace, parts) for node, parts in paths.items()})


def growth(samples: Sequence[Sample], name: str) -> float:
    """Return by how many MiB an hour something grows, without the time in which buffers fill."""
    fitted = samples[int(len(samples) * WARMING) :]
    hours = [sample.seconds / 3600 for sample in fitted]
    return linear_regression(hours, [getattr(sample, name) for sample in fitted]).slope


def main() -> int:
    """Run, print, fail where memory grows."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--seconds", type=float, default=3600.0)
    parser.add_argument("--every", type=float, default=10.0, help="seconds between two samples")
    parser.add_argument("--period", type=float, default=0.01, help="seconds between two messages")
    parser.add_argument("--slowness", type=float, default=0.025, help="seconds that the logger takes")
    parser.add_argument("--journal", action="store_true", help="record, and replay what is kept")
    parser.add_argument("-o", "--output", type=Path, help="a CSV file for the figures")
    options = parser.parse_args()
    samples: list[Sample] = []
    with ExitStack() as stack:
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="dineros-periodic-")))
        domain = stack.enter_context(claimed_domain())
        writer = None
        if options.output:
            table = stack.enter_context(options.output.open("w", newline="", encoding="utf-8"))
            writer = csv.writer(table)
            writer.writerow(Sample._fields)
        print(f"{'seconds':>8} {'talker':>8} {'logger':>8}  resident MiB", flush=True)
        times = options.seconds, options.every, options.period, options.slowness
        for sample in run(*times, folder, domain, journal=options.journal):
            samples.append(sample)
            print(f"{sample.seconds:8.0f} {sample.talker:8.2f} {sample.logger:8.2f}", flush=True)
            if writer is not None:
                writer.writerow([round(value, 3) for value in sample])
                table.flush()
        if options.journal:
            verdict = replayed(options.period, folder)
            print(f"conformance: {verdict.status}, {verdict.steps} steps replayed")
    worst = max(growth(samples, name) for name in Sample._fields[3:5])
    for name in Sample._fields[1:5]:
        least, most = (function(getattr(each, name) for each in samples) for function in (min, max))
        print(f"{name}: {least:.2f} to {most:.2f} MiB, {growth(samples, name):+.3f} MiB an hour")
    last = samples[-1]
    print(f"processor: {100 * last.processor / last.seconds:.1f} % of one core for both")
    if last.seconds >= LONG and worst > LIMIT:
        sys.exit(f"memory grows by more than {LIMIT:g} MiB an hour")
    return 0


if __name__ == "__main__":
    sys.exit(main())
