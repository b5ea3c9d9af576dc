"""Compares declared times with those of a run, and reports findings of `dineros conform`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from dineros.analysis.conformance import Verdict
    from dineros.analysis.conformance.conform import Trace
    from dineros.analysis.witnesses.findings import Fault, Report
    from dineros.metamodel import sym
    from dineros.observation.measuring.declared import Breach


@dataclass(frozen=True)
class ComparedTimes:
    """The result of the comparison."""

    breaches: list[Breach] = field(default_factory=list)
    """Declared times that the run violates."""
    compared: int = 0
    """Times of the run for which something is declared."""
    is_simulated: bool = False
    """Whether the run was simulated: then nothing is compared."""
    allowance: float = 0.0
    """Seconds by which a time could pass its bound."""

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "compared": self.compared,
            "simulated": self.is_simulated,
            "allowance": self.allowance,
            "violations": [each.to_dict() for each in self.breaches],
        }


def compared_times(model: sym.SystemModel, traces: Mapping[str, Trace], allowance: float) -> ComparedTimes:
    """Compare the times in the traces of a run with those that its model declares.

    Raises
    ------
    RecordError
        A line of a trace is not a record.
    """
    from dineros.observation.measuring.declared import Comparison
    from dineros.observation.measuring.journals import JournalTimes

    comparison = Comparison(model, allowance)
    if not comparison.is_needed:
        return ComparedTimes(allowance=allowance)
    times = JournalTimes(model, traces)
    for seen in times.seen():
        comparison.take(seen, times.begun or 0.0)
    return ComparedTimes(comparison.breaches(), comparison.compared, times.is_simulated, allowance)


def faults() -> dict[str, Fault]:
    """Return the kinds of findings of a comparison with a run, by name."""
    from dineros.analysis.witnesses.findings import Fault

    told = {
        "step-not-allowed": "A recorded step is not a firing that the model allows.",
        "duration-too-long": "A callback or handler took longer than its declared duration.",
        "duration-too-short": "A callback or handler took less than its declared duration.",
        "latency-too-long": "A message was on its way for longer than its declared latency.",
        "latency-too-short": "A message was on its way for less than its declared latency.",
        "period-too-long": "A timer struck later than its declared period and jitter allow.",
        "period-too-short": "A timer struck earlier than its declared period and jitter allow.",
    }
    return {rule: Fault(rule, "error", meaning, "{text}") for rule, meaning in told.items()}


def report_of(verdict: Verdict, breaches: Sequence[Breach]) -> Report:
    """Return the findings as a report, for the formats of continuous integration."""
    from dineros.analysis.answers.outcome import Outcome
    from dineros.analysis.witnesses.findings import Report

    known = faults()
    steps = known["step-not-allowed"]
    findings = []
    for deviation in verdict.violations:
        record = deviation.record
        element = getattr(record, "transition", None) or getattr(record, "place", None) or record.node or ""
        findings.append(steps.found(str(element), text=f"{deviation.location}: {deviation}"))
    for breach in breaches:
        part = breach.part
        elements = [each for each in (part.element, part.writer, part.reader) if each]
        findings.append(known[breach.rule].found(*elements, text=str(breach)))
    report = Report(findings=findings)
    report.unknown.extend(Outcome.left_open(str(each), each.step) for each in verdict.unknown)
    if verdict.status == "conforms":
        report.proved.append("every recorded step is a firing that the model allows")
    return report
