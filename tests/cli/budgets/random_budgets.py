"""Are budgets promises? Random commands with random ``--timeout`` and ``--memory``, measured from outside.

``python -m tests.cli.budgets.random_budgets 200 --seed 1`` prints a line for each run that breaks a promise,
and last the worst of all. A run is outside the promise that takes more than 1.1 times its time (or half a
second more), has more memory than it may (all its processes together, pages that they share counted once),
leaves a process behind, or ends in another way than with an answer or as unknown. With ``--nets FOLDER`` nets
of the Model Checking Contest are among the models (``NAME.tgz``, as of `benchmarks.contest`). With
``--cluster`` half of `check`, `find` and `verify` ask the workers of a Dask scheduler on this machine; what
these take of memory is theirs, but what is asked of them ends with the command. TINA's programs are there,
and sleep.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.contest.archives import unpack

ROOT = Path(__file__).resolve().parents[3]
MIB = 1 << 20
SLACK_SECONDS, SLACK_PART = 0.5, 0.1
LOOK_SECONDS = 0.02


@dataclass(frozen=True)
class Ran:
    """What was promised to one run, and what it took."""

    arguments: tuple[str, ...]
    seconds: float
    memory: int
    status: int
    took: float
    peak: int
    left_behind: int
    printed: str

    @property
    def faults(self) -> list[str]:
        """What is outside the promise."""
        found = []
        if self.took > self.seconds + max(self.seconds * SLACK_PART, SLACK_SECONDS):
            found.append(f"{self.took:.1f} s")
        if self.peak > self.memory:
            found.append(f"{self.peak / MIB:.0f} MiB")
        if self.left_behind:
            found.append(f"{self.left_behind} processes left")
        if self.status not in (0, 1, 3) or "Traceback" in self.printed or not self.printed:
            found.append(f"exit status {self.status}")
        return found

    def __str__(self) -> str:
        promised = f"--timeout {self.seconds:.2f} --memory {self.memory // MIB}M"
        took = f"{self.took:.1f} s, {self.peak / MIB:.0f} MiB, exit status {self.status}"
        return f"{' '.join(self.arguments)} {promised}: {took}"


def philosophers(number: int, shuffled: random.Random | None = None) -> str:
    """Return a ring of philosophers, in a random order of its transitions if told so."""
    lines = []
    for i in range(number):
        right = (i + 1) % number
        lines += [
            f"tr left{i} think{i} fork{i} -> has{i}",
            f"tr right{i} has{i} fork{right} -> eat{i}",
            f"tr put{i} eat{i} -> think{i} fork{i} fork{right}",
        ]
    if shuffled is not None:
        shuffled.shuffle(lines)
    places = [f"pl think{i} (1)\npl fork{i} (1)" for i in range(number)]
    return "\n".join(["net philosophers", *places, *lines, ""])


def chain(length: int, tokens: int) -> str:
    """Return tokens that go along a chain of places: as many markings as combinations."""
    steps = [f"tr t{i} p{i} -> p{i + 1}" for i in range(length)]
    return "\n".join(["net chain", f"pl p0 ({tokens})", *steps, ""])


def tangle(draw: random.Random, places: int, transitions: int) -> str:
    """Return a net of random arcs; most have no bound."""
    some = [f"p{i}" for i in range(places)]
    lines = [f"pl {p} ({draw.randint(0, 2)})" for p in some]
    for t in range(transitions):
        before, after = (draw.sample(some, draw.randint(1, 3)) for _ in range(2))
        lines.append(f"tr t{t} {' '.join(before)} -> {' '.join(after)}")
    return "\n".join(["net tangle", *lines, ""])


def with_sleeping_tina(folder: Path) -> str:
    """Return a PATH on which TINA's programs come first, which never answer and ignore what is gentle."""
    for name in ("tina", "sift", "selt", "pathto"):
        program = folder / "bin" / name
        program.parent.mkdir(exist_ok=True)
        program.write_text("#!/bin/sh\ntrap '' TERM INT\nsleep 600 &\nwait\n", encoding="utf-8")
        program.chmod(0o755)
    return f"{folder / 'bin'}{os.pathsep}{os.environ['PATH']}"


def traced(folder: Path) -> Path:
    """Return the traces of a simulated run of the case study, recorded once."""
    made = folder / "traces"
    if not made.is_dir():
        model = str(ROOT / "case_study/sorting.sym.xmi")
        end = ["--until", "Shown >= 3", "--timeout", "5"]
        command = [sys.executable, "-m", "dineros.cli.main", "run", model, "--simulate", "--seed", "1", *end]
        subprocess.run([*command, "--trace", str(made)], check=False, capture_output=True)
    return made


def commands(draw: random.Random, folder: Path, contest: Path | None = None) -> Iterator[tuple[str, ...]]:
    """Yield commands without end."""
    archives = sorted(contest.glob("*.tgz")) if contest else []
    number = 0
    while True:
        number += 1
        net = folder / f"{number}.net"
        match draw.randrange(7 if archives else 6):
            case 5:
                yield ("conform", str(ROOT / "case_study/sorting.sym.xmi"), str(traced(folder)))
                continue
            case 6:
                archive = draw.choice(archives)
                unpack(archive, folder)
                net = folder / archive.stem / "model.pnml"
                deadlock = ("verify", str(net), "--properties", "ReachabilityDeadlock")
                yield draw.choice([("check", str(net)), ("statespace", str(net)), deadlock])
                continue
            case 0:
                net.write_text(philosophers(draw.choice([5, 30, 100, 400]), draw), encoding="utf-8")
                place, transition = "eat0", "put0"
            case 1:
                length, tokens = draw.choice([3, 20, 200]), draw.choice([5, 100, 2000])
                net.write_text(chain(length, tokens), encoding="utf-8")
                place, transition = "p2", "t1"
            case 2 | 3:
                size = draw.choice([10, 40, 150, 600])
                net.write_text(tangle(draw, size, size + draw.randint(0, size)), encoding="utf-8")
                place, transition = "p0", "t0"
            case _:
                net = ROOT / "case_study/sorting.sym.xmi"
                place, transition = "Shown", "TShowResult"
        settings = []
        if net.suffix == ".xmi":
            objects = draw.randint(1, 6)
            settings = [f"--set={color}Objects.tokens={objects}" for color in ("Red", "Blue", "Green")]
            if draw.random() < 0.2:
                yield ("check", str(net), "--suggest-capacities", *settings)
                continue
        few = draw.randint(1, 3)
        yield draw.choice(
            [
                ("check", str(net), *settings),
                ("check", str(net), "--format", draw.choice(["json", "sarif", "junit"]), *settings),
                ("check", str(net), "-o", str(folder / f"{number}.html"), *settings),
                ("statespace", str(net), "--engine", draw.choice(["auto", "explicit"]), *settings),
                ("statespace", str(net), "--json", *settings),
                ("find", str(net), "--enabled", transition, *settings),
                ("find", str(net), "--marking", f"{place} >= {few}", *settings),
                ("verify", str(net), "--ltl", f"G F {place} >= {few}", *settings),
                ("verify", str(net), "--ctl", f"AG EF {place} >= {few}", "--json", *settings),
                ("verify", str(net), "--properties", "ReachabilityDeadlock", *settings),
                ("reduce", str(net), "-o", str(folder / f"{number}.out.net"), *settings),
                ("find", str(net), "--marking", f"{place} >= {few}", "--engine", "tina", *settings),
                ("verify", str(net), "--ltl", f"G F {place} >= {few}", "--engine", "tina", *settings),
                ("statespace", str(net), "--engine", "tina", *settings),
                *(
                    [("sweep", str(net), f"--vary={place}.tokens=0..5", "-o", str(folder / f"{number}.csv"))]
                    if number % 2
                    else []
                ),
            ]
        )


def measured(arguments: Sequence[str], seconds: float, memory: int, path: str) -> Ran:
    """Run a command with a promise, and a PATH, and measure what it takes."""
    promise = [f"--timeout={seconds}", f"--memory={memory}"]
    command = [sys.executable, "-m", "dineros.cli.main", *arguments, *promise]
    with tempfile.TemporaryFile("w+", encoding="utf-8") as printed:
        began = time.monotonic()
        process = subprocess.Popen(
            command, stdout=printed, stderr=printed, start_new_session=True, env=os.environ | {"PATH": path}
        )
        peak, seen = 0, {process.pid}
        while process.poll() is None:
            tree = descendants(process.pid)
            seen |= set(tree)
            peak = max(peak, sum(map(taken, tree)))
            time.sleep(LOOK_SECONDS)
        took = time.monotonic() - began
        printed.seek(0)
        text = printed.read()
    left = sum(is_running(one) for one in seen)
    return Ran(tuple(arguments), seconds, memory, process.returncode, took, peak, left, text)


def descendants(process: int) -> list[int]:
    """Return a process and all that it started."""
    parents: dict[int, int] = {}
    for folder in Path("/proc").iterdir():
        if folder.name.isdigit():
            with contextlib.suppress(OSError, IndexError):
                words = (folder / "stat").read_bytes().rpartition(b")")[2].split()
                parents[int(folder.name)] = int(words[1])
    tree = [process]
    for one in tree:
        tree += [child for child, parent in parents.items() if parent == one]
    return tree


def taken(process: int) -> int:
    """Return the bytes a process has in memory, of shared pages its part."""
    with contextlib.suppress(OSError, IndexError):
        for line in Path(f"/proc/{process}/smaps_rollup").read_bytes().splitlines():
            if line.startswith(b"Pss:"):
                return int(line.split()[1]) * 1024
    return 0


def is_running(process: int) -> bool:
    """Tell whether a process still runs, a moment later at the latest."""
    for _ in range(50):
        try:
            state = Path(f"/proc/{process}/stat").read_bytes().rpartition(b")")[2].split()[0]
        except OSError:
            return False
        if state in (b"Z", b"X"):
            return False
        time.sleep(0.01)
    return True


@contextlib.contextmanager
def cluster() -> Iterator[str]:
    """Yield the address of a Dask scheduler with two workers on this machine."""
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as started:
        yield str(started.scheduler_address)


def random_runs(
    number: int,
    seed: int,
    most_seconds: float = 8.0,
    contest: Path | None = None,
    scheduler: str | None = None,
) -> Iterator[Ran]:
    """Yield measured runs; of a scheduler's address, half of the questions go there."""
    draw = random.Random(seed)
    with tempfile.TemporaryDirectory() as name:
        path = with_sleeping_tina(Path(name))
        for arguments, _ in zip(commands(draw, Path(name), contest), range(number), strict=False):
            seconds = 0.3 * (most_seconds / 0.3) ** draw.random()
            here = ("--suggest-capacities", "tina")
            asks = arguments[0] in ("check", "find", "verify") and not any(one in arguments for one in here)
            there = () if scheduler is None or not asks or draw.random() < 0.5 else ("--scheduler", scheduler)
            least = 800 if arguments[0] == "sweep" or ".html" in " ".join(arguments) else 322
            yield measured((*arguments, *there), seconds, int(least * 4 ** draw.random() ** 3) * MIB, path)


def main() -> int:
    """Run as many as asked for."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument("number", type=int)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--nets", type=Path, help="folder of nets of the Model Checking Contest")
    parser.add_argument("--cluster", action="store_true", help="ask the workers of a Dask scheduler, too")
    parser.add_argument("-v", action="store_true", help="print every run")
    chosen = parser.parse_args()
    os.environ["DINEROS_QUIET_COMPILATION"] = "1"
    with cluster() if chosen.cluster else contextlib.nullcontext(None) as address:
        return report(
            random_runs(chosen.number, chosen.seed, contest=chosen.nets, scheduler=address), chosen.v
        )


def report(measured_runs: Iterator[Ran], is_verbose: bool) -> int:
    """Print what is outside the promise, and the worst of all; 1 where something is."""
    runs, outside = 0, 0
    latest = fullest = -1e9
    statuses: dict[int, int] = {}
    for run in measured_runs:
        runs += 1
        outside += bool(run.faults)
        latest = max(latest, run.took - run.seconds * (1 + SLACK_PART))
        fullest = max(fullest, run.peak / run.memory)
        statuses[run.status] = statuses.get(run.status, 0) + 1
        if run.faults or is_verbose:
            print(f"{'OUTSIDE ' + ', '.join(run.faults) if run.faults else 'kept'}: {run}", flush=True)
            if run.faults:
                print(run.printed[-500:], flush=True)
    ends = ", ".join(f"{number} with status {status}" for status, number in sorted(statuses.items()))
    print(f"{runs} runs, {outside} outside the promise ({ends})")
    print(f"the latest {latest:.2f} s after 1.1 times its time, where 2 s are allowed")
    print(f"the fullest with {fullest:.0%} of its memory")
    return bool(outside)


if __name__ == "__main__":
    sys.exit(main())
