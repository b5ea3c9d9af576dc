"""Stops and kills a running application again and again, and looks whether a message was lost or came twice.

``python -m benchmarks.endurance.stops_and_kills sorting --stops 300`` runs the case study's workspace on
ROS 2, one process per node, with its simulated cell; ``fleet`` does so with the second application of the
guide, whose world blocks robots on their way, and ``mobile_robot`` with a robot that has goals, a managed
camera and best-effort sensors. At random moments it sends Ctrl-C, SIGTERM or SIGKILL to the
supervisor, or SIGTERM or SIGKILL to a node, and continues with ``--resume``. When all work is done, the
traces are checked: every message was taken once, every call has its four steps once, every goal was accepted
and ended once, every piece of work was done once, no queue dropped anything but that of a best-effort sensor
or of feedback, and the run conforms to the model.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from benchmarks.endurance.applications import APPLICATIONS, Application
from dineros.analysis.conformance import conform
from dineros.metamodel.records import (
    Accept,
    Drop,
    Finish,
    Goal,
    Outcome,
    Publish,
    Record,
    Reject,
    Reply,
    Request,
    Response,
    Serve,
    Take,
    node_traces,
    read_trace,
    traces_of_runs,
)
from dineros.runtime.journal import rebuild_at
from dineros.runtime.ros.process.domains import claimed_domain

KINDS = ("SIGINT", "SIGTERM", "SIGKILL", "node SIGTERM", "node SIGKILL")
PATIENCE = 60.0


class LostError(Exception):
    """Something is lost, came twice, or the run does not continue."""


@dataclass
class Round:
    """One run of the application, up to its last piece of work, over all its restarts.

    Attributes
    ----------
    application : Application
        What runs.
    folder : Path
        Takes traces and logs; next to it stands the workspace.
    pieces : int
        Pieces of work at each place where they wait.
    domain : int
        ROS domain.
    command : sequence of str
        What starts DiNeROS.
    """

    application: Application
    folder: Path
    pieces: int
    domain: int
    command: tuple[str, ...] = (sys.executable, "-P", "-m", "dineros.cli.main")
    process: subprocess.Popen[bytes] | None = None

    def __post_init__(self) -> None:
        self.folder.mkdir(parents=True)

    @property
    def workspace(self) -> Path:
        """Folder of the workspace, whose interfaces are built once for all rounds."""
        return self.folder.with_name("workspace")

    @property
    def traces(self) -> Path:
        """Folder of the traces."""
        return self.folder / "traces"

    @property
    def expected(self) -> int:
        """Pieces of work in all."""
        return self.pieces * len(self.application.work)

    def start(self) -> None:
        """Start the application, or continue."""
        options = ["--trace", str(self.traces), "--reach", "memory", "--domain", str(self.domain)]
        options += ["--until", f"{self.application.done} >= {self.expected}", "--restarts", "1000"]
        options += ["--with", self.application.beside]
        if self.traces.is_dir() and node_traces(self.traces):
            options.append("--resume")
        with (self.folder / "run.log").open("ab") as log:
            self.process = subprocess.Popen(
                [*self.command, "run", str(self.workspace), *options],
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=log,
            )

    def nodes(self) -> dict[str, int]:
        """Return the processes of nodes and programs that run, according to the supervisor."""
        running: dict[str, int] = {}
        with contextlib.suppress(FileNotFoundError):
            for line in (self.traces / "supervisor.log.jsonl").read_text("utf-8").splitlines():
                event = json.loads(line)
                if event["event"] in ("started", "restarted"):
                    running[event["name"]] = event["process"]
        return {name: process for name, process in running.items() if _is_there(process)}

    def await_nodes(self) -> None:
        """Wait until processes are there to be hit."""
        assert self.process is not None
        end = time.monotonic() + 5 * PATIENCE  # the first time, the interfaces are built
        while not self.nodes() and self.process.poll() is None and time.monotonic() < end:
            time.sleep(0.05)

    def run_for(self, seconds: float) -> bool:
        """Let it run; True: it has reached its end."""
        assert self.process is not None
        with contextlib.suppress(subprocess.TimeoutExpired):
            return self._has_reached(self.process.wait(seconds))
        return False

    def _has_reached(self, status: int) -> bool:
        if status != 0:
            raise LostError(f"the run ended with {status}: {self._last_lines()}")
        return True

    def _last_lines(self) -> str:
        return "; ".join((self.folder / "run.log").read_text("utf-8", errors="replace").splitlines()[-6:])

    def hit(self, kind: str, draw: random.Random) -> str:
        """Stop or kill, and wait until all is down where the supervisor was meant; return what was hit."""
        assert self.process is not None
        whom, _, number = kind.rpartition(" ")
        if whom:
            nodes = {name: each for name, each in self.nodes().items() if not name.startswith("program")}
            if not nodes:
                return "nobody"
            name = draw.choice(sorted(nodes))
            with contextlib.suppress(ProcessLookupError):
                os.kill(nodes[name], signal.Signals[number])
            if number == "SIGKILL":  # it is started again and continues
                return name
            time.sleep(draw.uniform(0.0, 1.0))  # one that gets a signal to end is not started again
            self._end("SIGINT")
            return name
        self._end(number)
        return "supervisor"

    def _end(self, number: str) -> None:
        assert self.process is not None
        left = self.nodes()
        self.process.send_signal(signal.Signals[number])
        self.process.wait(PATIENCE)
        end = time.monotonic() + PATIENCE
        while left := {name: process for name, process in left.items() if _is_there(process)}:
            if time.monotonic() > end:
                raise LostError(f"processes are left over: {left}")
            time.sleep(0.02)

    def close(self) -> None:
        """Leave nothing running."""
        if self.process is not None and self.process.poll() is None:
            self._end("SIGINT")

    def check(self) -> Counter[str]:
        """Check the traces of a round that is over.

        Raises
        ------
        LostError
            Something is lost or came twice.
        """
        parts = traces_of_runs([self.traces])
        records = [record for paths in parts.values() for record in read_trace(paths)]
        lossy = self.application.lossy
        records = [record for record in records if getattr(record, "channel", None) not in lossy]
        dropped = sum(
            record.count for record in records if isinstance(record, Drop) and record.queue != "feedback"
        )
        if dropped:
            raise LostError(f"{dropped} messages were dropped")
        counted = _count_messages(records)
        counted.update(_count_goals(records))
        done = rebuild_at(self.traces, self.application.node).counts().get(self.application.done, 0)
        if done != self.expected:
            raise LostError(f"{done} pieces of work are done, not {self.expected}")
        model = self.application.model_with(self.application.settings(self.pieces))
        verdict = conform(model, {node: partial(read_trace, paths) for node, paths in parts.items()})
        for deviation in (*verdict.violations, *verdict.unknown):
            raise LostError(f"{verdict.status}: {deviation.location}: {deviation}")
        counted["steps"] = verdict.steps
        return counted


def _count_messages(records: list[Record]) -> Counter[str]:
    counted: Counter[str] = Counter()
    for kind, others in ((Publish, (Take,)), (Request, (Serve, Reply, Response))):
        sent = Counter((each.channel, each.message) for each in records if type(each) is kind)
        counted[kind.event] = len(sent)
        for other in others:
            came = Counter((each.channel, each.message) for each in records if type(each) is other)
            missing = [key for key in sent if key not in came]
            # What continues at the end may be under way: the last call of a safety loop, a warning.
            missing = [key for key in missing if not _is_last(key, sent)]
            twice = [key for key, number in (sent + came).items() if number > 2]
            if missing or twice:
                raise LostError(f"{kind.event} and {other.event}: missing {missing}, twice {twice}")
    return counted


def _count_goals(records: list[Record]) -> Counter[str]:
    """Count goals: each is accepted once and over once, or refused, and its client learns that once."""
    steps: dict[type[Record], Counter[tuple[str, str | None]]] = {
        kind: Counter((each.channel, each.message) for each in records if type(each) is kind)
        for kind in (Goal, Accept, Finish, Reject, Outcome)
    }
    sent = steps[Goal]
    for name, ends in (("ended", steps[Finish] + steps[Reject]), ("known", steps[Outcome] + steps[Reject])):
        missing = [key for key in sent if key not in ends and not _is_last(key, sent)]
        twice = [key for key, number in ends.items() if number > 1]
        if missing or twice:
            raise LostError(f"goals that {name}: missing {missing}, twice {twice}")
    twice = [key for kind in (Goal, Accept) for key, number in steps[kind].items() if number > 1]
    if twice or steps[Accept] != steps[Finish]:
        raise LostError(f"goals: accepted {steps[Accept]}, ended {steps[Finish]}, twice {twice}")
    return Counter({kind.event: steps[kind].total() for kind in (Goal, Accept, Finish, Reject)})


def _is_last(key: tuple[str, str | None], sent: Counter[tuple[str, str | None]]) -> bool:
    channel, message = key
    sender, _, number = (message or "").rpartition("/")
    return (channel, f"{sender}/{int(number) + 1}") not in sent


def _is_there(process: int) -> bool:
    try:
        state = Path(f"/proc/{process}/stat").read_text("utf-8").rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def stress(
    application: Application,
    folder: Path,
    stops: int,
    seed: int,
    pieces: int,
    domain: int,
    longest: float = 6.0,
) -> Iterator[dict[str, object]]:
    """Stop and kill so often, and yield what was done and what was counted."""
    draw = random.Random(seed)
    application.workspace(folder / "workspace", application.settings(pieces))
    number = 0
    done = 0
    while done < stops or number == 0:
        number += 1
        round_ = Round(application, folder / f"round{number}", pieces, domain)
        round_.start()
        try:
            while done < stops:
                round_.await_nodes()
                if round_.run_for(draw.uniform(0.0, longest)):
                    break
                kind = draw.choice(KINDS)
                whom = round_.hit(kind, draw)
                done += 1
                yield {"stop": done, "round": number, "signal": kind, "to": whom}
                assert round_.process is not None
                if round_.process.poll() is not None:
                    round_.start()
            while not round_.run_for(PATIENCE * 5):
                raise LostError(f"{round_.folder} does not continue: {round_.nodes()}")
            yield {"round": number, **round_.check()}
        finally:
            round_.close()


def main() -> int:
    """Stress the application and report."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("application", choices=sorted(APPLICATIONS))
    parser.add_argument("--stops", type=int, default=300)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument(
        "--pieces",
        type=int,
        default=3,
        help="objects of each colour, or orders, in a round; "
        "more than 3 can fill a queue of sorting, more than 1 one of sorting_actions",
    )
    parser.add_argument("--longest", type=float, default=6.0, help="seconds between two stops, at most")
    parser.add_argument("--keep", type=Path, help="keep traces and logs in this folder")
    options = parser.parse_args()
    with contextlib.ExitStack() as stack:
        folder = options.keep or Path(
            stack.enter_context(tempfile.TemporaryDirectory(prefix="dineros-stops-"))
        )
        domain = stack.enter_context(claimed_domain())
        application = APPLICATIONS[options.application]
        numbers = (options.stops, options.seed, options.pieces, domain, options.longest)
        try:
            for line in stress(application, folder, *numbers):
                print(json.dumps(line), flush=True)
        except LostError as error:
            print(error, file=sys.stderr)
            return 1
    print("nothing is lost, nothing came twice, every round conforms")
    return 0


if __name__ == "__main__":
    sys.exit(main())
