"""Asking one question: proved with a certificate, of an engine or of a scheduler's workers, and confirmed."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.presentation.evidence import (
    certified,
    confirmed,
    proved_first,
    refuse_certificates,
    say_certificate,
    say_confirmation,
)
from dineros.cli.presentation.scheduling import answer_on_workers

if TYPE_CHECKING:
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.evidence.proving import Asked
    from dineros.analysis.questions.engines import Question
    from dineros.cli.searching import Search


@dataclass
class Backing:
    """What backs an answer, where that is wanted.

    Attributes
    ----------
    certificate : Path or None
        Where a certificate is wanted.
    confirm : bool
        Whether others are to decide again what rests on all markings.
    is_proved : bool
        Whether the certificate is written.
    confirmation : Confirmation or None
        What the others say.
    """

    certificate: Path | None
    confirm: bool
    is_proved: bool = False
    confirmation: Confirmation | None = None

    def to_dict(self) -> dict[str, object]:
        """Return what is wanted of it for JSON."""
        fields: dict[str, object] = {}
        if self.certificate is not None:
            fields["certificate"] = str(self.certificate) if self.is_proved else None
        if self.confirm:
            fields["confirmation"] = self.confirmation.to_dict() if self.confirmation else None
        return fields

    def say(self, answer: Outcome, as_json: bool) -> None:
        """Say what is wanted of it."""
        if self.certificate is not None:
            say_certificate(self.certificate, answer, self.is_proved, as_json)
        if self.confirm and (self.confirmation is not None or answer.status != "unknown"):
            say_confirmation(self.confirmation, as_json)


def answered(
    asked: Asked,
    question: Question,
    run: Search,
    backing: Backing,
    engine: str = "auto",
    scheduler: str | None = None,
    **more: Any,
) -> Outcome:
    """Answer a question, backed as is wanted.

    Parameters
    ----------
    asked, question
        The same question, as certificates and as engines know it.
    run : Search
        What it may cost.
    backing : Backing
        Is told what backs the answer.
    engine : str
        As `--engine` has it.
    scheduler : str, optional
        Whose workers answer instead.
    **more
        What workers are to know besides.

    Raises
    ------
    FormulaError
        The question cannot be read, or names something unknown.
    DinerosError
        The engine or the scheduler is not there, failed, or does not know such questions.
    """
    from dineros.analysis.questions.engines import ENGINES

    budget, answer = run.budget(), None
    if backing.certificate is not None:
        refuse_certificates(backing.certificate)
        run.stage("looking for a proof")
        answer = proved_first(asked, budget)
    if answer is None and scheduler is not None:
        run.stage(f"asking the workers of {scheduler}")
        told = {"kind": asked.kind, "text": asked.text, "signals": asked.signals, "overflow": asked.overflow}
        limits = run.limits
        answer = answer_on_workers(asked.subject, scheduler, {**told, **more}, limits.memory, limits.left)
    elif answer is None:
        answer = ENGINES[engine].answer(question, budget)
    if backing.certificate is not None and answer.evidence is not None:
        run.stage("writing the certificate")
        backed = certified(asked, answer, backing.certificate)
        backing.is_proved, answer = backed is not None, backed or answer
    if backing.confirm and not backing.is_proved:
        run.stage("confirming the answer")
        answer, backing.confirmation = confirmed(question, answer, budget)
    return answer
