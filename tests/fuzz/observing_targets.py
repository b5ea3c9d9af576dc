"""What systems that exist already leave behind: recordings, tracing files, and what is given of them."""

from __future__ import annotations

import re
import shutil
import zlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path

from dineros.observation.importing.given import given_beside
from tests.fuzz import seeds
from tests.fuzz.judging import REFUSED, Outcome, run_command
from tests.support.programs.bags import service_event, write_bag
from tests.support.traces import Trace

Attempt = Callable[[bytes], Outcome]
BUDGET = ("--memory", "600M", "--timeout", "5")


def recording(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Explain a recording with one damaged file."""
    model = seeds.model(folder)
    return _damaged(
        folder, seeds.recordings(folder), lambda bag: run_command("conform", model, "--bag", bag, *BUDGET)
    )


def seen_recording(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Import, compare, narrow by or explain a recording with one damaged file, of topics and services."""
    bags = {kind: _robot(folder / kind, kind) for kind in ("mcap", "sqlite3")}
    given = folder / "robot.given.toml"
    given.write_bytes(GIVEN[0])
    model, out = folder / "robot.sym.xmi", folder / "out.sym.xmi"
    seeds.made("import", "--bag", bags["mcap"], "--given", given, "-o", model)

    def ask(bag: Path) -> Outcome:
        commands: list[list[object]] = [
            ["import", "--bag", bag, "--given", given, "-o", out, *BUDGET],
            ["diff", model, "--bag", bag, *BUDGET],
            ["diff", model, "--bag", bag, "--format", "sarif", *BUDGET],
            ["narrow", model, "--bag", bag, *BUDGET],
            ["narrow", model, "--bag", bag, "--threshold", "0.5", "-o", out, *BUDGET],
            ["conform", model, "--bag", bag, "--midway", *BUDGET],
        ]
        sizes = b"".join(each.read_bytes() for each in sorted(bag.iterdir()))
        out.unlink(missing_ok=True)
        return run_command(*commands[zlib.crc32(sizes) % len(commands)])

    return _damaged(folder, bags, ask)


def given(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Import a recording with a damaged file of what is given; a model that is written must be valid."""
    bag, path, out = _robot(folder / "mcap", "mcap"), folder / "case.toml", folder / "out.sym.xmi"
    seeds.made("import", "--bag", bag, "-o", out)
    assumed = given_beside(out).read_bytes()

    def attempt(content: bytes) -> Outcome:
        out.unlink(missing_ok=True)
        path.write_bytes(content)
        outcome = run_command("import", "--bag", bag, "--given", path, "-o", out, *BUDGET)
        if outcome.status == REFUSED and out.exists():
            return Outcome(-1, f"is refused, but there is a model: {outcome.said}")
        if outcome.status in (0, 1):
            valid = run_command("validate", out)
            if valid.status != 0:
                return Outcome(-1, f"writes a model that is not valid: {valid.said}")
        return outcome

    return [*GIVEN, re.sub(rb"(?m)^# ?(?=\[|\S+ = )", b"", assumed)], attempt


def tracing(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Narrow a model by a damaged trace: the text that Babeltrace 2 writes."""
    model, path = seeds.model(folder), folder / "trace.txt"

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("narrow", model, "--tracing", path, *BUDGET)

    return [_whole(1).encode(), _whole(12).encode()], attempt


def _damaged(
    folder: Path, bags: dict[str, Path], ask: Callable[[Path], Outcome]
) -> tuple[Sequence[bytes], Attempt]:
    """Return the files of recordings, and what puts another in place of one of them, and asks."""
    work = {name: shutil.copytree(bag, folder / "work" / name) for name, bag in bags.items()}
    originals = {
        file: file.read_bytes() for bag in work.values() for file in sorted(bag.iterdir()) if file.is_file()
    }
    kinds = {
        magic: next(file for file in originals if file.suffix == suffix)
        for magic, suffix in ((b"\x89MCAP", ".mcap"), (b"SQLite", ".db3"))
    }

    def attempt(content: bytes) -> Outcome:
        damaged = next((file for magic, file in kinds.items() if content.startswith(magic)), None)
        damaged = damaged or work["sqlite3" if b"sqlite3" in content else "mcap"] / "metadata.yaml"
        damaged.write_bytes(content)
        try:
            return ask(damaged.parent)
        finally:
            damaged.write_bytes(originals[damaged])

    return list(originals.values()), attempt


def _robot(path: Path, storage: str) -> Path:
    """Write a recording of two topics and of a service that tells of its calls."""
    service = "/where/_service_event"
    told: list[tuple[str, int] | tuple[str, int, bytes]] = []
    for number in range(4):
        begun = number * 500_000_000
        told += [("/scan", begun), ("/pose", begun + 10_000_000)]
        told += [(service, begun + (20 + kind) * 1_000_000, service_event(kind, number)) for kind in range(4)]
    return write_bag(path, told, types={service: "std_srvs/srv/Trigger_Event"}, storage=storage)


def _whole(rounds: int) -> str:
    trace = Trace()
    talker, listener = trace.node("/talker"), trace.node("/listener")
    chatter = trace.publisher(talker, "/chatter")
    say, heard = trace.timer(talker, 100_000_000), trace.subscription(listener, "/chatter")
    for _ in range(rounds):
        trace.run(say, [chatter])
        trace.run(heard, thread=2)
    return "".join(trace.lines)


GIVEN = [
    b"""[topic."/scan"]
publishers = ["/lidar"]
subscribers = ["/localizer", "/mapper"]
[topic."/pose"]
publishers = ["/localizer"]
[service."/where"]
servers = ["/localizer"]
clients = ["/mapper"]
[node."/lidar"]
timers.tick = 0.1
depths."/scan" = 5
lifecycle = ["deactivates", "activateFails"]
callback.tick.does = ["publish /scan"]
[node."/localizer"]
threads = 2
groups = {a = "exclusive", b = "reentrant"}
depths = {"/scan" = 1, "/pose" = 10}
newest."/scan" = true
timers = {}
callback."/scan" = {does = ["publish /pose"], group = "a"}
callback."/where" = {does = [], group = "b"}
""",
    b"""[topic."/scan"]
publishers = ["/a"]
subscribers = ["/a"]
[topic."/pose"]
publishers = ["/a", "/b"]
[service."/where"]
clients = ["/a", "/b"]
[node."/a"]
callback."/scan" = {does = ["call /where ?", "publish /pose *", "send /where"], awaits = true}
""",
]
