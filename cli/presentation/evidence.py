"""Evidence on the command line: finds, writes and prints it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import note, summarise, warn
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.questions.net_questions import Question
    from dineros.analysis.timed.nets import TimedNet
    from dineros.analysis.timed_checks.timed_checked import TimedChecked
    from dineros.analysis.witnesses.findings import Report
    from dineros.metamodel import pn

SHARE = 0.3
"""Share of the time for the search of a certificate before the engines run."""

SECONDS = 30.0
"""The same in seconds if no time is given."""


def refuse_certificates(output: Path, *, also_folder: bool = False) -> None:
    """Check before long work that certificates can be written; raises `ModelFileError`."""
    from dineros.cli.outputs import refuse_output
    from dineros.metamodel.errors import Location, ModelFileError

    if not also_folder or output.suffix == ".json":
        refuse_output(output, [".json"])
    elif output.exists() and not output.is_dir():
        raise ModelFileError(
            "is not a folder", location=Location(output), hint="or name a file such as a.json"
        )
    elif not output.parent.is_dir():
        missing = f"there is no folder {str(output.parent)!r}"
        raise ModelFileError(missing, location=Location(output), hint="make it first")


def certified(asked: Asked, answer: Outcome, output: Path, budget: Budget) -> tuple[Outcome | None, str]:
    """Write the certificate of an answer.

    Returns
    -------
    answer : Outcome or None
        The answer with its evidence; None without a certificate.
    reason : str
        Why there is none, unless the kind of evidence is the reason.
    """
    from dataclasses import replace

    from dineros.analysis.answers.budget import RAN_OUT, BudgetExceededError
    from dineros.analysis.evidence.certificate import write_certificate
    from dineros.analysis.evidence.proving import certificate_of
    from dineros.analysis.evidence.timed_proving import timed_certificate
    from dineros.analysis.questions.engines import WITHOUT_TIMES

    reason = ""
    if asked.subject.is_timed and answer.by.endswith(WITHOUT_TIMES):
        found, reason = None, "the question is answered without times: write the certificate without --time"
    elif asked.subject.is_timed:
        reason = "certificates cannot express properties of several moments of a run, or priorities"
        try:
            found = timed_certificate(asked, answer, budget)
        except BudgetExceededError as limit:
            found, reason = None, f"{RAN_OUT.get(str(limit), str(limit))} before the certificate was checked"
    else:
        found = certificate_of(asked, answer.status, answer.evidence)
    if found is None:
        return None, reason
    write_certificate(found, output)
    return replace(answer, reason=answer.reason or f"by {facts_text(found)}"), ""


def check_certificates(
    report: Report,
    model: pn.Net,
    settings: Sequence[str],
    output: Path,
    budget: Budget,
    with_times: TimedChecked | None = None,
) -> int:
    """Write certificates of the proofs of a check: one for all into a file, or one each into a folder.

    Those of a check with times are about all its state classes.

    Returns
    -------
    int
        The number of answers with a certificate.
    """
    from dineros.analysis.evidence.certificate import write_certificate
    from dineros.analysis.evidence.claims import certificates_of
    from dineros.analysis.evidence.timed_claims import timed_certificates_of

    if with_times is None:
        found, all_of_it = certificates_of(model, report, settings, share_of(budget))
    else:
        found, all_of_it = timed_certificates_of(with_times, settings, budget)
    if output.suffix == ".json":
        if all_of_it is not None:
            write_certificate(all_of_it, output)
        return 0 if all_of_it is None else len(found)
    output.mkdir(exist_ok=True)
    for name, certificate in found:
        write_certificate(certificate, output / f"{name}.json")
    return len(found)


def share_of(budget: Budget) -> Budget:
    """Return the part of a budget for the search of a certificate."""
    from dineros.analysis.answers.budget import Budget

    seconds = SECONDS if budget.left is None else SHARE * budget.left
    return Budget(budget.memory_bytes, seconds=seconds, progress=budget.progress)


def say_certificate(output: Path, answer: Outcome, is_written: bool, why_not: str, as_json: bool) -> None:
    """Print that a certificate was written, or why there is none."""
    if is_written and not as_json:
        summarise(f"certificate: {output}")
    elif not is_written:
        shown = "a run" if answer.stem or answer.loop else "all markings"
        if answer.evidence is not None:
            shown = f"{answer.by}, which a certificate can hold only in part"
        reason = why_not or f"the answer depends on {shown}"
        reason = "nothing is answered" if answer.status == "unknown" else reason
        warn(f"{output} is not written: {reason}")


def facts_text(certificate: Mapping[str, Any]) -> str:
    """Return the content of a certificate in words."""
    if "schedule" in certificate:
        classes, firings = len(certificate["classes"]), len(certificate["schedule"])
        held = f"{classes:,} state class{'es' * (classes != 1)}"
        return held if classes else f"a schedule of {counted(firings, 'firing')}"
    weights, clauses, steps = len(certificate["never"]), len(certificate["clauses"]), certificate["steps"]
    parts = [counted(weights, "weighting") + " of places"] if weights else []
    parts += [counted(clauses, "clause")] if clauses else []
    parts += [f"induction over {counted(steps, 'step')}"] if steps else []
    return ", ".join(parts) or "the formula alone"


def confirmed(
    question: Question, answer: Outcome, budget: Budget, timed: TimedNet | None = None
) -> tuple[Outcome, Confirmation | None]:
    """Confirm an answer about all markings by other engines, with times if given; unknown on dispute."""
    from dataclasses import replace

    from dineros.analysis.evidence.confirmation import confirm_answer, rests_on_markings

    if not rests_on_markings(answer):
        return answer, None
    if timed is None:
        confirmation = confirm_answer(question, answer, budget)
    else:
        from dineros.analysis.evidence.timed_confirmation import confirm_timed_answer

        confirmation = confirm_timed_answer(timed, question, answer, budget)
    if confirmation.agrees is False:
        answer = replace(answer, status="unknown", reason=str(confirmation))
    return answer, confirmation


def add_confirmation(report: Report, confirmation: Confirmation) -> None:
    """Add the confirmation of other engines to the report of a check."""
    from dineros.analysis.answers.outcome import Outcome

    if confirmation.agrees:
        report.proved.append(f"{' and '.join(confirmation.by)} found the same markings")
    else:
        is_fault = confirmation.agrees is False
        question = "answers that depend on all markings" if is_fault else "whether others agree"
        report.unknown.append(Outcome.left_open(question, str(confirmation), may_be_fault=is_fault))


def confirm_with_times(checked: TimedChecked, budget: Budget) -> dict[str, Confirmation]:
    """Confirm the answers of a check with times, and add the engines to its report."""
    from dineros.analysis.evidence.timed_check_confirmation import add_confirmations, confirm_timed_check

    told = confirm_timed_check(checked, budget)
    add_confirmations(checked.report, told)
    return told


def _say_of(what: str, confirmation: Confirmation, as_json: bool, more: str = "") -> None:
    """Print the confirmation of an answer; with JSON, only problems, on standard error."""
    if confirmation.agrees is False:
        warn(f"ERROR: {what}{confirmation} (one of them is wrong: please report it, with the model)")
    elif confirmation.agrees is None:
        warn(f"{what}{confirmation}")
    elif not as_json:
        summarise(f"{what}{confirmation}{more}")


def say_confirmed_questions(told: Mapping[str, Confirmation], as_json: bool = False) -> None:
    """Print for each question of a check which engine confirmed its answer."""
    for what, confirmation in told.items():
        _say_of(f"{what}: ", confirmation, as_json)
    if not told:
        warn("nothing to confirm: no answer depends on all state classes")


def say_confirmation(confirmation: Confirmation | None, as_json: bool = False) -> None:
    """Print which engine confirmed an answer; on standard error if none did or JSON is printed."""
    if confirmation is None:
        note("nothing to confirm: the answer does not depend on all markings")
    else:
        _say_of("", confirmation, as_json)


def say_confirmations(confirmations: Mapping[str, Confirmation], as_json: bool = False) -> None:
    """Print which engine confirmed the answers of a property file, and the ids of unconfirmed ones."""
    said: dict[Confirmation, list[str]] = {}
    for id, confirmation in confirmations.items():
        said.setdefault(confirmation, []).append(id)
    for confirmation, ids in said.items():
        if confirmation.agrees:
            _say_of("", confirmation, as_json, f": {counted(len(ids), 'answer')}")
        else:
            _say_of(f"{', '.join(ids)}: ", confirmation, as_json)
    if not confirmations:
        note("nothing to confirm: no answer depends on all markings")
