"""Every question with a yes/no answer that can be asked of any model (paper, Sect. 7).

The complete state space of the net without signals answers most of them at once; a witness is then searched
breadth first, so that it is a shortest one. Where it has no end, what can be answered on the way is.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import ClassVar

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.firings import Firings, firings
from dineros.analysis.covering.growth import growth_of, remedy_of
from dineros.analysis.model.queues import queues
from dineros.analysis.model.satisfiability import unsatisfiable_clauses
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.questions import unused
from dineros.analysis.questions.remedies import remedy_text
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Fault, Report, Witness, pumping_witness, witness_of
from dineros.metamodel import pn, sym
from dineros.metamodel.matching import mismatch

CHEAP = 1_500_000
"""Cache misses of saturation, about half a second, that liveness and the like may cost by default."""

NEAR = 64 << 20
"""Bytes for the search for a shortest way to a fault; one that is further off is found by the state space."""

BEHAVIOUR = "liveness, reversibility, home markings"
OUT_OF_MEMORY = RAN_OUT["memory"]
SPACE_SHARE = 0.6
"""Part of the time in which the state space is made; the rest is for what can be answered without it."""


def check(
    model: pn.Net,
    budget: Budget = UNLIMITED,
    report: Report | None = None,
    at_any_cost: bool = False,
    orders: OrderCache | None = None,
    questions: Sequence[Question] | None = None,
) -> Report:
    """Ask everything that can be asked of any model.

    Parameters
    ----------
    model : pn.Net
        A system model, or any place/transition net.
    budget : Budget, optional
        What it may cost; running out of time or memory leaves questions unknown.
    report : Report, optional
        Where to put the answers as they come, for those who want them after an interruption.
    at_any_cost : bool
        Whether to decide liveness, reversibility and home markings also where that takes long.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    questions : sequence of Question, optional
        Which ones, in their order, `Boundedness` among them; all by default.
    """
    report = Report() if report is None else report
    work = None if at_any_cost else CHEAP
    checked = Checked(model, report, budget.begun(), work, orders)
    for question in QUESTIONS if questions is None else questions:
        checked.budget.stage(question.asks)
        try:
            checked.budget.check_time()
            question.ask(checked)
        except BudgetExceededError as limit:
            question.leave_open(checked, str(limit))
        if checked.is_closed:
            break
    return report


@dataclass
class Checked:
    """What is checked, and what is known of it so far.

    Attributes
    ----------
    model : pn.Net
        The model.
    report : Report
        The answers.
    budget : Budget
        Begun.
    work : int or None
        Cache misses of saturation that a question may cost where a note is the worst answer.
    orders : OrderCache or None
        Of the symbolic engine.
    subject : Subject
        The net without signals; there once `Boundedness` has been asked, as are the others.
    space : SymbolicStateSpace
        Its complete state space; not there where `firings` is.
    firings : Firings or None
        What is known without a state space.
    is_closed : bool
        Whether no further question can be asked: there is no state space.
    """

    model: pn.Net
    report: Report
    budget: Budget
    work: int | None
    orders: OrderCache | None
    subject: Subject = field(init=False)
    space: SymbolicStateSpace = field(init=False)
    firings: Firings | None = None
    is_closed: bool = False

    @property
    def identity(self) -> str:
        """Id of the model."""
        return str(self.model.id)

    def leave_open(self, question: str, reason: str, hint: str = "", may_be_fault: bool = True) -> None:
        """Put a question into the report that is not decided."""
        self.report.unknown.append(Outcome.left_open(question, reason, hint, may_be_fault))

    def close(self, question: str, reason: str) -> None:
        """End with a question that is not decided: what follows needs a state space."""
        self.leave_open(question, reason)
        self.is_closed = True


class Question(ABC):
    """A question of a check. A new one is a subclass, and stands in `QUESTIONS`.

    Attributes
    ----------
    faults : tuple of Fault
        What it may find.
    asks : str
        What is not known where it is left open.
    """

    faults: ClassVar[Sequence[Fault]]
    asks: ClassVar[str]

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it, or what is left of it, undecided."""
        checked.leave_open(self.asks, reason)

    @abstractmethod
    def ask(self, checked: Checked) -> None:
        """Put what is found, proved or not known into the report."""


class Clauses(Question):
    """Whether every clause can be true."""

    UNSATISFIABLE = Fault(
        "unsatisfiable-clause",
        "error",
        "An input clause can never be true, so its transition never fires.",
        "{clause}",
    )
    faults = (UNSATISFIABLE,)
    asks = "whether every clause can be true"

    def ask(self, checked: Checked) -> None:
        """Ask a SAT solver."""
        if not isinstance(checked.model, sym.SystemModel):
            return
        found = unsatisfiable_clauses(checked.model)
        checked.report.findings += [
            self.UNSATISFIABLE.found(str(clause.transition.id), clause=clause) for clause in found
        ]
        if not found:
            checked.report.proved.append("every clause can be true")


class Matching(Question):
    """Whether every subscriber gets the messages of every publisher of its topic."""

    NOT_MATCHED = Fault(
        "ports-not-matched",
        "warning",
        "A subscriber asks for more quality of service than a publisher offers, and gets nothing of it.",
        "{subscriber} gets no message of {publisher} (topic {topic}): {reason}; to mend it, set {fix}",
    )
    faults = (NOT_MATCHED,)
    asks = "whether ports match"

    def ask(self, checked: Checked) -> None:
        """Compare the quality of service of each pair of ports."""
        channels = checked.model.channels if isinstance(checked.model, sym.SystemModel) else ()
        for channel in channels:
            if not isinstance(channel, sym.TopicChannel):
                continue
            for publisher in channel.publishers:
                for subscriber in channel.subscribers:
                    found = mismatch(publisher, subscriber)
                    if found is not None:
                        ends = publisher.place.id, subscriber.place.id
                        checked.report.findings.append(
                            self.NOT_MATCHED.found(
                                channel.id,
                                *ends,
                                publisher=ends[0],
                                subscriber=ends[1],
                                topic=channel.topic,
                                reason=found.reason,
                                fix=found.fix,
                            )
                        )


class Boundedness(Question):
    """Whether the net is bounded: if so, its state space is what further questions are asked of."""

    UNBOUNDED = Fault(
        "unbounded", "error", "Tokens can grow without bound.", "tokens grow without bound: {places}"
    )
    faults = (UNBOUNDED,)
    asks = "all questions on the state space"

    def leave_open(self, checked: Checked, reason: str) -> None:
        """End, as the others are asked of what is made here."""
        checked.close(self.asks, reason)

    def ask(self, checked: Checked) -> None:
        """Make the state space, or find out what is known without it."""
        subject = checked.subject = base_subject(checked.model)
        share = checked.budget.share(SPACE_SHARE)
        try:
            space = symbolic_state_space(subject.net, share, orders=checked.orders)
        except UnknownBoundError as error:
            pumping = growth_of(subject.net, checked.budget.share(0.3))
            if pumping is None:
                checked.leave_open("whether the net is bounded", str(error))
            else:
                self._grows(checked, pumping)
        except LevelSizeError as error:
            checked.close(self.asks, error.message)
            return
        except BudgetExceededError as limit:
            checked.leave_open("whether the net is bounded", str(limit))
        else:
            if space.complete:
                checked.space = checked.report.space = space
                checked.report.proved.append(
                    f"the net is bounded: {space.markings} markings without signals, "
                    f"at most {max(space.largest_place(), default=0)} tokens in a place"
                )
                return
            checked.leave_open("whether the net is bounded", RAN_OUT[space.reason])
            del space  # its memory is needed
        checked.budget.stage("what can happen without bounds")
        checked.firings = firings(subject.net, checked.budget)

    def _grows(self, checked: Checked, pumping: Pumping) -> None:
        subject, report = checked.subject, checked.report
        grown = tuple(subject.place_text(place) for place in pumping.places)
        way = pumping_witness(subject, pumping)
        report.findings.append(self.UNBOUNDED.found(*grown, witness=way, places=", ".join(grown)))
        remedy = remedy_of(subject.net)
        if remedy is not None:
            report.proved.append(f"the net would be bounded with {remedy_text(subject, remedy)}")


class Overflow(Question):
    """Whether a queue can overflow."""

    LOSES = Fault(
        "queue-overflow",
        "error",
        "A queue can be full when a message arrives, which is then lost.",
        "{queue} can overflow: a message is lost",
    )
    faults = (LOSES,)
    asks = "which queues can overflow"

    def ask(self, checked: Checked) -> None:
        """Look for a marking in which a message would be lost."""
        if checked.firings is not None:
            self._ask_on_the_way(checked, checked.firings)
            return
        for queue in queues(checked.subject):
            losing = next((drop for drop in queue.drops if checked.space.enabled(drop)), None)
            if losing is None:
                checked.report.proved.append(f"{queue} never overflows")
                continue
            witness = self._witness(checked, losing)
            if witness is None:
                checked.leave_open(f"how {queue} overflows", OUT_OF_MEMORY)
            checked.report.findings.append(self.LOSES.found(*queue.elements, witness=witness, queue=queue))

    def _ask_on_the_way(self, checked: Checked, known: Firings) -> None:
        subject = checked.subject
        for queue in queues(subject):
            drops = [subject.transition_index[drop] for drop in queue.drops]
            losing = [known.traces[drop] for drop in drops if drop in known.traces]
            if losing:
                witness = witness_of(subject, min(losing, key=len))
                checked.report.findings.append(
                    self.LOSES.found(*queue.elements, witness=witness, queue=queue)
                )
            elif known.dead.issuperset(drops):
                checked.report.proved.append(f"{queue} never overflows")
            else:
                checked.leave_open(f"whether {queue} can overflow", known.why_open)

    @staticmethod
    def _witness(checked: Checked, transition: str) -> Witness | None:
        """Return a sequence that ends with a transition: a shortest one where few markings are nearer."""
        # Most models need no search.
        from dineros.analysis.questions.reachability import find_firing, way_to_firing

        subject = checked.subject
        number = subject.transition_index[transition]
        trace = find_firing(subject.net, number, checked.budget.share(most_bytes=NEAR)).trace
        if trace is None:
            try:
                trace = way_to_firing(checked.space, subject.names, number)
            except DiagramMemoryError:
                return None
        return witness_of(subject, trace)


class Use(Question):
    """Whether everything is used."""

    faults = unused.FAULTS
    asks = "what can never happen"

    def ask(self, checked: Checked) -> None:
        """Look for transitions that no marking enables."""
        names, known = checked.subject.net.transitions, checked.firings
        if known is None:
            dead = {index for index, name in enumerate(names) if checked.space.enabled(name) == 0}
            is_open: list[str] = []
        else:
            dead = known.dead
            is_open = [checked.subject.transition_text(t) for t in range(len(names)) if known.is_open(t)]
        found = unused.unused_parts(checked.subject, dead)
        checked.report.findings += found
        if known is not None and is_open:
            checked.leave_open(f"whether this can ever happen: {', '.join(is_open)}", known.why_open)
        elif not found:
            checked.report.proved.append("every transition can fire, every channel is used")


class Deadlock(Question):
    """Whether there is a deadlock."""

    STUCK = Fault("deadlock", "warning", "A marking can be reached that enables nothing.", "{markings}")
    faults = (STUCK,)
    asks = "whether there is a deadlock"

    def ask(self, checked: Checked) -> None:
        """Group the markings that enable nothing."""
        from dineros.analysis.questions.deadlocks import deadlock_groups, group_at, group_text

        subject, found, known = checked.subject, False, checked.firings
        if known is not None:
            if known.deadlock is not None:
                group = group_at(subject, known.deadlock)
                waits = dict.fromkeys(subject.transition_element(cause.transition) for cause in group.causes)
                witness, text = witness_of(subject, group.trace), group_text(subject, group)
                checked.report.findings.append(
                    self.STUCK.found(*waits, checked.identity, witness=witness, markings=text)
                )
            if known.has_no_deadlock:
                checked.report.proved.append("no deadlock")
            elif not known.is_complete:
                question = "what else is a deadlock" if known.deadlock else "whether there is a deadlock"
                checked.leave_open(question, known.why_open)
            return
        try:
            for group in deadlock_groups(subject, checked.space):
                found = True
                waits = dict.fromkeys(subject.transition_element(cause.transition) for cause in group.causes)
                witness, text = witness_of(subject, group.trace), group_text(subject, group)
                checked.report.findings.append(
                    self.STUCK.found(*waits, checked.identity, witness=witness, markings=text)
                )
        except DiagramMemoryError:
            question = "what else is a deadlock" if found else "whether there is a deadlock"
            checked.leave_open(question, OUT_OF_MEMORY)
            return
        if not found:
            checked.report.proved.append("no deadlock")


class Repetition(Question):
    """What can happen again and again: liveness, reversibility, home markings.

    Few applications are live, so what fails is a note, no fault. Losing messages for ever is no part of being
    live. What needs more than the work given stays unknown.
    """

    NOT_LIVE = Fault(
        "not-live",
        "note",
        "A marking can be reached from which a transition never fires again.",
        "some marking shuts off for ever: {transitions}",
    )
    NOT_REVERSIBLE = Fault(
        "not-reversible",
        "note",
        "A marking can be reached from which the initial marking cannot be reached again.",
        "the initial marking cannot always be reached again",
    )
    NO_HOME_MARKING = Fault(
        "no-home-marking",
        "note",
        "No marking can be reached from every reachable one.",
        "no marking can always be reached",
    )
    faults = (NOT_LIVE, NOT_REVERSIBLE, NO_HOME_MARKING)
    asks = BEHAVIOUR

    def leave_open(self, checked: Checked, reason: str) -> None:
        """Leave it undecided, which matters only where it was asked for."""
        checked.leave_open(self.asks, reason, may_be_fault=checked.work is None)

    def ask(self, checked: Checked) -> None:
        """Look at the terminal parts of the state space."""
        from dineros.analysis.properties.behaviour import TooMuchWorkError, behaviour

        if checked.firings is not None:
            self.leave_open(checked, checked.firings.why_open)
            return
        try:
            answer = behaviour(checked.space, checked.budget, checked.work)
        except TooMuchWorkError:
            reason = "left, as it takes more work than a check may cost"
            checked.leave_open(BEHAVIOUR, reason, "--behaviour decides it", may_be_fault=False)
            return
        except DiagramMemoryError:
            self.leave_open(checked, OUT_OF_MEMORY)
            return
        subject, found, proved = checked.subject, checked.report.findings, checked.report.proved
        drops = {subject.transition_index[drop] for queue in queues(subject) for drop in queue.drops}
        shut_off = (subject.transition_text(t) for t in answer.not_live if t not in drops)
        names = tuple(dict.fromkeys([*subject.blocked, *shut_off]))
        if names:
            shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
            found.append(self.NOT_LIVE.found(checked.identity, transitions=shown))
        else:
            proved.append("the net is live: every transition can always fire again")
        if answer.reversible:
            proved.append("the net is reversible: the initial marking can always be reached again")
        else:
            found.append(self.NOT_REVERSIBLE.found(checked.identity))
        if answer.home_markings:
            proved.append(f"{answer.home_markings} home markings can always be reached")
        else:
            found.append(self.NO_HOME_MARKING.found(checked.identity))


QUESTIONS: tuple[Question, ...] = (
    Clauses(),
    Matching(),
    Boundedness(),
    Overflow(),
    Use(),
    Deadlock(),
    Repetition(),
)
"""All questions, in the order they are asked."""

FAULTS = {fault.rule: fault for question in QUESTIONS for fault in question.faults}
"""All that a check may find, by its rule."""
