"""The results of comparing traces with a model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from dineros.analysis.answers.outcome import Outcome
from dineros.metamodel.errors import Location
from dineros.metamodel.records import Record


@dataclass(frozen=True)
class Deviation:
    """A recorded step that is not allowed, or that could not be decided.

    Attributes
    ----------
    record : Record
        The step.
    step : str
        Description of the step.
    reason : str
        The reason.
    """

    record: Record
    step: str
    reason: str

    @property
    def location(self) -> Location | None:
        """File and line of the record."""
        return self.record.location

    def __str__(self) -> str:
        return f"{self.step}: {self.reason}"

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        location = self.location
        return {
            "file": None if location is None else str(location.file),
            "line": None if location is None else location.line,
            "node": self.record.node,
            "sequence": self.record.sequence,
            "step": self.step,
            "reason": self.reason,
        }


@dataclass(frozen=True)
class Verdict(Outcome):
    """The outcome of a comparison of traces with the model, with all findings.

    Attributes
    ----------
    status : {"conforms", "violated", "unknown"}
        `violated` exactly if there are violations.
    steps : int
        Number of replayed records.
    silent : int
        Number of inferred steps inside of channels.
    violations : list of Deviation
        First steps of nodes that are not allowed, the earliest first.
    unknown : list of Deviation
        Undecided steps, with reasons.
    sequence : list of str
        The firings of the flattened net, if requested.
    """

    status: str = "conforms"
    steps: int = 0
    silent: int = 0
    violations: list[Deviation] = field(default_factory=list)
    unknown: list[Deviation] = field(default_factory=list)
    sequence: list[str] = field(default_factory=list)

    def to_dict(self, model: str) -> dict[str, Any]:
        """Return the verdict for JSON."""
        return {
            "model": model,
            "status": self.status,
            "steps": self.steps,
            "silent": self.silent,
            "violations": [deviation.to_dict() for deviation in self.violations],
            "unknown": [deviation.to_dict() for deviation in self.unknown],
        }
