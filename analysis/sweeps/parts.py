"""Divides questions among machines, and combines the answers.

A question about a net is given to several workers: one with all engines in turns, and several with decision
diagrams, whose searches for a variable order begin differently. The first answer ends the others. Each
formula of a conjunction is a question. The questions of a check are divided among several workers, each of
which builds the state space; another worker counts again for a confirmation. The properties of property files
are divided among the workers.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

from dineros.analysis.answers.budget import DEFAULT_MEMORY, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.sweeps.grid import parse_model

if TYPE_CHECKING:
    from dineros.analysis.evidence.confirmation import Confirmation
    from dineros.analysis.model.subject import Subject
    from dineros.analysis.properties.property import GroupedNames, Property, PropertyAnswer
    from dineros.analysis.questions.net_questions import Question
    from dineros.analysis.witnesses.findings import Finding, Report
    from dineros.metamodel import pn

    PartAnswer = Outcome | Report | Confirmation | list[PropertyAnswer] | None
    """Answer to a question, a check, a repeated count (None: there is nothing to count), and properties.

    For each of them, an unknown `Outcome` gives the reason why there is no answer.
    """

STARTS = 3
"""Number of parallel searches for a variable order."""

SHEETS = 8
"""Maximum number of workers among which properties are divided: each prepares the net."""

TOGETHER = (
    ("Clauses", "Matching", "Boundedness", "Overflow", "Presence", "Use", "Places"),
    ("Deadlock", "Callbacks", "Goals"),
    ("Repetition",),
    ("Properties",),
)
"""Groups of questions of a check that one worker answers, by class names."""


@dataclass(frozen=True)
class Part:
    """The data that a worker needs for its part."""

    model: str
    """The model, as XMI."""
    task: str
    asked: dict[str, Any] = field(default_factory=dict)
    """For a question: kind, text, signals, overflow, and optionally weak, strong and order; and start, 0 for
    all engines, else the start of the search for an order. For a check: questions, at_any_cost, and whether
    to confirm counts. For properties: these, signals, overflow, and seconds for each.
    """
    memory: int | None = None
    """Memory for engines, in bytes."""
    timeout: float | None = None
    """Seconds after which it is given up."""
    work: str = ""
    """Id of the whole; its parts are ended together."""
    engine: str = "auto"

    @property
    def questions(self) -> tuple[str, ...]:
        """Names of the questions of a check; empty for another task."""
        return tuple(self.asked.get("questions", ()))

    @property
    def patience(self) -> float | None:
        """Seconds after which its process is killed if it has not ended by itself."""
        return None if self.timeout is None else 1.1 * self.timeout + 2


def answer_part(part: Part) -> PartAnswer:
    """Answer a part in this process."""
    from dineros.analysis.nets.memory import OWN_MEMORY, watched_memory

    budget = Budget(part.memory or DEFAULT_MEMORY, seconds=part.timeout).begun()
    with watched_memory(budget.memory + OWN_MEMORY):
        model = parse_model(part.model)
        tasks = {"question": _question, "check": _check, "properties": _properties}
        return tasks[part.task](model, part.asked, budget)


def question_parts(
    model: str, asked: dict[str, Any], memory: int | None, timeout: float | None, work: str
) -> list[Part]:
    """Return the parts of one question: all engines, and diagrams with several starts if applicable."""
    starts = range(1 if asked["kind"] == "ltl" else STARTS)
    return [Part(model, "question", {**asked, "start": n}, memory, timeout, work) for n in starts]


def conjuncts(kind: str, text: str) -> list[str]:
    """Return the formulas of a conjunction; for another formula, the formula itself."""
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.logic.language.syntax import And

    formula = parse(text, kind) if kind in ("ctl", "ltl") else None
    return [str(one) for one in formula.operands] if isinstance(formula, And) else [text]


def all_of(answers: Mapping[str, Outcome], texts: Sequence[str]) -> Outcome | None:
    """Return the answer to a conjunction from those to its formulas; None: it is not known yet."""
    found = [answers[text] for text in texts if text in answers]
    violated = next((answer for answer in found if answer.status == "violated"), None)
    if violated is not None or len(found) < len(texts):
        return violated
    by = ", ".join(dict.fromkeys(answer.by for answer in found if answer.by))
    worst = next((answer for answer in found if answer.status == "unknown"), found[-1])
    return worst if len(found) == 1 or worst.status == "unknown" else replace(worst, by=by, evidence=None)


def check_parts(
    model: str, at_any_cost: bool, memory: int | None, work: str, is_confirmed: bool = False
) -> list[Part]:
    """Return the parts of a check: groups of questions, and a repeated count."""
    asked: list[dict[str, Any]] = [{"questions": list(names)} for names in TOGETHER]
    asked += [{"questions": [], "confirm": True}] if is_confirmed else []
    more = {"at_any_cost": at_any_cost}
    return [Part(model, "check", {**one, **more}, memory, None, work) for one in asked]


def property_parts(
    model: str, subject: dict[str, Any], properties: Sequence[Property], names: GroupedNames, work: str
) -> list[Part]:
    """Return the parts of a property file: neighbours, which are similar, go to different workers.

    `subject`: signals and overflow, memory in bytes, and seconds for each property.
    """
    told = [
        replace(one, formula=None if one.formula is None else names.ungrouped(one.formula))
        for one in properties
    ]
    count = min(SHEETS, len(told))
    shares = [told[number::count] for number in range(count)]
    memory = subject["memory"]
    return [
        Part(
            model, "properties", {**subject, "properties": some}, memory, subject["seconds"] * len(some), work
        )
        for some in shares
    ]


def check_names(subject: Subject, kind: str, text: str) -> None:
    """Check that a question is valid, before any worker gets it.

    Raises
    ------
    FormulaError
        It is not, or has an unknown name.
    """
    from dineros.analysis.logic.language.atoms import BoundAtoms
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.logic.language.syntax import Enabled, Name

    logic: Any = {"marking": "state"}.get(kind, kind)
    BoundAtoms(subject.net, Enabled(Name(text)) if kind == "enabled" else parse(text, logic), subject.names)


def property_answers(part: Part, answer: PartAnswer) -> list[PropertyAnswer]:
    """Return the answers to the properties of a part."""
    from dineros.analysis.properties.property import PropertyAnswer

    if isinstance(answer, Outcome):
        return [PropertyAnswer(one.id, None, 0.0, reason=answer.reason) for one in part.asked["properties"]]
    assert isinstance(answer, list)
    return answer


def add_report(report: Report, subject: Subject, part: Part, answer: PartAnswer) -> None:
    """Add a worker's answers to its questions of a check to a report.

    Facts that several workers have found, such as whether the net is bounded, are added once.
    """
    from dineros.analysis.witnesses.findings import Report
    from dineros.analysis.witnesses.witness import witness_of

    if isinstance(answer, Outcome):
        names = ", ".join(name.lower() for name in part.questions)
        report.unknown.append(Outcome.left_open(names, answer.reason))
        return
    assert isinstance(answer, Report)
    index = subject.transition_index
    seen = {_key(finding) for finding in report.findings}
    for found in answer.findings:
        if _key(found) not in seen:
            told = found.witness
            steps = [index[step.transition] for step in told.steps] if told else []
            replayed = witness_of(subject, steps, told.loop) if told else None
            report.findings.append(replace(found, witness=replayed))
    report.by = report.by or answer.by
    report.proved += [text for text in answer.proved if text not in report.proved]
    report.assumed += [text for text in answer.assumed if text not in report.assumed]
    known = {str(unknown) for unknown in report.unknown}
    report.unknown += [unknown for unknown in answer.unknown if str(unknown) not in known]


def _key(finding: Finding) -> tuple[str, tuple[str, ...], str]:
    return finding.rule, finding.elements, finding.message


def _check(model: pn.Net, asked: dict[str, Any], budget: Budget) -> Report | Confirmation | None:
    from dineros.analysis.checks.check import QUESTIONS, check

    wanted = {"Boundedness", *asked["questions"]}
    chosen = [question for question in QUESTIONS if type(question).__name__ in wanted]
    report = check(model, budget, at_any_cost=asked["at_any_cost"], questions=chosen)
    if asked.get("confirm"):
        from dineros.analysis.evidence.confirmation import confirm_space

        return None if report.space is None else confirm_space(report.space, budget)
    # The model and its markings are not transferred.
    findings = [
        replace(one, witness=one.witness and replace(one.witness, subject=None)) for one in report.findings
    ]
    return replace(report, findings=findings, space=None)


def _properties(model: pn.Net, asked: dict[str, Any], budget: Budget) -> list[PropertyAnswer]:
    from dineros.analysis.model.subject import subject_of
    from dineros.analysis.portfolio.answering import answer_properties

    subject = subject_of(model, asked["signals"], asked["overflow"])
    found = answer_properties(
        subject.net, subject.names, asked["properties"], asked["seconds"], budget.memory
    )
    return [replace(one, evidence=None, dead="") for one in found]


def _question(model: pn.Net, asked: dict[str, Any], budget: Budget) -> Outcome:
    from dineros.analysis.model.subject import subject_of

    subject = subject_of(model, asked["signals"], asked["overflow"])
    question = _read(subject, asked)
    start = asked["start"]
    answer = question.decided(budget) if start == 0 else _drawn(subject, asked, start, budget)
    return replace(answer, evidence=None)


def _read(subject: Subject, asked: dict[str, Any]) -> Question:
    from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking

    net, names, text = subject.net, subject.names, asked["text"]
    match asked["kind"]:
        case "enabled":
            return Enabled(net, names, text, asked.get("order", "breadth-first"))
        case "marking":
            return Marking(net, names, text, asked.get("order", "breadth-first"))
        case "ltl":
            return Linear(net, names, text, tuple(asked.get("weak", ())), tuple(asked.get("strong", ())))
    return Branching(net, names, text)


def _drawn(subject: Subject, asked: dict[str, Any], start: int, budget: Budget) -> Outcome:
    """Use diagrams whose search for a variable order begins differently."""
    from dineros.analysis.logic.language.parser import parse
    from dineros.analysis.logic.language.syntax import Enabled, Exists, Finally, Name
    from dineros.analysis.nets.witness import ending_with_one_of
    from dineros.analysis.portfolio.branching_time import check_ctl

    net, names, text = subject.net, subject.names, asked["text"]
    if asked["kind"] == "ctl":
        return check_ctl(net, text, names, budget, engine="symbolic", seed=1 + start)
    goal = Enabled(Name(text)) if asked["kind"] == "enabled" else parse(text, "state")
    found = check_ctl(net, Exists(Finally(goal)), names, budget, engine="symbolic", seed=1 + start)
    found = replace(found, by="decision diagrams")
    if found.status == "violated":
        return replace(found, status="unreachable", reason="")
    if found.status != "holds" or found.reason.startswith("a run"):
        return replace(found, status="unknown")
    trace = found.trace or ()
    if asked["kind"] == "enabled":
        trace = ending_with_one_of(net, trace, names.transitions(text))
    return replace(found, status="reachable", trace=trace, reason="")
