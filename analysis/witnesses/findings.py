"""What the Net Analyzer answers: findings with witnesses, what is proved, and what stays unknown."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Literal

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.model.times import LeftOutTimes, UsedTimes
from dineros.analysis.witnesses.witness import Witness

if TYPE_CHECKING:
    from dineros.analysis.symbolic.engine import SymbolicStateSpace

Severity = Literal["error", "warning", "note"]
SEVERITIES = {"error": 2, "warning": 1, "note": 0}
"""How severe each severity is."""


@dataclass(frozen=True)
class Wait:
    """Why one of those that wait for each other waits.

    Attributes
    ----------
    waiter : str
        The one that waits, in the words of the model.
    needs : tuple of str
        What it waits for; a thread, a group and a place wait for the callbacks that hold or give them.
    is_choice : bool
        Whether one of these would be enough.
    """

    waiter: str
    needs: tuple[str, ...]
    is_choice: bool

    def to_dict(self) -> dict[str, Any]:
        """Return it for JSON."""
        return {
            "waits": self.waiter,
            "for": list(self.needs),
            "enough": "one" if self.is_choice else "all",
        }


@dataclass(frozen=True)
class Finding:
    """Something that is wrong with a model.

    Attributes
    ----------
    rule : str
        What kind of fault it is, such as ``queue-overflow``.
    severity : {"error", "warning", "note"}
        How bad it is.
    elements : tuple of str
        Ids of the elements of the model concerned, the most specific first.
    message : str
        What is wrong, in the words of the model.
    witness : Witness or None
        How it comes about.
    circle : tuple of str
        If the fault is a circle: the participants, each of which waits for the next one, and the last one for
        the first.
    waits : tuple of Wait
        Why each of them waits, and those that they need besides.
    consequences : tuple of Finding
        What is wrong only because of this.
    together : tuple of Finding
        Of a consequence: the other causes that must be fixed, too, before it is gone.
    lines : tuple of str
        Lines of code, as ``file:line``, of a finding that code alone shows.
    question : str
        The text of the property that the finding is about; empty for the questions of every model. With
        another text, it is another finding.
    """

    rule: str
    severity: Severity
    elements: tuple[str, ...]
    message: str
    witness: Witness | None = None
    circle: tuple[str, ...] = ()
    waits: tuple[Wait, ...] = ()
    consequences: tuple[Finding, ...] = ()
    together: tuple[Finding, ...] = ()
    lines: tuple[str, ...] = ()
    question: str = ""

    def to_dict(self) -> dict[str, Any]:
        """Return the finding for JSON."""
        found: dict[str, Any] = {
            "rule": self.rule,
            "severity": self.severity,
            "elements": list(self.elements),
            "message": self.message,
            "witness": self.witness.to_dict() if self.witness else None,
        }
        if self.question:
            found["question"] = self.question
        if self.circle:
            found["circle"] = list(self.circle)
            found["waits"] = [wait.to_dict() for wait in self.waits]
        if self.consequences:
            found["consequences"] = [each.to_dict() for each in self.consequences]
        if self.together:
            found["together"] = [
                {"rule": each.rule, "elements": list(each.elements), "message": each.message}
                for each in self.together
            ]
        return found

    def as_note(self, why: str) -> Finding:
        """Return it as a note, with the reason after its message."""
        return replace(self, severity="note", message=f"{self.message}{why}")

    @property
    def shown_consequences(self) -> list[tuple[str, str]]:
        """Message and rule of each consequence; a consequence of several causes names the others."""
        return [(each.message + _besides(each.together), each.rule) for each in self.consequences]


def _besides(causes: Sequence[Finding]) -> str:
    names = " and ".join(f"{each.rule} of {each.elements[0]}" for each in causes)
    return f" (together with {names})" if names else ""


@dataclass(frozen=True)
class Suppressed:
    """A finding that the model accepts.

    Attributes
    ----------
    element : str
        Id of the element that has the suppression.
    until : str or None
        The last day on which it is accepted, as an ISO date; None for always.
    """

    finding: Finding
    element: str
    reason: str
    until: str | None = None

    @property
    def why(self) -> str:
        """Why, and until when, in words."""
        return f"{self.reason} (until {self.until})" if self.until else self.reason

    def to_dict(self) -> dict[str, Any]:
        """Return the finding and its suppression for JSON."""
        accepted = {"element": self.element, "reason": self.reason, "until": self.until}
        return {**self.finding.to_dict(), "suppression": accepted}


@dataclass(frozen=True)
class Fault:
    """A kind of fault, as the question that looks for it declares it.

    Attributes
    ----------
    rule : str
        What it is called, such as ``queue-overflow``.
    severity : {"error", "warning", "note"}
        How bad it is.
    meaning : str
        What it is, in general: SARIF's description of the rule.
    message : str
        What is wrong, with the names of its parts in braces.
    """

    rule: str
    severity: Severity
    meaning: str
    message: str

    def found(self, *elements: str, witness: Witness | None = None, **parts: object) -> Finding:
        """Return a finding of this kind, with the parts of its message."""
        return Finding(self.rule, self.severity, elements, self.message.format(**parts), witness)


def worst_first(findings: Iterable[Finding]) -> list[Finding]:
    """Return findings with errors before warnings before notes, otherwise in their order."""
    return sorted(findings, key=lambda finding: -SEVERITIES[finding.severity])


Unknown = Outcome.left_open
"""Makes what a report has of a question that was not decided."""


@dataclass
class Report:
    """Everything found out about a model.

    Attributes
    ----------
    proved : list of str
        What is proved to hold.
    unknown : list of Outcome
        What could not be decided, and why.
    space : SymbolicStateSpace or None
        All markings, where answers rest on them.
    dead : list of str
        Transitions of the net without signals that are found never to fire.
    by : str
        Who answers what is asked of markings, and why.
    suppressed : list of Suppressed
        What is wrong but accepted by a suppression of the model.
    known : list of Finding
        Findings that the baseline has, too.
    has_baseline : bool
        Whether the report was compared with a baseline.
    gone : int
        Findings of the baseline, notes aside, that were not found again.
    failures : list of Exception
        Errors inside questions, which are among what is not decided.
    open_rules : set of str
        Rules of the questions of which something was not decided.
    times : UsedTimes or None
        The firing intervals that the answers take into account; None if they leave times out.
    assumed : list of str
        What is proved only under an assumption, which `unknown` names. Then `proved` is empty.
    assumes : list of str
        What all proofs assume besides, because the net is simpler than ROS 2 there.
    """

    findings: list[Finding] = field(default_factory=list)
    proved: list[str] = field(default_factory=list)
    unknown: list[Outcome] = field(default_factory=list)
    space: SymbolicStateSpace | None = field(default=None, compare=False, repr=False)
    dead: list[str] = field(default_factory=list, compare=False, repr=False)
    by: str = field(default="", compare=False)
    suppressed: list[Suppressed] = field(default_factory=list)
    known: list[Finding] = field(default_factory=list)
    has_baseline: bool = False
    gone: int = 0
    failures: list[Exception] = field(default_factory=list, compare=False, repr=False)
    open_rules: set[str] = field(default_factory=set, compare=False, repr=False)
    times: UsedTimes | None = None
    assumed: list[str] = field(default_factory=list)
    assumes: list[str] = field(default_factory=list)

    def with_accepted(
        self, findings: list[Finding], suppressed: list[Suppressed], known: list[Finding]
    ) -> Report:
        """Return a copy in which these findings count, are suppressed, and are known."""
        return replace(self, findings=findings, suppressed=list(suppressed), known=list(known))

    def text_of_times(self, left_out: LeftOutTimes | None) -> str | None:
        """Return the note of the report about firing intervals; None for a model without intervals.

        `left_out`: the intervals of the model, as a report that leaves them out names them.
        """
        if self.times is not None:
            return f"{self.times}; answered by: {self.by}" if self.by else str(self.times)
        return None if left_out is None else f"{left_out}; {left_out.of_check}"

    @property
    def consequences(self) -> list[Finding]:
        """Findings that are consequences of another finding."""
        return [each for finding in self.findings for each in finding.consequences]

    def add(self, other: Report) -> None:
        """Take over all entries of another report."""
        self.findings += other.findings
        self.proved += other.proved
        self.assumed += other.assumed
        self.assumes += [each for each in other.assumes if each not in self.assumes]
        self.unknown += other.unknown

    def to_dict(self, model: str) -> dict[str, Any]:
        """Return the report for JSON, as `docs/command_line.md` describes it."""
        return {
            "model": model,
            "findings": [finding.to_dict() for finding in self.findings],
            **({"suppressed": [each.to_dict() for each in self.suppressed]} if self.suppressed else {}),
            **({"known": [finding.to_dict() for finding in self.known]} if self.has_baseline else {}),
            **({"gone": self.gone} if self.has_baseline else {}),
            "proved": self.proved,
            **({"assumed": self.assumed} if self.assumed else {}),
            **({"assumes": self.assumes} if self.assumes else {}),
            "unknown": [str(unknown) for unknown in self.unknown],
        }
