"""Decides one question by a certificate, an engine or workers; confirms and prints the answer."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.analysing import load_subject, write_witness
from dineros.cli.console import say_json
from dineros.cli.presentation.answers import (
    answer_and_times,
    assumes_field,
    say_assumes,
    say_times,
    times_fields,
)
from dineros.cli.presentation.evidence import (
    certified,
    confirmed,
    refuse_certificates,
    say_certificate,
    say_confirmation,
    share_of,
)
from dineros.cli.presentation.scheduling import answer_on_workers
from dineros.cli.questions.timed import load_timed_subject
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.answers.budget import Budget
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.model.times import LeftOutTimes
    from dineros.analysis.questions.net_questions import Question
    from dineros.analysis.witnesses.witness import Witness
    from dineros.metamodel import pn


@dataclass
class Asking:
    """The values of `question_options`: who answers a question, its evidence, and the output."""

    model: Path
    settings: tuple[str, ...]
    signals: str
    overflow: str
    """`model`, `settings`, `signals`, `overflow`: the model's file, its changes, and the flattening."""
    engine: str
    scheduler: str | None
    certificate: Path | None
    confirm: bool
    """`certificate`, `confirm`: where a certificate is wanted; whether others are to decide again what rests
    on all markings.
    """
    output: Path | None
    as_json: bool
    """`output`, `as_json`: where the run that shows the answer is written; whether JSON is printed."""
    timed: bool = False
    """Whether the answer is about the net with its firing intervals."""
    is_proved: bool = False
    """Whether the certificate is written."""
    no_certificate: str = ""
    """Why it is not, if that is not what the answer rests on."""
    confirmation: Confirmation | None = None
    times: LeftOutTimes | None = None
    """Firing intervals of the net, which no engine knows."""
    assumes: list[str] = field(default_factory=list)
    """Assumptions of answers about all runs, if the rules are stricter than ROS 2."""

    def refuse_tina_on_workers(self) -> None:
        """Reject options that exclude each other; raises `UsageError`."""
        if self.scheduler is not None and self.engine == "tina":
            raise click.UsageError("workers of a scheduler cannot run TINA")
        if self.timed and any((self.engine != "auto", self.scheduler)):
            raise click.UsageError("--time cannot be combined with --engine or --scheduler")

    def subject(self) -> Subject:
        """Read the model, reject an invalid one, and flatten and compile it."""
        if self.timed:
            return load_timed_subject(self.model, self.settings, self.signals, self.overflow)
        subject = load_subject(self.model, self.settings, self.signals, self.overflow)
        self.leave_out_times(subject.model)
        return subject

    def leave_out_times(self, model: pn.Net) -> None:
        """Store the firing intervals of a model, so that its answers name them."""
        from dineros.analysis.model.times import left_out_times

        self.times = left_out_times(model)

    def answer(
        self,
        subject: Subject,
        kind: str,
        text: str,
        question: Question,
        *,
        signals: str = "",
        ask: Callable[[Budget], Outcome] | None = None,
        **more: Any,
    ) -> Outcome:
        """Answer a question, with the requested evidence.

        Parameters
        ----------
        kind, text, question
            The same question, as certificates and as engines know it.
        signals : str
            How signals change in the net, if not as the options say.
        ask : callable, optional
            What answers instead of an engine.
        **more
            What workers are to know besides.

        Raises
        ------
        FormulaError
            The question cannot be read, or names something unknown.
        DinerosError
            The engine or the scheduler is not there, failed, or does not know such questions.
        """
        from dineros.analysis.evidence.proving import Asked, proved
        from dineros.analysis.questions.engines import ENGINES, Timed
        from dineros.analysis.timed.timed_subject import TimedSubject

        run, signals = search(), signals or self.signals
        asked = Asked(subject, kind, text, signals, self.overflow, self.settings)
        budget, answer = run.budget(), None
        if self.certificate is not None:
            refuse_certificates(self.certificate)
            run.stage("looking for a proof")
            answer = None if subject.is_timed else proved(asked, share_of(budget))
        if answer is None and self.scheduler is not None:
            run.stage(f"using the workers of {self.scheduler}")
            told = {"kind": kind, "text": text, "signals": signals, "overflow": self.overflow, **more}
            answer = answer_on_workers(subject, self.scheduler, told, run.limits.memory, run.limits.left)
        elif answer is None and ask is not None:
            answer = ask(budget)
        elif answer is None:
            engine = Timed(subject.timed) if isinstance(subject, TimedSubject) else ENGINES[self.engine]
            answer = engine.answer(question, budget)
        is_open = answer.status == "unknown"
        if self.certificate is not None and not is_open and (subject.is_timed or answer.evidence is not None):
            run.stage("writing the certificate")
            backed, self.no_certificate = certified(asked, answer, self.certificate, budget)
            self.is_proved, answer = backed is not None, backed or answer
        if self.confirm and (subject.is_timed or not self.is_proved):
            run.stage("confirming the answer")
            timed = subject.timed if isinstance(subject, TimedSubject) else None
            answer, self.confirmation = confirmed(question, answer, budget, timed)
        self.look_at_assumptions(subject, answer)
        return replace(answer, reason=run.reason(answer.reason))

    def look_at_assumptions(self, subject: Subject, answer: Outcome) -> None:
        """Store the assumptions of an answer: on simultaneous goals, shared services, and lifespans."""
        from dineros.analysis.model.assumptions import assumptions
        from dineros.analysis.questions.held_back import held_back

        if answer.status != "unknown":
            goals = [each.assumption for each in held_back(subject, search().budget().begun())]
            self.assumes = [*goals, *assumptions(subject.model, with_times=self.timed)]

    def tell(
        self,
        answer: Outcome,
        witness: Witness | None,
        asked: str,
        say: Callable[[], None],
        first: Mapping[str, object],
        *,
        is_universal: bool,
        is_shown_by_run: bool = False,
        is_timed: bool = True,
        **last: object,
    ) -> None:
        """Write the witness of an answer, print the answer, and its evidence.

        Parameters
        ----------
        asked : str
            The question in the words of the trace that is written.
        first, **last
            Further JSON keys of the question, and of the answer.
        is_universal : bool
            Whether the answer holds for all runs, and so for those with times.
        is_shown_by_run : bool
            Whether the answer stays if the net has more runs.
        is_timed : bool
            Whether JSON says the seconds.
        """
        if self.output is not None and witness is not None:
            write_witness(witness, self.output, self.model, self.settings, asked, answer.status)
        assumed = [] if is_shown_by_run or answer.status == "unknown" else self.assumes
        if self.as_json:
            timed = ("seconds",) if is_timed else ()
            told = {name: getattr(answer, name) for name in ("status", "reason", "by", "states", *timed)}
            shown = {"witness": witness.to_dict() if witness else None}
            times = times_fields(self.times, None if answer.status == "unknown" else is_universal)
            basis = {**times, **assumes_field(assumed), **self._backing()}
            say_json({"model": str(self.model), **first, **told, **shown, **last, **basis})
        else:
            say()
            say_assumes(assumed)
            if self.times is not None and answer.status != "unknown":
                say_times(self.times, answer_and_times(self.times, is_universal))
        if self.certificate is not None:
            say_certificate(self.certificate, answer, self.is_proved, self.no_certificate, self.as_json)
        if self.confirm and (self.confirmation is not None or answer.status != "unknown"):
            say_confirmation(self.confirmation, self.as_json)

    def _backing(self) -> dict[str, object]:
        """Return the evidence of the answer for JSON, if requested."""
        fields: dict[str, object] = {}
        if self.certificate is not None:
            fields["certificate"] = str(self.certificate) if self.is_proved else None
        if self.confirm:
            fields["confirmation"] = self.confirmation.to_dict() if self.confirmation else None
        return fields


def run_shown(subject: Subject, verdict: Outcome) -> Witness | None:
    """Return the run that shows a verdict on a formula, replayed; None without one."""
    from dineros.analysis.witnesses.witness import witness_of

    if not (verdict.stem or verdict.loop):
        return None
    loop = len(verdict.stem) if verdict.loop else None
    return witness_of(subject, [*verdict.stem, *verdict.loop], loop, verdict.times)
