"""What a question of a check is, and what it finds when it is asked: the model, and what is known so far."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, ClassVar

from dineros.analysis.answers.apart import is_end
from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError, processor_seconds
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.model.queues import queues
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.portfolio.known import Known, known_of
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Fault, Report
from dineros.analysis.witnesses.rounds import MOST_TRIED
from dineros.metamodel import pn
from dineros.metamodel.errors import BudgetError

if TYPE_CHECKING:
    from dineros.analysis.covering.firings import Firings
    from dineros.analysis.properties.recurrence import Recurrence
    from dineros.analysis.requirements.latencies import AskedLatency
    from dineros.analysis.requirements.stored import Asked
    from dineros.metamodel import sym

OUT_OF_MEMORY = RAN_OUT["memory"]

REPORT_IT = "please report it, with the model and what --debug adds"

NEAR = Share(time=0.2)
"""Part of the time that is left for the first round."""

PARTS = Share(time=0.4, seconds_if_unlimited=60.0)
"""Share of parts of the net."""

FEW_QUEUES = 10
"""Number of queues for each of which a run that loses a message is put into rounds at any cost."""

SHOWN_SHARE = 0.15
"""Part of the time in which runs are made short to read that lose a message; later ones are not shown."""

RECURRENCE = Share(time=0.2)
"""Part of the remaining time in which a smaller net is analysed."""


@dataclass
class Checked:
    """The checked model, and the facts known about it so far.

    Attributes
    ----------
    budget : Budget
        Begun.
    work : int or None
        Cache misses of saturation that a question may cost where a note is the worst answer.
    orders : OrderCache or None
        Of the symbolic engine.
    is_shown : bool
        Whether runs are searched that show what is found.
    subject : Subject
        The net without signals, made when it is first needed.
    firings : Firings or None
        What is known without a state space.
    recurs : bool
        Whether it is proved that the net can always come back to its initial marking.
    is_closed : bool
        Whether no question can be asked that needs a state space.
    callbacks_asked, callbacks_known : bool
        Whether it has been looked for callbacks that can wait forever; whether all of them are known.
    circles : list of Circle
        Those of them that wait for each other and are in the report.
    told : set of str
        Ids of what has been answered before its question was asked.
    answered : list
        The stored properties that were decided: the property, the question and the answer.
    bounded : dict of str to str
        Of stored properties that safe bounds have proved: what the report says of each. A later answer that
        is exact takes its place.
    """

    model: pn.Net
    report: Report
    budget: Budget
    work: int | None
    orders: OrderCache | None
    is_shown: bool = True
    firings: Firings | None = None
    recurs: bool = False
    is_closed: bool = False
    callbacks_asked: bool = False
    callbacks_known: bool = False
    circles: list[Circle] = field(default_factory=list)
    told: set[str] = field(default_factory=set)
    answered: list[tuple[sym.Property, Asked | AskedLatency, Outcome]] = field(default_factory=list)
    bounded: dict[str, str] = field(default_factory=dict)
    _shown_seconds: float = 0.0

    @contextmanager
    def showing(self) -> Iterator[None]:
        """Count the time of the processor in which a run is made that shows what is found."""
        began = processor_seconds()
        try:
            yield
        finally:
            self._shown_seconds += processor_seconds() - began

    @property
    def has_time_for_runs(self) -> bool:
        """Whether runs that show what is found are wanted, and have not used up their part of the time."""
        limit = self.budget.seconds
        return self.is_shown and (limit is None or self._shown_seconds < SHOWN_SHARE * limit)

    @cached_property
    def subject(self) -> Subject:
        """The net without signals."""
        return base_subject(self.model)

    @cached_property
    def waiting(self) -> Waiting:
        """Which of its callbacks wait for what."""
        return Waiting(self.subject)

    @cached_property
    def rounds_tried(self) -> int:
        """Firings tried, at most, to find rounds that repeat in a run that loses a message.

        The more queues there are, the fewer for each.
        """
        return MOST_TRIED // max(1, len(queues(self.subject)) // FEW_QUEUES)

    @cached_property
    def near(self) -> Firings:
        """What the first round shows about what can happen, before a state space, or without one."""
        from dineros.analysis.covering.firings import near_firings

        self.budget.stage("what can happen nearby")
        return near_firings(self.subject.net, NEAR.share(self.budget))

    @cached_property
    def by_parts(self) -> Firings:
        """The same, with what parts of the net show; see `dineros.analysis.parts`."""
        from dineros.analysis.parts.firings import decide_by_parts

        found = self.near
        decide_by_parts(self.subject.net, found, PARTS.share(self.budget))
        return found

    @cached_property
    def recurrence(self) -> Recurrence | None:
        """What a smaller net proves of it."""
        from dineros.analysis.properties.recurrence import recurrence

        self.budget.stage("whether the net can always return to its initial marking")
        return recurrence(self.subject.net, RECURRENCE.share(self.budget))

    @property
    def known(self) -> Known:
        """The record of what is known of the net without signals."""
        return known_of(self.subject.net)

    @property
    def space(self) -> SymbolicStateSpace:
        """Its complete state space; there once `Boundedness` has been asked, unless `firings` is."""
        assert self.known.space is not None
        return self.known.space

    @property
    def why_open(self) -> str:
        """The reason why some transitions stay undecided without a state space; empty with one."""
        return "" if self.firings is None else self.firings.why_open

    @property
    def identity(self) -> str:
        """Id of the model."""
        return str(self.model.id)

    def leave_open(
        self,
        question: str,
        reason: str,
        hint: str = "",
        may_be_fault: bool = True,
        elements: tuple[str, ...] = (),
        rule: str = "",
    ) -> None:
        """Put a question into the report that is not decided; see `Outcome`."""
        open_question = Outcome.left_open(question, reason, hint, may_be_fault)
        self.report.unknown.append(replace(open_question, elements=elements, rule=rule))

    @contextmanager
    def guarded(self, leave_open: Callable[[str], None] | None) -> Iterator[None]:
        """Let what is asked within fail alone: it is left open with its reason, and the check continues.

        Running out of a budget is a reason, and so is an error of an engine. An error that ends the process,
        such as an interruption, passes.

        `leave_open`: gets the reason; None if the question must be asked again.
        """
        try:
            yield
            return
        except BudgetExceededError as limit:
            reason = str(limit)
        except DiagramMemoryError:
            reason = OUT_OF_MEMORY
        except Exception as error:
            reason = self.failed(error, is_noted=leave_open is not None)
        if leave_open is not None:
            leave_open(reason)

    def failed(self, error: Exception, *, is_noted: bool = True) -> str:
        """Note an error inside a question and return it as a reason; raise it again if it ends the check."""
        if isinstance(error, BudgetError) or is_end(error):
            raise error
        if is_noted:
            self.report.failures.append(error)
        text = " ".join(str(error).split())
        return f"an internal error: {type(error).__name__}{': ' if text else ''}{text} ({REPORT_IT})"

    def ask(self, question: Question) -> None:
        """Ask a question, unless it needs a state space that is not there; note the rules it leaves open."""
        before = len(self.report.unknown)
        is_asked = not (self.is_closed and question.needs_space)
        if is_asked:
            self.budget.stage(question.asks)
            if question.needs_space:
                _ = self.subject  # what is wrong with the model itself ends the check
            with self.guarded(partial(question.leave_open, self)):
                if self.firings is None or not question.reads_firings:
                    self.budget.check_time()
                question.ask(self)
        if not is_asked or len(self.report.unknown) > before:
            self.report.open_rules |= {fault.rule for fault in question.faults}

    def close(self, question: str, reason: str) -> None:
        """End with an undecided question: the next steps need a state space."""
        self.leave_open(question, reason)
        self.is_closed = True


class Question(ABC):
    """A question of a check. A new one is a subclass, and is listed in `QUESTIONS`."""

    faults: ClassVar[Sequence[Fault]]
    asks: ClassVar[str]
    """What is not known where it is left open."""
    needs_space: ClassVar[bool] = True
    """Whether only a state space answers it."""
    reads_firings: ClassVar[bool] = False
    """Whether the known firings answer it if there is no state space. Such a question needs no search, so it
    is answered even after the time limit.
    """
    is_basis: ClassVar[bool] = False
    """Whether the answers of other questions rest on its answer."""

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it, or what is left of it, undecided."""
        checked.leave_open(self.asks, reason)

    def ask_first(self, checked: Checked) -> None:  # noqa: B027 - most questions have nothing to say so early
        """Answer what costs little, before any question is asked that may take long."""

    def ask_with_space(self, checked: Checked) -> None:  # noqa: B027 - only properties come before other questions
        """Answer what the state space answers at once, before questions that search for runs."""

    @abstractmethod
    def ask(self, checked: Checked) -> None:
        """Put what is found, proved or not known into the report."""


def finding_rules(rules: Collection[str], questions: Sequence[Question]) -> list[Question]:
    """Return the questions that find faults of some rules, and those that the others rest on."""
    return [each for each in questions if each.is_basis or any(fault.rule in rules for fault in each.faults)]
