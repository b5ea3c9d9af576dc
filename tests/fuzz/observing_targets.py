"""What systems that exist already leave behind: recordings, tracing files, and what is given of them."""

from __future__ import annotations

import json
import re
import shutil
import zlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from random import Random

from dineros.observation.importing.given_reading import given_beside
from tests.fuzz import mutators, seeds
from tests.fuzz.judging import REFUSED, Outcome, run_command
from tests.support.programs.bags import STRING, service_event, write_bag
from tests.support.traces import Trace

Attempt = Callable[[bytes], Outcome]
STRING_TYPE, WHERE = "std_msgs/msg/String", "/where/_service_event"
_TYPES = {WHERE: "std_srvs/srv/Trigger_Event"}
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
    model = folder / "robot.sym.xmi"
    seeds.made("import", "--bag", bags["mcap"], "--given", given, "-o", model)
    return _damaged(folder, bags, _asked(folder, model, given))


def _asked(folder: Path, model: Path, given: Path) -> Callable[[Path], Outcome]:
    """Return what asks one of the questions about recordings."""
    out = folder / "out.sym.xmi"

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
        for left in (out, given_beside(out)):
            left.unlink(missing_ok=True)
        return run_command(*commands[zlib.crc32(sizes) % len(commands)])

    return ask


def recorded_messages(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Import, compare, narrow by or explain a whole recording of odd topics, types, times and messages."""
    given = folder / "robot.given.toml"
    given.write_bytes(GIVEN[0])
    model, seen = folder / "robot.sym.xmi", _robot(folder / "whole", "mcap")
    seeds.made("import", "--bag", seen, "--given", given, "-o", model)
    ask, bag = _asked(folder, model, given), folder / "case"

    def attempt(content: bytes) -> Outcome:
        shutil.rmtree(bag, ignore_errors=True)
        try:
            lines = [json.loads(line) for line in content.splitlines() if line.strip()]
            messages = [(line["topic"], line["time"], bytes.fromhex(line["data"])) for line in lines]
            types = {line["topic"]: line["type"] for line in lines}
            write_bag(bag, messages, types=types, storage=("mcap", "sqlite3")[zlib.crc32(content) % 2])
        except Exception as error:  # whatever the library that writes recordings says of it
            return Outcome(REFUSED, f"cannot be written: {type(error).__name__}\n")
        return ask(bag)

    lines = [
        json.dumps({"topic": topic, "time": time, "data": data.hex(), "type": _TYPES.get(topic, STRING_TYPE)})
        for topic, time, data in _told()
    ]
    return ["\n".join(lines).encode()], attempt


ODD_TYPES = [
    "std_msgs/msg/Int32",
    "std_srvs/srv/Trigger_Event",
    "a/b",
    "x",
    "",
    "a/msg/\u00e4",
    "geometry_msgs/msg/Pose",
]
ODD_TIMES = [0, 1, 10**9, 10**9 + 1, 2**31, 2**53 + 1, 2**63 - 1, 2**63, 2**64 - 1, -1]


def mutate_messages(random: Random, originals: Sequence[bytes]) -> bytes:
    """Change topics, types, times and data of messages so that most can still be written."""
    if random.random() < 0.1:
        return mutators.mutate_json_lines(random, originals)
    lines = [json.loads(line) for line in random.choice(originals).splitlines()]
    for _ in range(random.choice([1, 1, 2, 3, 6])):
        at = random.randrange(len(lines))
        line = lines[at]
        match random.randrange(7):
            case 0:
                old, new = line["topic"], random.choice(["", "/", "/a/"]) + random.choice(mutators.NAMES)
                for each in lines:
                    each["topic"] = new if each["topic"] == old else each["topic"]
            case 1:
                line["topic"] = random.choice(lines)["topic"]
            case 2:
                line["type"] = random.choice(ODD_TYPES)
            case 3:
                line["time"] = random.choice([*ODD_TIMES, *(each["time"] for each in lines)])
            case 4:
                line["data"] = mutators.mutate_bytes(random, [bytes.fromhex(line["data"])])[:5000].hex()
            case 5 if len(lines) > 1:
                del lines[at]
            case _:
                lines[at:at] = [dict(line) for _ in range(random.choice([1, 3, 300]))]
    return "\n".join(json.dumps(line) for line in lines).encode()


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
    return write_bag(path, _told(), types=_TYPES, storage=storage)


def _told() -> list[tuple[str, int, bytes]]:
    told: list[tuple[str, int, bytes]] = []
    for number in range(4):
        begun = number * 500_000_000
        told += [("/scan", begun, STRING), ("/pose", begun + 10_000_000, STRING)]
        told += [(WHERE, begun + (20 + kind) * 1_000_000, service_event(kind, number)) for kind in range(4)]
    return told


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
