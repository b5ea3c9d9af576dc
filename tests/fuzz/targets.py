"""What is fuzzed: every kind of input, with what makes good ones and what takes them."""

from __future__ import annotations

import shutil
import zlib
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random

from tests.fuzz import mutators, seeds
from tests.fuzz.answering_targets import (
    baseline,
    certificate,
    mutate_suppressions,
    proofs,
    properties,
    suppressions,
    timed_certificate,
)
from tests.fuzz.editing_targets import editor, editors_journal
from tests.fuzz.foreign_targets import (
    foreign_pnml,
    foreign_properties,
    mutate_foreign,
    symmetric_pnml,
    symmetric_properties,
)
from tests.fuzz.judging import REFUSED, Outcome, refused_or, run_command
from tests.fuzz.observing_targets import (
    given,
    mutate_messages,
    recorded_messages,
    recording,
    seen_recording,
    tracing,
)
from tests.fuzz.running_targets import announcement, journal, live_page, message, mqtt, payload, rest_request
from tests.fuzz.source_targets import SOURCES, source
from tests.fuzz.steering_targets import answered_by_a_process, asked_of_a_node, said_by_a_page

Attempt = Callable[[bytes], Outcome]
MEMORY = ("--memory", "600M")
TIMEOUT = ("--timeout", "5")


@dataclass(frozen=True)
class Kind:
    """A kind of input.

    Attributes
    ----------
    prepare : callable
        Given an empty folder and what is ended later, returns good inputs and what takes one.
    mutate : callable
        Damages them.
    share : int
        How many of them are tried where others are tried 100 times: less for what takes long.
    """

    prepare: Callable[[Path, ExitStack], tuple[Sequence[bytes], Attempt]]
    mutate: mutators.Mutator
    share: int = 100

    @contextmanager
    def prepared(self, folder: Path) -> Iterator[tuple[Sequence[bytes], Attempt]]:
        """Return good inputs and what takes one; processes and threads end with the block."""
        with ExitStack() as ending:
            yield self.prepare(folder, ending)

    def input(self, originals: Sequence[bytes], name: str, seed: int, number: int) -> bytes:
        """Return an input, always the same by kind, seed and number."""
        return self.mutate(Random(f"{seed} {name} {number}"), originals)


def _chosen(content: bytes, count: int) -> int:
    """Choose by the input itself, so that it alone shows what happens."""
    return zlib.crc32(content) % count


def _text(content: bytes) -> str:
    """Return an argument as processes get it: without NUL, bytes that are not UTF-8 as surrogates."""
    return content.replace(b"\0", b"")[:100_000].decode("utf-8", "surrogateescape")


def _model(suffix: str, folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    originals = seeds.models(folder / "seeds", suffix)
    names = {"xmi": "case.xmi", "pnml": "case.pnml", "net": "case.net", "xml": "case.xml", "cts": "case.cts"}
    work = folder / "work"
    path, output = work / names[suffix], work / "out"
    questions: list[list[object]] = [
        ["validate", path],
        ["validate", path, "--json"],
        *(["convert", path, "-o", output.with_suffix(f".{other}")] for other in names),
        ["flatten", path, "-o", output.with_suffix(".pnm")],
        ["reduce", path, "-o", output.with_suffix(".net")],
        ["split", path, "-o", work / "parts"],
        ["generate", path, "-o", work / "workspace"],
        ["find", path, "--marking", "a >= 99999", *MEMORY, *TIMEOUT],
        ["verify", path, "--ctl", "AG EF deadlock", "--no-cache", *MEMORY, *TIMEOUT],
        ["run", path, "--simulate", "--timeout", "1", "--seed", "1"],
        ["check", path, "--no-cache", "--format", "sarif", *MEMORY],
        ["statespace", path, "--no-cache", *MEMORY],
        ["find", path, "--marking", "a >= 99999", "--time", *MEMORY, *TIMEOUT],
        ["check", path, "--time", "--no-cache", *MEMORY, *TIMEOUT],
        ["reduce", path, "--time", "-o", output.with_suffix(".net")],
        ["latency", path, *MEMORY, *TIMEOUT],
        ["latency", path, "--bounds", "--json", *MEMORY, *TIMEOUT],
    ]

    def attempt(content: bytes) -> Outcome:
        shutil.rmtree(work, ignore_errors=True)
        work.mkdir()
        path.write_bytes(content)
        outcome = run_command(*questions[_chosen(content, len(questions))])
        left = [each.name for each in work.iterdir() if each != path]
        if outcome.status == REFUSED and left:
            return Outcome(-1, f"is refused, but there are {left}: {outcome.said}")
        return outcome

    return originals, attempt


def _picture(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    originals = seeds.models(folder / "seeds", "xmi")
    path = folder / "case.xmi"

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        return run_command("convert", path, "-o", folder / ("out.svg", "out.html")[_chosen(content, 2)])

    return originals, attempt


def _argument(
    originals: Sequence[bytes], commands: Sequence[Sequence[object]], folder: Path, ending: ExitStack
) -> tuple[Sequence[bytes], Attempt]:
    """Give a text to one of some commands, in place of TEXT.

    MODEL is a model, RUN a run of it, ASKED a model with a property.
    """
    path, run, asked = seeds.model(folder), folder / "run", seeds.asked(folder)
    if any("RUN" in command for command in commands):
        seeds.made("run", path, "--simulate", "--seed", 1, "--timeout", 2, "--trace", run)

    def attempt(content: bytes) -> Outcome:
        text = _text(content)
        chosen = commands[_chosen(content, len(commands))]
        named = {"MODEL": str(path), "OUT": str(folder / "out.net"), "RUN": str(run), "ASKED": str(asked)}
        return run_command(*(named.get(str(each), str(each).replace("TEXT", text)) for each in chosen))

    return originals, attempt


def _question(
    originals: Sequence[bytes], *commands: str
) -> Callable[[Path, ExitStack], tuple[Sequence[bytes], Attempt]]:
    split = [[word for word in command.split() if word] for command in commands]
    return partial(_argument, originals, split)


def _clause(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    from dineros.metamodel.clauses import set_clause
    from dineros.metamodel.constraints import validate
    from dineros.metamodel.elements import find
    from dineros.metamodel.sym import Transition
    from tests.support.systems.talker import talker

    def attempt(content: bytes) -> Outcome:
        model = talker()
        outcome = refused_or(lambda: set_clause(find(model, "Say", Transition), _text(content)))
        validate(model)
        return outcome

    return seeds.CLAUSES, attempt


def _vary(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Read a grid and check it on the model; counting its points is no matter of the input."""
    from dineros.analysis.sweeps import Axis, Grid
    from dineros.metamodel.files import load
    from dineros.metamodel.files.xmi import xmi_bytes

    model = xmi_bytes(load(seeds.model(folder))).decode()

    def attempt(content: bytes) -> Outcome:
        def work() -> None:
            grid = Grid((Axis.parse(_text(content)),))
            grid.check(model)
            for point in grid:
                assert point.key

        return refused_or(work)

    return seeds.VARY, attempt


def _option(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    path, picture = seeds.model(folder), folder / "out.svg"
    run = ["run", path, "--simulate"]
    commands: dict[str, list[object]] = {
        "memory": ["find", path, "--marking", "Noted >= 1"],
        "stale-after": [*run, *TIMEOUT],
        "timeout": run,
        "seed": [*run, *TIMEOUT],
        "keep": ["reduce", path, "-o", folder / "out.net"],
        "explain": ["flatten", path],
        "filter": ["trace", seeds.witness(folder), "-o", picture],
    }
    generate = ["generate", path, "-o", folder / "nowhere", "--check"]

    def attempt(content: bytes) -> Outcome:
        name, _, value = _text(content).partition(" ")
        known = name if name in commands or name in ("maintainer", "license") else "memory"
        return run_command(*commands.get(known, generate), f"--{known}", value)

    return seeds.OPTIONS, attempt


def _workspace(
    place: str, originals: Sequence[bytes], folder: Path, ending: ExitStack
) -> tuple[Sequence[bytes], Attempt]:
    """Put a file into a workspace, and check it or generate it again; nothing outside of it may change."""
    path, good = seeds.workspace(folder)
    work = folder / "work"
    outside = folder / "outside"
    outside.write_text("precious", encoding="utf-8")
    found = [(good / place).read_bytes()] if (good / place).exists() else []

    def attempt(content: bytes) -> Outcome:
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(good, work)
        (work / place).write_bytes(content)
        before = sorted(folder.iterdir())
        outcome = run_command("generate", path, "-o", work, *(["--check"] if _chosen(content, 3) else []))
        assert (sorted(folder.iterdir()), outside.read_text()) == (before, "precious")
        return outcome

    return [*originals, *found], attempt


def _trace(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    run, witness = seeds.traces(folder), seeds.witness(folder)
    model, kitchen = seeds.model(folder), folder / "kitchen.sym.xmi"
    path = folder / "case.jsonl"
    suffixes = (".csv", ".mcap", ".csv", ".html", ".svg")

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        chosen = _chosen(content, 24)
        if chosen < 8:
            return run_command("conform", kitchen if chosen % 2 else model, path)
        if chosen < 10:
            return run_command("generate", kitchen, "-o", folder / "nowhere", "--check", "--tests", path)
        if chosen < 12:
            return run_command("trace", path, "--compare", witness, "-o", folder / "out.csv")
        output = folder / f"out{suffixes[chosen % len(suffixes)]}"
        output.unlink(missing_ok=True)
        outcome = run_command("trace", path, "-o", output)
        if outcome.status == REFUSED and output.exists():
            return Outcome(-1, f"is refused, but there is {output.name}: {outcome.said}")
        return outcome

    return [witness.read_bytes(), *(each.read_bytes() for each in sorted(run.glob("*.jsonl")))], attempt


def _orders(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    model = seeds.model(folder)
    question = ("statespace", model, "--engine", "symbolic", *MEMORY)
    seeds.made(*question)
    path = folder / ".dineros" / "orders.json"
    if not path.exists():
        from dineros.analysis.model.subject import subject_of
        from dineros.analysis.symbolic.order_cache import OrderCache
        from dineros.metamodel.files import load

        net = subject_of(load(model), "input-enabled", "weighted").net
        OrderCache(model).keep(net, [[place] for place in net.places])
    originals = [path.read_bytes()]

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)
        outcome = run_command(*question)
        return outcome if outcome.status == 0 else Outcome(-1, f"an order decides: {outcome.said}")

    return originals, attempt


def _sweep_journal(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Go on with a sweep from a damaged journal, and write what it says as a table."""
    from dataclasses import asdict

    from dineros.analysis.sweeps import Axis, Figures, Grid
    from dineros.analysis.sweeps.journal import Journal
    from dineros.analysis.sweeps.tables import to_csv, to_parquet

    grid = Grid((Axis.parse("A.tokens=0..3"),))
    path = folder / "out.csv.partial.jsonl"
    done = Figures(
        places=2, transitions=1, states=10**30, arcs=3, seconds=0.25, engine="symbolic", complete=True
    )
    points = list(grid)
    with Journal(path, "m", grid, "auto", [None, 5.0]) as written:
        written.add(points[0], done)
        written.add(points[1], Figures(error="timeout after 5 s"))
        written.add(points[2], done)
    original = path.read_bytes()

    def attempt(content: bytes) -> Outcome:
        path.write_bytes(content)

        def work() -> None:
            with Journal(path, "m", grid, "auto", [None, 5.0]) as read:
                rows = [{**point.columns(), **asdict(read.finished.get(point.key, done))} for point in points]
                assert to_csv(rows)
                assert to_parquet(rows)

        return refused_or(work)

    return [original], attempt


KINDS = {
    "XMI": Kind(partial(_model, "xmi"), mutators.mutate_xml),
    "PNML": Kind(partial(_model, "pnml"), mutators.mutate_xml),
    "net": Kind(partial(_model, "net"), mutators.mutate_words),
    "Romeo": Kind(partial(_model, "xml"), mutators.mutate_xml, share=20),
    "cts": Kind(partial(_model, "cts"), mutators.mutate_words, share=20),
    "foreign PNML": Kind(foreign_pnml, mutate_foreign, share=200),
    "symmetric PNML": Kind(symmetric_pnml, mutators.mutate_xml, share=50),
    "picture": Kind(_picture, mutators.mutate_xml, share=20),
    "LTL": Kind(
        _question(seeds.LTL, "verify MODEL --no-cache --memory 600M --timeout 5 --ltl TEXT"),
        mutators.mutate_words,
    ),
    "CTL": Kind(
        _question(seeds.CTL, "verify MODEL --no-cache --memory 600M --timeout 5 --ctl TEXT"),
        mutators.mutate_words,
    ),
    "goal": Kind(
        _question(
            seeds.GOALS,
            "find MODEL --memory 600M --timeout 5 --marking TEXT",
            "find MODEL --memory 600M --timeout 5 --enabled TEXT",
            "run MODEL --simulate --timeout 1 --until TEXT",
            "conform MODEL RUN --invariant TEXT",
        ),
        mutators.mutate_words,
    ),
    "properties": Kind(properties, mutators.mutate_xml, share=50),
    "foreign properties": Kind(foreign_properties, mutators.mutate_xml),
    "symmetric properties": Kind(symmetric_properties, mutators.mutate_xml, share=50),
    "certificate": Kind(certificate, mutators.mutate_json),
    "certificate with times": Kind(timed_certificate, mutators.mutate_json),
    "proofs": Kind(proofs, mutators.mutate_json),
    "baseline": Kind(baseline, mutators.mutate_json),
    "suppressions": Kind(suppressions, mutate_suppressions),
    "clause": Kind(_clause, mutators.mutate_words, share=200),
    "setting": Kind(
        _question(
            seeds.SETTINGS,
            "validate ASKED --set TEXT",
            "flatten ASKED -o OUT --set TEXT",
            "check ASKED --no-cache --memory 600M --timeout 5 --set TEXT",
            "find MODEL --marking Noted>=1 --memory 600M --timeout 5 --set TEXT",
        ),
        mutators.mutate_words,
    ),
    "grid": Kind(_vary, mutators.mutate_words, share=200),
    "limit": Kind(_question(seeds.LIMITS, "validate MODEL --limit TEXT"), mutators.mutate_words),
    "options": Kind(_option, mutators.mutate_words),
    "manifest": Kind(partial(_workspace, ".dineros/manifest.json", []), mutators.mutate_json, share=50),
    "dependencies": Kind(
        partial(_workspace, "src/waiter/dependencies.toml", seeds.DEPENDENCIES),
        mutators.mutate_words,
        share=30,
    ),
    "journal": Kind(journal, mutators.mutate_json_lines),
    "trace": Kind(_trace, mutators.mutate_json_lines),
    "recording": Kind(recording, mutators.mutate_bytes, share=50),
    "seen recording": Kind(seen_recording, mutators.mutate_bytes, share=50),
    "recorded messages": Kind(recorded_messages, mutate_messages, share=20),
    "given": Kind(given, mutators.mutate_words, share=200),
    "tracing": Kind(tracing, mutators.mutate_bytes, share=50),
    **{name: Kind(partial(source, each), each.mutate, share=50) for name, each in SOURCES.items()},
    "orders": Kind(_orders, mutators.mutate_json),
    "sweep journal": Kind(_sweep_journal, mutators.mutate_json_lines),
    "message": Kind(message, mutators.mutate_json, share=200),
    "announcement": Kind(announcement, mutators.mutate_json, share=200),
    "payload": Kind(payload, mutators.mutate_words, share=200),
    "MQTT": Kind(mqtt, mutators.mutate_words, share=10),
    "request": Kind(rest_request, mutators.mutate_words),
    "live page": Kind(live_page, mutators.mutate_words),
    "steering": Kind(said_by_a_page, mutators.mutate_json),
    "asked of a node": Kind(asked_of_a_node, mutators.mutate_json_lines),
    "answered by a node": Kind(answered_by_a_process, mutators.mutate_json_lines),
    "editor": Kind(editor, mutators.mutate_json),
    "editor's journal": Kind(editors_journal, mutators.mutate_json_lines, share=200),
}
"""All kinds, by name."""
