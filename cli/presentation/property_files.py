"""Property files of the Model Checking Contest on the command line: all answered at once, or written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.analysing import HOLDS, UNKNOWN, VIOLATED
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.presentation.scheduling import properties_on_workers
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.properties.property import GroupedNames, Property, PropertyAnswer


def answer_properties(
    subject: Subject,
    model: Path,
    wanted: Sequence[str],
    as_json: bool,
    scheduler: str | None = None,
    variant: tuple[str, str] = ("none", "weighted"),
    certificates: tuple[Path, Sequence[str]] | None = None,
) -> int:
    """Answer property files, and global questions by name, each as soon as it is; return the exit status.

    Where a scheduler is named, its workers answer; they flatten a system model by the variant of signals and
    of overflow. Certificates go into a folder; they name how the model was changed.
    """
    from dineros.analysis.properties import answering
    from dineros.analysis.properties.property import PropertyAnswer

    run = search()
    properties, names = _read(subject, wanted)
    found: dict[str, PropertyAnswer] = {}

    def tell(answer: PropertyAnswer) -> None:
        found[answer.id] = answer
        if not as_json and answer.value is not None:
            say(_line(answer))
        run.refresh()

    def say_rest(why: str) -> int:
        spent = run.limits.spent
        answers = [found.get(one.id) or PropertyAnswer(one.id, None, spent, reason=why) for one in properties]
        if as_json:
            rows = [
                {"kind": one.kind, "status": _status(answer.value)}
                | {name: getattr(answer, name) for name in ("id", "value", "seconds", "technique", "reason")}
                for one, answer in zip(properties, answers, strict=True)
            ]
            say_json({"model": str(model), "properties": rows})
        else:
            for answer in answers:
                if answer.value is None:
                    say(_line(answer))
        values = [answer.value for answer in answers]
        if any(value is False for value in values):
            return VIOLATED
        return UNKNOWN if None in values else HOLDS

    run.draft(say_rest)
    budget = run.budget()
    seconds = answering.SECONDS if budget.seconds is None else budget.seconds / max(1, len(properties))
    if scheduler is None:
        answering.answer_properties(subject.net, names, properties, seconds, budget.memory, tell, run.stage)
    else:
        run.stage(f"asking the workers of {scheduler}")
        asked = {"signals": variant[0], "overflow": variant[1]}
        limits = {"memory": run.limits.memory, "seconds": seconds}
        properties_on_workers(subject, scheduler, {**asked, **limits}, properties, names, tell)
    with run.answer():
        status = say_rest("time or memory did not suffice")
    if certificates is not None:
        folder, settings = certificates
        run.draft(lambda ending: _not_written(folder, ending, status))
        run.stage("writing certificates")
        count = _write_certificates(subject, properties, names, found, variant, folder, settings)
        if not as_json:
            summarise(f"certificates: {folder}: {count}")
    return status


def _not_written(folder: Path, ending: str, status: int) -> int:
    warn(f"{folder} is not complete: {ending}")
    return status or UNKNOWN


def _write_certificates(
    subject: Subject,
    properties: Sequence[Property],
    names: GroupedNames,
    found: Mapping[str, PropertyAnswer],
    variant: tuple[str, str],
    folder: Path,
    settings: Sequence[str],
) -> int:
    """Write a certificate of each answer that rests on structure or induction; return how many."""
    from dineros.analysis.evidence.certificate import write_certificate
    from dineros.analysis.evidence.claims import file_name, property_certificate
    from dineros.analysis.evidence.proving import Asked

    asked, count = Asked(subject, "", "", *variant, settings), 0
    folder.mkdir(exist_ok=True)
    for one in properties:
        known = one.id in found
        certificate = property_certificate(asked, one, names, found[one.id]) if known else None
        if certificate is not None:
            write_certificate(certificate, folder / f"{file_name(one.id)}.json")
            count += 1
    return count


def write_properties(subject: Subject, wanted: Sequence[str], output: Path) -> int:
    """Write what property files ask anew, as one file."""
    properties, names = _read(subject, wanted)
    return _write(subject, properties, names, output)


def write_formula(subject: Subject, model: Path, ltl: str | None, ctl: str | None, output: Path) -> int:
    """Write a formula as a property file; its id is that of the model and of the logic."""
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.properties.property import Property

    name = model.name.split(".")[0]
    if ltl is not None:
        one = Property(f"{name}-LTL-00", "ltl", parse(ltl))
    else:
        assert ctl is not None
        one = Property(f"{name}-CTL-00", "ctl", parse(ctl, "ctl"))
    return _write(subject, [one], subject.names, output)


def _write(subject: Subject, properties: Sequence[Property], names: Any, output: Path) -> int:
    from dineros.analysis.properties import writing

    writing.write_properties(output, properties, subject.net, names)
    number = len(properties)
    summarise(f"{output}: {number} {'property' if number == 1 else 'properties'}")
    return HOLDS


def _read(subject: Subject, wanted: Sequence[str]) -> tuple[list[Property], GroupedNames]:
    from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
    from dineros.analysis.properties.reading import read_properties

    names = GroupedNames(subject.names)
    found: dict[str, Property] = {}
    for name in wanted:
        new = (
            [Property(name, "global", examination=name)]
            if name in GLOBAL_PROPERTIES
            else read_properties(name, names)
        )
        for one in new:
            if one.id in found:
                raise click.UsageError(f"{one.id!r} is asked twice")
            found[one.id] = one
    return list(found.values()), names


def _status(value: bool | int | None) -> str:
    if value is None:
        return "unknown"
    return ("holds" if value else "violated") if isinstance(value, bool) else "bound"


def _line(answer: PropertyAnswer) -> str:
    status = _status(answer.value)
    shown = str(answer.value) if status == "bound" else status
    how = answer.technique or answer.reason
    return f"{shown}: {answer.id}; {how}, {answer.seconds:.1f} s"
