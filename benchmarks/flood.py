"""Memory, disk and file descriptors of the case study under a flood of messages, over time.

``python benchmarks/flood.py --hours 1 -o flood`` runs all nodes of the case study in real time, each on a
thread of this process, with a safety loop that asks the sensor as fast as the rate allows. All is recorded.
It writes ``flood.csv`` (a line every few seconds) and ``flood.svg``, and replays on the model what is kept of
the traces. The three must stay flat, disk once the parts that are kept are full.
"""

from __future__ import annotations

import argparse
import csv
import gc
import os
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import NamedTuple

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.metamodel.settings import apply
from dineros.runtime.journal import JournalRecorder
from dineros.runtime.simulation import LocalApplication
from dineros.transformations.flattening.split import split

MODEL = Path(__file__).resolve().parents[1] / "case_study" / "sorting.sym.xmi"
COLORS = ("Red", "Blue", "Green")


class Sample(NamedTuple):
    """What was used at a moment.

    Attributes
    ----------
    seconds : float
        Since the start.
    firings, messages : int
        Made so far; a request or a response is a message.
    memory, disk : float
        MiB: resident memory, and all files of the run.
    descriptors : int
        Open files of the process.
    """

    seconds: float
    firings: int
    messages: int
    memory: float
    disk: float
    descriptors: int


def flooded() -> sym.SystemModel:
    """Return the case study without waiting: the safety loop has no pace of its own."""
    model = load(MODEL)
    assert isinstance(model, sym.SystemModel)
    for setting in ("TRetry.interval.earliest=0", "TSense.interval.earliest=0"):
        apply(model, setting)
    return model


def measure(process: int, folder: Path) -> tuple[float, float, int]:
    """Return memory and disk in MiB, and the number of open files."""
    pages = int(Path(f"/proc/{process}/statm").read_text().split()[1])
    memory = pages * os.sysconf("SC_PAGE_SIZE") / 2**20
    disk = 0
    for path in folder.rglob("*"):
        try:
            disk += path.stat().st_size
        except FileNotFoundError:  # pruned meanwhile
            continue
    return memory, disk / 2**20, len(list(Path(f"/proc/{process}/fd").iterdir()))


def flood(
    seconds: float, rate: float, every: float, folder: Path, kept_parts: int, part_bytes: int
) -> Iterator[Sample]:
    """Run the flooded case study and yield what it uses.

    Parameters
    ----------
    seconds : float
        How long.
    rate : float
        Messages a second, about; the sensor is asked so often.
    every : float
        Seconds between two samples.
    folder : Path
        Takes the journals.
    kept_parts, part_bytes : int
        As for `JournalRecorder`.
    """
    recorder = partial(JournalRecorder, folder, kept_parts=kept_parts, part_bytes=part_bytes)
    application = LocalApplication(split(flooded()), seed=1, recorder=recorder, simulated_time=False)
    counts = {"fire": 0, "message": 0}

    def count(event: str) -> None:
        if event == "fire":
            counts["fire"] += 1
        elif event in ("publish", "request", "response"):
            counts["message"] += 1

    for net in application.nets.values():
        net.on_change(lambda change: count(change.event))
    application.nets["sensorics"].signal("Sensor").set(True)
    executor = application.nets["executor"]
    for signal in ("RobotIsIdle", "ObjectIsPicked", "ObjectIsPlaced"):
        executor.signal(signal).set(True)
    executor.selection(lambda enabled: enabled.named("TUnsafe") or enabled.random())
    executor.handler("TRetry")(pace(rate / 2))  # a request and a response
    started = time.monotonic()
    with application:
        for color in COLORS:
            application.nets["selector"].signal(color).set(True)
        while (now := time.monotonic() - started) < seconds:
            time.sleep(min(every, seconds - now))
            gc.collect()
            memory, disk, descriptors = measure(os.getpid(), folder)
            passed = time.monotonic() - started
            yield Sample(passed, counts["fire"], counts["message"], memory, disk, descriptors)


def pace(rate: float) -> Callable[[object], None]:
    """Return a handler that lets its transition fire so often a second, at most."""
    due = time.monotonic()

    def wait(_: object) -> None:
        nonlocal due
        due = max(due + 1 / rate, time.monotonic() - 0.1)
        time.sleep(max(0.0, due - time.monotonic()))

    return wait


def draw(samples: list[Sample], path: Path) -> None:
    """Draw memory, disk and descriptors over time, as SVG."""
    width, height, left, gap = 640, 110, 70, 34
    rows = [("memory / MiB", "memory"), ("disk / MiB", "disk"), ("open files", "descriptors")]
    end = max(sample.seconds for sample in samples)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{left + width + 20}" '
        f'height="{len(rows) * (height + gap) + 30}" font-family="sans-serif" font-size="12">',
        '<rect width="100%" height="100%" fill="white"/>',
    ]
    for row, (title, name) in enumerate(rows):
        top = 24 + row * (height + gap)
        values = [float(getattr(sample, name)) for sample in samples]
        most = max([*values, 1.0]) * 1.1
        points = " ".join(
            f"{left + width * sample.seconds / end:.1f},{top + height * (1 - value / most):.1f}"
            for sample, value in zip(samples, values, strict=True)
        )
        parts += [
            f'<text x="{left}" y="{top - 7}">{title}</text>',
            f'<rect x="{left}" y="{top}" width="{width}" height="{height}" fill="none" stroke="#999"/>',
            f'<text x="{left - 6}" y="{top + 10}" text-anchor="end">{most:.0f}</text>',
            f'<text x="{left - 6}" y="{top + height}" text-anchor="end">0</text>',
            f'<polyline points="{points}" fill="none" stroke="#1f5fa8" stroke-width="1.5"/>',
        ]
    bottom = 24 + len(rows) * (height + gap) - gap + 16
    parts += [
        f'<text x="{left}" y="{bottom}">0</text>',
        f'<text x="{left + width}" y="{bottom}" text-anchor="end">{end / 60:.0f} min</text>',
        "</svg>",
    ]
    path.write_text("\n".join(parts) + "\n", encoding="utf-8")


def main() -> int:
    """Flood, measure, draw."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--hours", type=float, default=1.0)
    parser.add_argument("--rate", type=float, default=200.0, help="messages a second, about")
    parser.add_argument("--every", type=float, default=10.0, help="seconds between two samples")
    parser.add_argument("--kept-parts", type=int, default=8, help="parts of each journal that are kept")
    parser.add_argument("--part-mib", type=float, default=16.0, help="size of a part")
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
        size = int(options.part_mib * 2**20)
        for sample in flood(
            3600 * options.hours, options.rate, options.every, folder, options.kept_parts, size
        ):
            samples.append(sample)
            writer.writerow([round(value, 2) for value in sample])
            table.flush()
        paths = traces_of_runs([folder])
        verdict = conform(flooded(), {node: partial(read_trace, parts) for node, parts in paths.items()})
        print(f"conformance: {verdict.status}, {verdict.steps} steps replayed")
    draw(samples, options.output.with_suffix(".svg"))
    last = samples[-1]
    half = samples[len(samples) // 2]
    rate = last.messages / last.seconds
    print(f"{last.seconds:.0f} s, {last.messages} messages ({rate:.0f} a second), {last.firings} firings")
    for name in ("memory", "disk", "descriptors"):
        print(f"{name}: {getattr(half, name):.1f} at half time, {getattr(last, name):.1f} at the end")
    return 0 if verdict.status == "conforms" else 1


if __name__ == "__main__":
    sys.exit(main())
