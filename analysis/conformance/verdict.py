"""What comes out of a comparison of traces with a model."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from dineros.analysis.answers.outcome import Outcome
from dineros.metamodel.errors import Location
from dineros.metamodel.records import Record


@dataclass(frozen=True)
class Deviation:
    """A recorded step that is not allowed, or of which that is not known.

    Attributes
    ----------
    record : Record
        The step.
    step : str
        It, in words.
    reason : str
        Why it is not allowed.
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
    """Whether traces are a behaviour of the model: what is found, and then the answer.

    Attributes
    ----------
    status : {"conforms", "violated", "unknown"}
        Exactly `violated` where there are violations.
    steps : int
        Recorded steps replayed.
    silent : int
        Steps inside of channels that were inferred.
    violations : list of Deviation
        First steps of the nodes' traces that are not allowed, the earliest first.
    unknown : list of Deviation
        Steps that could not be decided, and why.
    sequence : list of str
        The firings of the flattened net, where they were asked for.
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
