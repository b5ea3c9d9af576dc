"""What an application costs while nothing happens: processor time of each process, in percent of one core.

A model in which every kind of port waits (a client whose service is idle, a topic, a signal) runs as
``dineros run``, ``dineros run --local`` and under a live page; each should take less than 0.5 %. Several
installations can be measured side by side: ``--beside FOLDER``, a folder in which ``dineros`` is the package.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path

from benchmarks._processes import thread_seconds
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.files import save
from dineros.runtime.ros.process.domains import claimed_domain

LIMIT = 0.5
SETTLING = 12.0
"""Seconds until the processes have started and found each other."""

START = "from dineros.cli.main import main; main()"


def office() -> sym.SystemModel:
    """Return a desk that may ask a scale, when a signal says so, which never happens."""
    wish, ask, asked = sym.Place(id="Wish", tokens=1), sym.Transition(id="TAsk"), sym.Place(id="Asked")
    told, note, noted = sym.Place(id="Told"), sym.Transition(id="TNote"), sym.Place(id="Noted")
    signals = [sym.InputSignal(id="Go")]
    desk = sym.NodeNet(id="desk", objects=[wish, ask, asked, told, note, noted], signals=signals)
    flow(wish, ask, asked)
    flow(told, note, noted)
    set_clause(ask, "Go")
    entry, weigh, exit_ = sym.Place(id="Entry"), sym.Transition(id="TWeigh"), sym.Place(id="Exit")
    page = sym.CallbackPage(id="Weighing", kind="server", objects=[entry, weigh, exit_])
    heard, read, seen = sym.Place(id="Heard"), sym.Transition(id="TRead"), sym.Place(id="Seen")
    scale = sym.NodeNet(id="scale", objects=[page, heard, read, seen])
    flow(entry, weigh, exit_)
    flow(heard, read, seen)
    server = sym.ServerPort(entry=entry, exit=exit_, page=page)
    client = sym.ClientPort(client="desk", request=asked, response=told)
    topic = sym.TopicChannel(
        id="Notes",
        topic="/notes",
        publishers=[sym.PublisherPort(place=noted)],
        subscribers=[sym.SubscriberPort(place=heard)],
    )
    service = sym.ServiceChannel(id="Weigh", service="/weigh", server=server, clients=[client])
    return sym.SystemModel(
        id="idle",
        tokenType=sym.TokenType(id="Note", fields=[sym.TokenField(name="text")]),
        pages=[desk, scale],
        channels=[topic, service],
    )


def children(process: int) -> list[int]:
    """Return a process and all that it has started."""
    found = [process]
    for path in Path(f"/proc/{process}/task").glob("*/children"):
        for child in path.read_text().split():
            found += children(int(child))
    return found


def kind(process: int) -> str:
    """Return what a process is, by its command line."""
    words = Path(f"/proc/{process}/cmdline").read_text().split("\0")
    models = [Path(word).name.partition(".")[0] for word in words if word.endswith(".rtm.xmi")]
    if models:
        return f"node {models[0]}"
    return (
        "live page" if "--follow" in words else "run --local" if "--local" in words else "supervisor of run"
    )


def measure(folders: Mapping[str, Path | None], duration: float) -> Mapping[tuple[str, str], float]:
    """Return the percentage of each kind of process, by installation and kind."""
    with tempfile.TemporaryDirectory() as folder, contextlib.ExitStack() as stack:
        here = Path(folder)
        save(office(), here / "office.sym.xmi")
        runs: list[tuple[str, subprocess.Popen[bytes]]] = []
        try:
            for number, (name, installation) in enumerate(folders.items()):
                environment = dict(os.environ)
                if installation is not None:
                    environment["PYTHONPATH"] = str(installation)
                records = here / f"{number}"
                domain = stack.enter_context(claimed_domain())
                for words in (
                    ["run", "office.sym.xmi", "--trace", str(records / "ros"), "--domain", str(domain)],
                    ["run", "office.sym.xmi", "--local", "--trace", str(records / "local")],
                    ["trace", str(records / "ros"), "--follow"],
                ):
                    command = [sys.executable, "-P", "-c", START, *words]
                    log = (here / f"{number}-{len(runs)}.log").open("wb")
                    process = subprocess.Popen(
                        command, cwd=here, env=environment, stdout=log, stderr=log, stdin=subprocess.DEVNULL
                    )
                    runs.append((name, process))
                    time.sleep(SETTLING / 3)
            time.sleep(SETTLING)
            processes = {each: (name, kind(each)) for name, process in runs for each in children(process.pid)}
            before, begun = {each: thread_seconds(each) for each in processes}, time.monotonic()
            time.sleep(duration)
            wall = time.monotonic() - begun
            percents: defaultdict[tuple[str, str], float] = defaultdict(float)
            for each, what in processes.items():
                percents[what] += 100 * (thread_seconds(each) - before[each]) / wall
            return percents
        finally:
            for _, process in runs:
                process.send_signal(signal.SIGINT)
            for _, process in runs:
                process.wait()
            for path in sorted(here.glob("*.log")):
                if "--verbose" in sys.argv:
                    print(path.name, path.read_text())


def main() -> None:
    """Measure, print, and fail where a process takes too much."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=30.0, help="how long")
    parser.add_argument("--beside", type=Path, help="the folder of another installation")
    parser.add_argument("--verbose", action="store_true", help="print what the processes printed")
    options = parser.parse_args()
    folders: dict[str, Path | None] = {"beside": options.beside} if options.beside else {}
    found = measure({**folders, "this": None}, options.seconds)
    for (name, what), percent in sorted(found.items(), key=lambda item: item[0][::-1]):
        print(f"{what:<18} {name:<7} {percent:5.2f} %")
    if max(percent for (name, _), percent in found.items() if name == "this") > LIMIT:
        sys.exit(f"more than {LIMIT} %")


if __name__ == "__main__":
    main()
