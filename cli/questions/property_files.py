"""Property files of the Model Checking Contest on the command line: all answered at once, or written."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.analysing import HOLDS, UNKNOWN, VIOLATED, load_valid, reading_formula
from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.options import invocation
from dineros.cli.presentation.answers import say_times, times_fields
from dineros.cli.presentation.evidence import refuse_certificates, say_confirmations
from dineros.cli.presentation.scheduling import properties_on_workers
from dineros.cli.searching import search
from dineros.metamodel.errors import DinerosError, Location

if TYPE_CHECKING:
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.model.times import LeftOutTimes
    from dineros.analysis.nets.compiled import CompiledNet
    from dineros.analysis.properties.property import GroupedNames, Property, PropertyAnswer
    from dineros.cli.questions.asking import Asking
    from dineros.metamodel import pn


def answer_properties(asking: Asking, wanted: Sequence[str], written: Path | None) -> int:
    """Answer property files, and global questions by name, one by one; return the exit status.

    If a scheduler is given, its workers answer. Certificates go into a folder. If a file is to be written,
    all questions are written there instead.
    """
    from dineros.analysis.evidence.confirmation import confirm_properties
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.portfolio import answering
    from dineros.analysis.properties.property import PropertyAnswer

    folder = asking.certificate
    if folder is not None:
        if asking.scheduler is not None or folder.suffix == ".json":
            raise click.UsageError("of a property file, --certificate is a folder, and no scheduler's matter")
        refuse_certificates(folder, also_folder=True)
    run, subject = search(), asking.subject()
    properties, names = _read(subject, wanted)
    if written is not None:
        return _write(subject, properties, names, written)
    found: dict[str, PropertyAnswer] = {}
    confirmations: dict[str, Confirmation] = {}

    def tell(answer: PropertyAnswer) -> None:
        found[answer.id] = answer
        if not asking.as_json and answer.value is not None:
            say(_line(answer))
        run.refresh()

    def say_rest(why: str) -> int:
        spent = run.limits.spent
        answers = [found.get(one.id) or PropertyAnswer(one.id, None, spent, reason=why) for one in properties]
        if asking.as_json:
            rows = [
                {"kind": one.kind, "status": _status(answer.value)}
                | {name: getattr(answer, name) for name in ("id", "value", "seconds", "technique", "reason")}
                | times_fields(asking.times, _is_of_all_runs(one, answer, subject.net))
                for one, answer in zip(properties, answers, strict=True)
            ]
            if asking.confirm:
                said = {id: one.to_dict() for id, one in confirmations.items()}
                rows = [row | {"confirmation": said.get(str(row["id"]))} for row in rows]
            say_json({"model": str(asking.model), "properties": rows})
        else:
            for answer in answers:
                if answer.value is None:
                    say(_line(answer))
            _say_times(asking.times, properties, answers, subject.net)
        values = [answer.value for answer in answers]
        if any(value is False for value in values):
            return VIOLATED
        return UNKNOWN if None in values else HOLDS

    run.draft(say_rest)
    budget = run.budget().begun()
    seconds = answering.SECONDS if budget.seconds is None else budget.seconds / max(1, len(properties))
    if asking.scheduler is None:
        answering.answer_properties(subject.net, names, properties, seconds, budget.memory, tell, run.stage)
    else:
        run.stage(f"using the workers of {asking.scheduler}")
        asked = {"signals": asking.signals, "overflow": asking.overflow}
        limits = {"memory": run.limits.memory, "seconds": seconds}
        properties_on_workers(subject, asking.scheduler, {**asked, **limits}, properties, names, tell)
    if asking.confirm:
        run.stage("confirming the answers")
        confirmations = confirm_properties(subject.net, names, properties, found, budget)
        for id, one in confirmations.items():
            if one.agrees is False:
                tell(replace(found[id], value=None, technique="", reason=str(one)))
    with run.answer():
        status = say_rest("time or memory did not suffice")
        if asking.confirm:
            say_confirmations(confirmations, asking.as_json)
    if folder is not None:
        run.draft(lambda ending: _not_written(folder, ending, status))
        run.stage("writing certificates")
        blank = Asked(subject, "", "", asking.signals, asking.overflow, asking.settings)
        count = _write_certificates(blank, properties, names, found, folder)
        if not asking.as_json:
            summarise(f"certificates: {folder}: {count}")
    return status


def _not_written(folder: Path, ending: str, status: int) -> int:
    warn(f"{folder} is not complete: {ending}")
    return status or UNKNOWN


def _write_certificates(
    asked: Asked,
    properties: Sequence[Property],
    names: GroupedNames,
    found: Mapping[str, PropertyAnswer],
    folder: Path,
) -> int:
    """Write a certificate of each answer by structure or induction; return their number."""
    from dineros.analysis.evidence.certificate import write_certificate
    from dineros.analysis.evidence.claims import file_name, property_certificate

    count = 0
    folder.mkdir(exist_ok=True)
    for one in properties:
        known = one.id in found
        certificate = property_certificate(asked, one, names, found[one.id]) if known else None
        if certificate is not None:
            write_certificate(certificate, folder / f"{file_name(one.id)}.json")
            count += 1
    return count


def write_formula(subject: Subject, model: Path, logic: str, formula: str, output: Path) -> int:
    """Write a formula as a property file; its id is that of the model and of the logic."""
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.properties.property import Property

    name = f"{model.name.split('.')[0]}-{logic.upper()}-00"
    one = Property(name, logic, parse(formula, logic))  # type: ignore[arg-type]
    return _write(subject, [one], subject.names, output)


def write_stored(model: Path, settings: Sequence[str], overflow: str, output: Path) -> int:
    """Write the properties that a model stores as a property file of the contest.

    Raises
    ------
    DinerosError
        The model stores none that such a file can express.
    """
    from lxml import etree

    from dineros.analysis.logic.language.bounded import Bounded
    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.properties import writing
    from dineros.analysis.properties.property import Property
    from dineros.analysis.requirements.latency_bounds import latency_bound
    from dineros.analysis.requirements.listing import properties_of
    from dineros.analysis.requirements.stored import read

    net = load_valid(model, settings)
    subject = base_subject(net, overflow)  # type: ignore[arg-type]
    said: list[Property] = []
    for property in properties_of(net):
        if latency_bound(property) is not None:
            warn(f"{model}: property {property.id} is left out: the contest's formulas bound no latencies")
            continue
        with reading_formula(f"property {property.id}"):
            reading = read(property)
        one = Property(str(property.id), *reading.as_formula())
        try:
            if isinstance(reading.formula, Bounded):
                raise DinerosError("the contest's formulas bound no times")
            if str(property.signals) != "none":
                raise DinerosError("the contest's nets have no signals")
            with reading_formula(f"property {property.id}"):
                writing.add_property(etree.Element("attempt"), one, subject.net, subject.names)
        except DinerosError as error:
            warn(f"{model}: property {property.id} is left out: {error.message}")
        else:
            said.append(one)
    if not said:
        raise DinerosError(
            "the model stores no property that can be written to a property file",
            location=Location(model),
            hint="see --ltl, --ctl",
        )
    return _write(subject, said, subject.names, output)


def take_in(net: pn.Net, file: str, model: Path) -> int:
    """Store the formulas of a property file of the contest in a system model; return how many.

    Raises
    ------
    DinerosError
        The net is not a system model, the file cannot be read, or an id is used already.
    """
    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.properties.property import GroupedNames
    from dineros.analysis.properties.reading import read_properties
    from dineros.metamodel import sym

    if not isinstance(net, sym.SystemModel):
        raise DinerosError("only a system model stores properties", location=Location(model))
    names = GroupedNames(base_subject(net).names)
    taken = {element.id for element in net.eAllContents() if hasattr(element, "id")}
    count = 0
    for one in read_properties(file, names, partial(_note, file)):
        if one.formula is None:
            warn(f"{file}: {one.id} is left out: a model stores formulas only")
            continue
        if one.id in taken:
            raise DinerosError(f"the model has an element {one.id!r} already", location=Location(Path(file)))
        text = str(names.ungrouped(one.formula))
        net.properties.append(sym.Property(id=one.id, text=text, language=one.kind))
        taken.add(one.id)
        count += 1
    return count


def _write(subject: Subject, properties: Sequence[Property], names: Any, output: Path) -> int:
    from dineros.analysis.properties import writing

    writing.write_properties(output, properties, subject.net, names)
    number = len(properties)
    summarise(f"{output}: {number} {'property' if number == 1 else 'properties'}")
    return HOLDS


def _read(subject: Subject, wanted: Sequence[str]) -> tuple[list[Property], GroupedNames]:
    from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property, recognised
    from dineros.analysis.properties.reading import read_properties

    names = GroupedNames(subject.names)
    found: dict[str, Property] = {}
    for name in wanted:
        new = (
            [Property(name, "global", examination=name)]
            if name in GLOBAL_PROPERTIES
            else [recognised(one, subject.net) for one in read_properties(name, names, partial(_note, name))]
        )
        for one in new:
            if one.id in found:
                raise click.UsageError(f"{one.id!r} is given twice")
            found[one.id] = one
    return list(found.values()), names


def _is_of_all_runs(property: Property, answer: PropertyAnswer, net: CompiledNet) -> bool | None:
    """Return whether an answer still holds if the net has fewer runs; None for an unknown one.

    An upper bound still holds.
    """
    from dineros.analysis.model.times import is_of_all_runs
    from dineros.analysis.properties.property import said_of_all

    if answer.value is None:
        return None
    if property.kind in ("bound", "ltl"):
        return property.kind == "bound" or bool(answer.value)
    formula = property.formula or said_of_all(property.examination, net)
    return is_of_all_runs(formula, bool(answer.value))


def _say_times(
    times: LeftOutTimes | None,
    properties: Sequence[Property],
    answers: Sequence[PropertyAnswer],
    net: CompiledNet,
) -> None:
    """Print that times are ignored, and which answers hold with them."""
    if times is None:
        return
    of_all = [_is_of_all_runs(one, answer, net) for one, answer in zip(properties, answers, strict=True)]
    kept, lost = (
        [
            one.id
            for one, each in zip(properties, of_all, strict=True)
            if each is not None and times.survives(each) is wanted
        ]
        for wanted in (True, False)
    )
    parts = [f"also holds with times: {', '.join(kept)}"] if kept else []
    parts += [f"may not hold with times: {', '.join(lost)}"] if lost else []
    if any(one.kind == "bound" for one in properties):
        parts.append("a bound may be larger than the real one")
    say_times(times, "; ".join(parts) or "nothing is known")


def _note(file: str, text: str) -> None:
    if invocation().verbosity >= 0:
        warn(f"{file}: note: {text}")


def _status(value: bool | int | None) -> str:
    if value is None:
        return "unknown"
    return ("holds" if value else "violated") if isinstance(value, bool) else "bound"


def _line(answer: PropertyAnswer) -> str:
    status = _status(answer.value)
    shown = str(answer.value) if status == "bound" else status
    how = answer.technique or answer.reason
    return f"{shown}: {answer.id}; {how}, {answer.seconds:.1f} s"
