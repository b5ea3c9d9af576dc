"""What stands beside questions and answers: properties, certificates, baselines, accepted findings."""

from __future__ import annotations

import json
import zlib
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from pathlib import Path
from random import Random

from lxml import etree

from dineros.analysis.evidence.certificate import sealed
from dineros.metamodel.build import suppress
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.fuzz import mutators, seeds
from tests.fuzz.judging import Outcome, run_command
from tests.support.systems.talker import talker

Attempt = Callable[[bytes], Outcome]
NET = "net n\npl a (2)\ntr t a -> b\ntr u b -> a\ntr v c -> c a\ntr w a*3 -> c\n"
TIMED = "net n\npl a (2)\ntr t [1,2] a -> b\ntr u ]1/2,3[ b -> a\ntr w [9,w[ a -> c\n"


def properties(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask a property file that DiNeROS wrote."""
    path, model = folder / "case.xml", folder / "net.net"
    model.write_text("net n\npl a (2)\ntr t a -> b\ntr u b -> a\n")
    for logic, formula in (("--ltl", "G (a >= 1 -> F b == 1)"), ("--ctl", "A[enabled(t) U EX (a + b <= 2)]")):
        seeds.made("verify", model, logic, formula, "--write-properties", folder / f"seed{logic}.xml")

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("verify", model, "--properties", path, "--timeout", "0.5", "--memory", "600M")

    return [seed.read_bytes() for seed in sorted(folder.glob("seed*.xml"))], attempt


def certificate(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Check a certificate of a marking."""
    model = folder / "net.net"
    model.write_text(NET)
    for number, goal in enumerate(("a + b >= 3 | c >= 1", "a + b == 0", "b >= 3 & deadlock")):
        seeds.made("find", model, "--marking", goal, "--certificate", folder / f"seed{number}.json")
    return _certified(folder, model)


def timed_certificate(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Check a certificate of a net with times: classes, and a schedule."""
    model = folder / "net.net"
    model.write_text(TIMED)
    for number, goal in enumerate(("c >= 1", "a + b >= 3", "b >= 2")):
        seeds.made("find", model, "--time", "--marking", goal, "--certificate", folder / f"seed{number}.json")
    return _certified(folder, model)


def proofs(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Check a certificate of a formula, or of all answers of a check, of a system with settings."""
    model = seeds.model(folder)
    change = ("--set", "Words.tokens=2")
    seeds.made("check", model, "--no-cache", *change, "--certificate", folder / "seed0.json")
    formula = ("--ltl", "G (Words + Said <= 3)", "--certificate", folder / "seed1.json")
    seeds.made("verify", model, "--no-cache", *change, *formula)
    return _certified(folder, model)


def _certified(folder: Path, model: Path) -> tuple[Sequence[bytes], Attempt]:
    path = folder / "case.json"

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        try:  # half of them get past the seal
            found = json.loads(content)
            if isinstance(found, dict) and zlib.crc32(content) % 2:
                path.write_text(json.dumps(sealed(found)))
        except (ValueError, RecursionError):
            path.write_bytes(content)
        return run_command("certify", model, path, "--timeout", "5")

    return [seed.read_bytes() for seed in sorted(folder.glob("seed*.json"))], attempt


def baseline(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Check against a damaged baseline, and against what ``check`` prints as JSON and SARIF."""
    path, model = folder / "case.json", folder / "net.net"
    model.write_text(NET)
    seeds.made("check", model, "--no-cache", "--write-baseline", folder / "seed.json")
    originals = [(folder / "seed.json").read_bytes()]
    originals += [_printed("check", model, "--no-cache", "--format", form) for form in ("json", "sarif")]
    question = ("check", model, "--no-cache", "--timeout", "5", "--memory", "600M", "--baseline", path)
    formats = ("text", "json", "sarif", "junit")

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command(*question, "--format", formats[zlib.crc32(content) % len(formats)])

    return originals, attempt


def _printed(*arguments: object) -> bytes:
    """Return what a command prints on standard output."""
    from click.testing import CliRunner

    from dineros.cli.main import main

    return CliRunner().invoke(main, [str(each) for each in arguments]).stdout_bytes


def suppressions(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Check a model in which findings are accepted."""
    path, out = folder / "case.sym.xmi", folder / "out.pnml"
    model = talker()
    suppress(find(model, "Heard"), "queue-overflow", "the listener is only a logger", "2999-12-31")
    suppress(model, "deadlock", "the pool runs empty")
    suppress(find(model, "Say"), "dead-transition", "not used yet", "2020-02-29")
    save(model, folder / "seed.sym.xmi")
    formats = ("text", "json", "sarif", "junit")

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        chosen = zlib.crc32(content) % 6
        if chosen < len(formats):
            limits = ("--timeout", "5", "--memory", "600M")
            return run_command("check", path, "--no-cache", "--format", formats[chosen], *limits)
        return run_command("validate", path) if chosen == 4 else run_command("convert", path, "-o", out)

    return [(folder / "seed.sym.xmi").read_bytes()], attempt


VALUES = {
    "rule": ["deadlock", "queue-overflow", "dead-lock", "", "*", "deadlock queue-overflow", "unbounded"],
    "reason": ["", " ", "x", "a\nb", "\u202e", "<b>&", "\x1b[2J", "x" * 5000],
    "until": [
        *("2027-03-31", "2020-01-01", "2027-02-30", "31.3.2027", "", "9999-12-31", "0000-00-00", "20270331"),
        *("2027-W01-1", "2027-03-31T00:00", "\u0662\u0660\u0662\u0667-03-31", "9" * 5000),
    ],
}


def mutate_suppressions(random: Random, originals: Sequence[bytes]) -> bytes:
    """Change rules, reasons and days of accepted findings; or damage the file."""
    if random.random() < 0.3:
        return mutators.mutate_xml(random, originals)
    root = etree.fromstring(random.choice(originals))
    for _ in range(random.choice([1, 1, 2, 3])):
        node = random.choice(list(root.iter("suppressions")))
        name = random.choice(list(VALUES))
        if random.random() < 0.2:
            etree.strip_attributes(node, name)
            continue
        try:
            node.set(name, random.choice(VALUES[name]))
        except ValueError:  # what no XML can hold
            node.set(name, "x")
    return bytes(etree.tostring(root))
