"""Questions put on the workers of a Dask scheduler: the option, and how their answers come back."""

from __future__ import annotations

import uuid
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel import pn

F = TypeVar("F", bound=Callable[..., Any])


def scheduler_option(function: F) -> F:
    """Add `--scheduler`, the address of a Dask scheduler."""
    help = "Ask the workers of this Dask scheduler, such as tcp://10.0.0.1:8786."
    return click.option("--scheduler", metavar="ADDRESS", help=help)(function)


def answer_on_workers(
    subject: Subject,
    address: str,
    asked: Mapping[str, Any],
    memory: int | None,
    timeout: float | None,
) -> Outcome:
    """Ask all engines, and diagrams from several starts, at the same time; return the first answer.

    Raises
    ------
    FormulaError
        The question cannot be read, or names something unknown.
    SweepError
        The scheduler, or its workers, cannot be reached or used.
    """
    from dineros.analysis.sweeps.cluster import first_known
    from dineros.analysis.sweeps.parts import check_names, outcome_of, question_parts
    from dineros.metamodel.files.xmi import xmi_bytes

    check_names(subject, asked["kind"], asked["text"])
    model = xmi_bytes(subject.model).decode()
    parts = question_parts(model, dict(asked), _of_engines(memory), timeout, uuid.uuid4().hex)
    answer = first_known(parts, address, lambda found: found.get("status", "unknown") != "unknown")
    return outcome_of(subject.net, answer)


def _of_engines(memory: int | None) -> int | None:
    from dineros.analysis.nets.memory import OWN_MEMORY

    return None if memory is None else memory - OWN_MEMORY


def check_on_workers(
    model: pn.Net, address: str, report: Report, *, at_any_cost: bool, memory: int | None
) -> None:
    """Put the questions of a check on workers, and their answers into a report; raises as the other."""
    from contextlib import closing

    from dineros.analysis.model.subject import base_subject
    from dineros.analysis.sweeps.cluster import cluster_answers
    from dineros.analysis.sweeps.parts import add_report, check_parts
    from dineros.metamodel.files.xmi import xmi_bytes

    parts = check_parts(xmi_bytes(model).decode(), at_any_cost, _of_engines(memory), uuid.uuid4().hex)
    with closing(cluster_answers(parts, address)) as found:
        answers = {part.questions: answer for part, answer in found}
    subject = base_subject(model)
    for part in parts:  # in their order, whoever was first
        add_report(report, subject, part, answers[part.questions])
