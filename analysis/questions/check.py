"""Every question with a yes/no answer that can be asked of any model (paper, Sect. 7).

The complete state space of the net without signals answers most of them at once; a witness is then searched
breadth first, so that it is a shortest one. Where it costs much, a smaller net may answer instead; where it
has no end, what can be answered on the way is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.callbacks.blocking import blocked
from dineros.analysis.callbacks.waiting import Circle
from dineros.analysis.covering.firings import Firings, firings
from dineros.analysis.covering.growth import growth_of, remedy_of
from dineros.analysis.model.queues import queues
from dineros.analysis.model.satisfiability import unsatisfiable_clauses
from dineros.analysis.model.subject import base_subject
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.witness import replay
from dineros.analysis.questions import unused
from dineros.analysis.questions.matching import Matching, Presence
from dineros.analysis.questions.question import Checked, Question
from dineros.analysis.questions.remedies import remedy_text
from dineros.analysis.questions.repetition import Repetition
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Fault, Report, Witness, pumping_witness, witness_of
from dineros.metamodel import pn, sym

if TYPE_CHECKING:
    from dineros.analysis.questions.deadlocks import DeadlockGroup

CHEAP = 1_500_000
"""Cache misses of saturation, about half a second, that liveness and the like may cost by default."""

FIRST_SHARE = 4_000_000
"""Cache misses of saturation, a few seconds, that the state space may cost before a smaller net is asked."""

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


class _RecurrentError(Exception):
    """A smaller net answers what the state space was made for."""


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
        try:
            reason = self._make_space(checked)
        except UnknownBoundError as error:
            pumping = growth_of(subject.net, checked.budget.share(0.3))
            if pumping is None:
                checked.leave_open("whether the net is bounded", str(error))
            else:
                self._grows(checked, pumping)
        except LevelSizeError as error:
            if not self._recurs(checked):
                checked.close(self.asks, error.message)
            return
        else:
            if not reason or self._recurs(checked):
                return
            checked.leave_open("whether the net is bounded", reason)
        checked.budget.stage("what can happen without bounds")
        checked.firings = firings(subject.net, checked.budget)

    def _make_space(self, checked: Checked) -> str:
        """Make the state space; return why there is none, which is empty where there is one."""
        share, between = checked.budget.share(SPACE_SHARE), partial(self._look_elsewhere, checked)
        try:
            space = symbolic_state_space(checked.subject.net, share, orders=checked.orders, between=between)
        except _RecurrentError:
            return "a smaller net answers"
        except BudgetExceededError as limit:
            return str(limit)
        if not space.complete:
            return RAN_OUT[space.reason]
        checked.space = checked.report.space = space
        checked.report.proved.append(
            f"the net is bounded: {space.markings} markings without signals, "
            f"at most {max(space.largest_place(), default=0)} tokens in a place"
        )
        return ""

    @staticmethod
    def _look_elsewhere(checked: Checked, work: int) -> None:
        """End the making of a state space that costs much where a smaller net answers."""
        if work >= FIRST_SHARE and checked.recurrence is not None:
            raise _RecurrentError

    @staticmethod
    def _recurs(checked: Checked) -> bool:
        """Whether a smaller net answers instead; if so, note what it says of firings."""
        proof = checked.recurrence
        if proof is None:
            return False
        checked.report.proved.append(
            f"the net is bounded: no place ever holds more than {max(proof.bounds, default=0)} tokens; "
            "its markings are not counted, as that takes too much work"
        )
        # Lost messages never come back: where the net does, no queue overflows.
        possible = frozenset(range(len(checked.subject.net.transitions))) - proof.dead
        checked.recurs = True
        checked.firings = Firings(
            possible=possible, dead=set(proof.dead), has_no_deadlock=True, is_complete=True
        )
        return True

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
        "{queue} can overflow: {loss}",
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
            witness = checked.way_to(losing)
            if witness is None:
                checked.leave_open(f"how {queue} overflows", OUT_OF_MEMORY)
            checked.report.findings.append(
                self.LOSES.found(*queue.elements, witness=witness, queue=queue, loss=queue.loss)
            )

    def _ask_on_the_way(self, checked: Checked, known: Firings) -> None:
        subject = checked.subject
        for queue in queues(subject):
            drops = [subject.transition_index[drop] for drop in queue.drops]
            losing = [known.traces[drop] for drop in drops if drop in known.traces]
            if losing:
                witness = witness_of(subject, min(losing, key=len))
                checked.report.findings.append(
                    self.LOSES.found(*queue.elements, witness=witness, queue=queue, loss=queue.loss)
                )
            elif known.dead.issuperset(drops):
                checked.report.proved.append(f"{queue} never overflows")
            else:
                checked.leave_open(f"whether {queue} can overflow", known.why_open)


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
        checked.report.dead = [names[index] for index in sorted(dead)]
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
        from dineros.analysis.questions.deadlocks import deadlock_groups, group_at

        subject, found, known = checked.subject, False, checked.firings
        if known is not None:
            if known.deadlock is not None:
                self._find(checked, group_at(subject, known.deadlock))
            if known.has_no_deadlock:
                checked.report.proved.append("no deadlock")
            elif not known.is_complete:
                question = "what else is a deadlock" if known.deadlock else "whether there is a deadlock"
                checked.leave_open(question, known.why_open)
            return
        try:
            for group in deadlock_groups(subject, checked.space):
                found = True
                self._find(checked, group)
        except DiagramMemoryError:
            question = "what else is a deadlock" if found else "whether there is a deadlock"
            checked.leave_open(question, OUT_OF_MEMORY)
            return
        if not found:
            checked.report.proved.append("no deadlock")

    def _find(self, checked: Checked, group: DeadlockGroup) -> None:
        from dineros.analysis.questions.deadlocks import group_text

        subject, witness = checked.subject, witness_of(checked.subject, group.trace)
        circle = checked.waiting.circle(replay(subject.net, group.trace)[-1])
        if circle is not None:
            Callbacks.find(checked, circle, witness)
            return
        waits = dict.fromkeys(subject.transition_element(cause.transition) for cause in group.causes)
        text = group_text(subject, group)
        checked.report.findings.append(
            self.STUCK.found(*waits, checked.identity, witness=witness, markings=text)
        )


class Callbacks(Question):
    """Whether callbacks can wait for ever, in nodes that run callbacks."""

    CIRCLE = Fault(
        "callback-deadlock",
        "error",
        "Callbacks, callback groups, threads and calls can wait for each other in a circle.",
        "{circle}",
    )
    ENDLESS = Fault(
        "callback-never-ends",
        "error",
        "A callback can wait for ever, and so can those that need its thread or its group.",
        "{callback} can begin and never end",
    )
    faults = (CIRCLE, ENDLESS)
    asks = "which callbacks can wait for ever"

    def ask(self, checked: Checked) -> None:
        """Look for callbacks that never end from some marking on."""
        if not checked.waiting.callbacks:
            return
        if checked.firings is not None:
            if checked.recurs:
                checked.report.proved.append("every callback that has begun can end")
            else:
                checked.leave_open(self.asks, checked.firings.why_open or "the markings were not all seen")
            return
        found = False
        try:
            for each in blocked(checked.subject, checked.space, checked.waiting, checked.budget):
                found = True
                witness = witness_of(checked.subject, each.trace)
                if each.circle is not None:
                    self.find(checked, each.circle, witness)
                else:
                    callback = each.callback
                    checked.report.findings.append(
                        self.ENDLESS.found(callback.element, witness=witness, callback=callback.text)
                    )
        except DiagramMemoryError:
            checked.leave_open(self.asks, OUT_OF_MEMORY)
            return
        if not found:
            checked.report.proved.append("every callback that has begun can end")

    @classmethod
    def find(cls, checked: Checked, circle: Circle, witness: Witness) -> None:
        """Put a circle into the report, once."""
        waiters = [waiter.text for waiter in circle.waiters]
        finding = cls.CIRCLE.found(*circle.elements, witness=witness, waiters=waiters, circle=circle)
        if all(other.message != finding.message for other in checked.report.findings):
            checked.report.findings.append(finding)


QUESTIONS: tuple[Question, ...] = (
    Clauses(),
    Matching(),
    Boundedness(),
    Overflow(),
    Presence(),
    Use(),
    Deadlock(),
    Callbacks(),
    Repetition(),
)
"""All questions, in the order they are asked."""

FAULTS = {fault.rule: fault for question in QUESTIONS for fault in question.faults}
"""All that a check may find, by its rule."""
