"""Decides questions on the workers of a Dask scheduler, and collects their answers."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.properties.property import GroupedNames, Property, PropertyAnswer
    from dineros.analysis.sweeps.parts import PartAnswer
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel import pn


def answer_on_workers(
    subject: Subject,
    address: str,
    asked: Mapping[str, Any],
    memory: int | None,
    timeout: float | None,
) -> Outcome:
    """Run all engines, and diagrams from several starts, at the same time; return the first answer.

    Each formula of a conjunction is decided separately, and a violation of one of them ends the others.

    Raises
    ------
    FormulaError
        The question cannot be read, or names something unknown.
    SweepError
        The scheduler, or its workers, cannot be reached or used.
    """
    from contextlib import closing

    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.sweeps.cluster import cluster_answers
    from dineros.analysis.sweeps.parts import all_of, check_names, conjuncts, question_parts
    from dineros.metamodel.files.xmi import xmi_bytes

    check_names(subject, asked["kind"], asked["text"])
    model, work = xmi_bytes(subject.model).decode(), uuid.uuid4().hex
    texts = list(dict.fromkeys(conjuncts(asked["kind"], asked["text"])))
    parts = [
        part
        for text in texts
        for part in question_parts(model, {**asked, "text": text}, _of_engines(memory), timeout, work)
    ]
    known, answer = dict[str, Outcome](), None
    with closing(cluster_answers(parts, address)) as answers:
        for part, said in answers:
            text = part.asked["text"]
            if known.get(text, Outcome("unknown")).status == "unknown":
                known[text] = said
            answer = all_of(known, texts)
            if answer is not None and answer.status != "unknown":
                break
    return answer or Outcome("unknown", reason="no answer")


def _of_engines(memory: int | None) -> int | None:
    from dineros.analysis.nets.memory import OWN_MEMORY

    return None if memory is None else memory - OWN_MEMORY


def properties_on_workers(
    subject: Subject,
    address: str,
    asked: Mapping[str, Any],
    properties: Sequence[Property],
    names: GroupedNames,
    answered: Callable[[PropertyAnswer], None],
) -> None:
    """Distribute properties to workers, and print their answers as they come; raises as the other."""
    from contextlib import closing

    from dineros.analysis.sweeps.cluster import cluster_answers
    from dineros.analysis.sweeps.parts import property_answers, property_parts
    from dineros.metamodel.files.xmi import xmi_bytes

    told = {**asked, "memory": _of_engines(asked["memory"])}
    parts = property_parts(xmi_bytes(subject.model).decode(), told, properties, names, uuid.uuid4().hex)
    with closing(cluster_answers(parts, address)) as found:
        for part, answer in found:
            for one in property_answers(part, answer):
                answered(one)


def check_on_workers(
    model: pn.Net,
    address: str,
    report: Report,
    *,
    at_any_cost: bool,
    memory: int | None,
    is_confirmed: bool = False,
) -> Confirmation | None:
    """Run a check on workers, and add their answers to a report as they come; raises as the others.

    Returns
    -------
    Confirmation or None
        The confirmation of a worker, if requested.
    """
    from contextlib import closing

    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.sweeps.cluster import cluster_answers
    from dineros.analysis.sweeps.parts import add_report, check_parts
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel.files.xmi import xmi_bytes

    text, engines = xmi_bytes(model).decode(), _of_engines(memory)
    parts = check_parts(text, at_any_cost, engines, uuid.uuid4().hex, is_confirmed)
    subject, said = base_subject(model), None
    answers: dict[tuple[str, ...], PartAnswer] = {}
    with closing(cluster_answers(parts, address)) as found:
        for part, answer in found:
            if part.asked.get("confirm"):
                said = Confirmation(None, reason=answer.reason) if isinstance(answer, Outcome) else answer
                continue
            answers[part.questions] = answer
            told = Report()
            for each in parts:  # in the order of the parts, not of their ends
                if each.questions in answers:
                    add_report(told, subject, each, answers[each.questions])
            report.findings, report.unknown = told.findings, told.unknown
            report.proved, report.assumed = told.proved, told.assumed
            search().refresh()
    return said
