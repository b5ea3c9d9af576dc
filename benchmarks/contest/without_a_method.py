"""What each decision method is needed for: questions of the contest and of the case study, one method less.

All methods answer first. Then each one that was asked is switched off in turn, and all is asked again. The
table has the answers that are missing then, or differ, and those that exist only then. A method that no
answer needs, on many nets, can go. Each run is a process of its own; budgets are processor time.

Usage: ``python -m benchmarks.contest.without_a_method FOLDER [--nets words] [--seconds 1] [--most 4]``.
"""

from __future__ import annotations

import argparse
import importlib
import multiprocessing
import pkgutil
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from benchmarks.contest.archives import unpack
from case_study.build import build
from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.model.subject import subject_of
from dineros.analysis.nets.models import compile_net
from dineros.analysis.portfolio import methods as folder
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.portfolio.method import Method
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
from dineros.analysis.properties.reading import read_properties
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking, Question
from dineros.analysis.questions.state_space import state_space
from dineros.metamodel.files import load
from dineros.transformations.rules.phases import SignalVariant

FILES = (
    "ReachabilityCardinality",
    "ReachabilityFireability",
    "UpperBounds",
    "CTLCardinality",
    "CTLFireability",
    "LTLCardinality",
    "LTLFireability",
)
MEMORY = 2 << 30
SIGNALS: tuple[SignalVariant, ...] = ("none", "input-enabled", "io-enabled", "fully-enabled")

Say = Callable[[str, Any], None]
Ask = Callable[[float, Say], None]
"""Asks questions within so many seconds each, and says their answers."""


def kinds() -> dict[str, type[Method]]:
    """Return all methods by name."""
    for module in pkgutil.iter_modules(folder.__path__, f"{folder.__name__}."):
        importlib.import_module(module.name)
    return {kind.__name__: kind for kind in Method.__subclasses__()}


def contest(net_file: Path, most: int, seconds: float, say: Say) -> None:
    """Ask some questions of each of the contest's files about a net."""
    net = compile_net(load(net_file))
    names = GroupedNames(NetNames(net))
    properties = [Property(name, "global", examination=name) for name in GLOBAL_PROPERTIES]
    for name in FILES:
        if (path := net_file.with_name(f"{name}.xml")).exists():
            properties += read_properties(path, names)[:most]
    answer_properties(net, names, properties, seconds, MEMORY, lambda one: say(one.id, one.value))


def case_study(signals: SignalVariant, seconds: float, say: Say) -> None:
    """Ask what is asked of the case study in the guide."""
    subject = subject_of(build(), signals)
    net, names = subject.net, subject.names
    questions: list[Question] = [Enabled(net, names, "TShowResult")]
    questions += [Marking(net, names, f"Shown >= {count}") for count in range(1, 5)]
    questions += [Marking(net, names, "Shown >= 3", order="depth-first")]
    questions += [Linear(net, names, text) for text in ("F (Shown >= 1)", "G F fired(TSense)")]
    questions += [Branching(net, names, text) for text in ("AG (Shown <= 3)", "AG EF (Shown >= 3)")]
    for question in questions:
        found = question.decided(Budget(MEMORY, seconds=seconds))
        asked = " ".join(each for each in vars(question).values() if isinstance(each, str))
        say(f"{type(question).__name__} {asked}", _known(found.status))
    space = state_space(net, budget=Budget(MEMORY, seconds=seconds))
    say("state space", space.states if space.complete else None)


def checked(seconds: float, say: Say) -> None:
    """Check the case study."""
    report = check(build(), Budget(MEMORY, seconds=20 * seconds))
    for finding in report.findings:
        say(f"{finding.rule} {' '.join(finding.elements)}", "found")
    for text in report.proved:
        say(text, "proved")


def _known(status: str) -> str | None:
    return None if status == "unknown" else status


def answers(ask: Ask, seconds: float, off: type[Method] | None) -> tuple[dict[str, Any], set[str]]:
    """Ask in a process of its own, without a method; return the answers, and the methods that were asked."""
    context = multiprocessing.get_context("fork")
    here, there = context.Pipe(duplex=False)
    process = context.Process(target=_answer, args=(ask, seconds, off, there))
    process.start()
    there.close()
    found: dict[str, Any] = {}
    asked: set[str] = set()
    try:
        while True:
            name, value = here.recv()
            if name == "":
                asked.add(value)
            elif value is not None:
                found[name] = value
    except EOFError:
        process.join()
    return found, asked


def _answer(ask: Ask, seconds: float, off: type[Method] | None, there: Connection) -> None:
    # Budgets look at this clock: what else the machine does costs a question nothing.
    time.perf_counter = time.process_time
    for kind in kinds().values():
        _replace(kind, off, there)
    ask(seconds, lambda name, value: there.send((name, value)))


def _replace(kind: type[Method], off: type[Method] | None, there: Connection) -> None:
    """Switch a method off, or let it say that it was asked."""
    for name in ("answer", "answer_all"):
        own = getattr(kind, name)

        def asked(self: Method, *given: Any, own: Any = own) -> Any:
            there.send(("", kind.__name__))
            return own(self, *given)

        def silent(self: Method, *given: Any) -> None:
            return None

        setattr(kind, name, silent if kind is off else asked)


def compared(name: str, ask: Ask, seconds: float) -> Iterator[str]:
    """Yield a row for each method that is asked."""
    known = kinds()
    answers(ask, seconds, None)  # compiles kernels
    full, asked = answers(ask, seconds, None)
    yield f"| {name} | none | {len(full)} | | |"
    for kind in sorted(asked):
        less, _ = answers(ask, seconds, known[kind])
        lost = [f"{one}: {full[one]}" for one in full if one not in less]
        lost += [
            f"{one}: {full[one]}, else {less[one]}" for one in full if less.get(one, full[one]) != full[one]
        ]
        more = [one for one in less if one not in full]
        yield f"| {name} | {kind} | {len(less)} | {'; '.join(lost)} | {'; '.join(more)} |"


def main(arguments: list[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0] if __doc__ else None)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--seconds", type=float, default=1.0, help="of processor time for each question (1)")
    parser.add_argument("--nets", nargs="*", default=[], help="words in the names of nets; all by default")
    parser.add_argument("--most", type=int, default=4, help="questions of each file of a net (4)")
    given = parser.parse_args(arguments)
    print("| net | without | answers | missing | only then |\n|---|---|---|---|---|", flush=True)
    for name, ask in asked(given.folder, given.nets, given.most):
        for row in compared(name, ask, given.seconds):
            print(row, flush=True)


def asked(place: Path, words: list[str], most: int) -> Iterator[tuple[str, Ask]]:
    """Yield what is asked, by name."""
    named: dict[str, Ask] = {"case-study-check": checked}
    named |= {f"case-study-{signals}": partial(case_study, signals) for signals in SIGNALS}
    for name, ask in named.items():
        if not words or any(word in name for word in words):
            yield name, ask
    for archive in sorted((place / "nets").glob("*.tgz")):
        if not words or any(word in archive.stem for word in words):
            with tempfile.TemporaryDirectory() as unpacked:
                unpack(archive, Path(unpacked))
                yield archive.stem, partial(contest, Path(unpacked, archive.stem, "model.pnml"), most)


if __name__ == "__main__":
    main()
