"""Every question with a yes/no answer that can be asked of any model (paper, Sect. 7).

The complete state space of the net without signals answers most of them at once; a witness is then searched
breadth first, so that it is a shortest one.
"""

from __future__ import annotations

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.model.queues import queues
from dineros.analysis.model.satisfiability import unsatisfiable_clauses
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.questions.unused import unused_parts
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.order_cache import OrderCache
from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.witnesses.findings import Finding, Report, Witness, witness_of
from dineros.metamodel import pn, sym

CHEAP = 1_500_000
"""Cache misses of saturation, about half a second, that liveness and the like may cost by default."""

NEAR = 64 << 20
"""Bytes for the search for a shortest way to a fault; one that is further off is found by the state space."""

BEHAVIOUR = "liveness, reversibility, home markings"
OUT_OF_MEMORY = "memory ran out"


def check(
    model: pn.Net,
    budget: Budget = UNLIMITED,
    report: Report | None = None,
    at_any_cost: bool = False,
    orders: OrderCache | None = None,
) -> Report:
    """Ask everything that can be asked of any model.

    Parameters
    ----------
    model : pn.Net
        A system model, or any place/transition net.
    budget : Budget, optional
        What it may cost; running out of memory leaves questions unknown.
    report : Report, optional
        Where to put the answers as they come, for those who want them after an interruption.
    at_any_cost : bool
        Whether to decide liveness, reversibility and home markings also where that takes long.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    """
    report = Report() if report is None else report
    if isinstance(model, sym.SystemModel):
        _clauses(model, report)
    subject = base_subject(model)
    try:
        space = symbolic_state_space(subject.net, budget, orders=orders)
    except UnknownBoundError as error:
        _unbounded(subject, report, str(error))
        return report
    except LevelSizeError as error:
        report.unknown.append(Outcome.left_open("all questions on the state space", error.message))
        return report
    if not space.complete:
        report.unknown.append(
            Outcome.left_open("all questions on the state space", f"{space.reason} ran out")
        )
        return report
    _bounded(space, report)
    _overflows(subject, space, report, budget)
    dead = {index for index, name in enumerate(subject.net.transitions) if space.enabled(name) == 0}
    drops = {subject.transition_index[drop] for queue in queues(subject) for drop in queue.drops}
    unused = unused_parts(subject, dead)
    report.findings += unused
    if not unused:
        report.proved.append("every transition can fire, every channel is used")
    _deadlocks(subject, space, report)
    _behaviour(subject, space, drops, report, budget, None if at_any_cost else CHEAP)
    return report


def _clauses(model: sym.SystemModel, report: Report) -> None:
    found = unsatisfiable_clauses(model)
    for clause in found:
        report.findings.append(
            Finding("unsatisfiable-clause", "error", (str(clause.transition.id),), str(clause))
        )
    if not found:
        report.proved.append("every clause can be true")


def _bounded(space: SymbolicStateSpace, report: Report) -> None:
    report.proved.append(
        f"the net is bounded: {space.markings} markings without signals, "
        f"at most {max(space.largest_place(), default=0)} tokens in a place"
    )


def _unbounded(subject: Subject, report: Report, reason: str) -> None:
    answer = coverability(subject.net)
    if answer.pumping is None:
        report.unknown.append(Outcome.left_open("whether the net is bounded", reason))
        return
    pumping = answer.pumping
    grown = tuple(subject.place_text(place) for place in pumping.places)
    report.findings.append(
        Finding(
            "unbounded",
            "error",
            grown,
            f"tokens grow without bound: {', '.join(grown)}",
            witness_of(subject, [*pumping.prefix, *pumping.suffix], loop=len(pumping.prefix)),
        )
    )
    report.unknown.append(Outcome.left_open("all questions on the state space", "it is infinite"))


def _overflows(subject: Subject, space: SymbolicStateSpace, report: Report, budget: Budget) -> None:
    for queue in queues(subject):
        losing = next((drop for drop in queue.drops if space.enabled(drop)), None)
        if losing is None:
            report.proved.append(f"{queue} never overflows")
            continue
        message = f"{queue} can overflow: a message is lost"
        witness = _witness(subject, space, losing, budget)
        if witness is None:
            report.unknown.append(Outcome.left_open(f"how {queue} overflows", OUT_OF_MEMORY))
        report.findings.append(Finding("queue-overflow", "error", queue.elements, message, witness))


def _witness(subject: Subject, space: SymbolicStateSpace, transition: str, budget: Budget) -> Witness | None:
    """Return a firing sequence that ends with a transition: a shortest one where few markings are nearer."""
    # Most models need no search.
    from dineros.analysis.questions.reachability import find_firing, way_to_firing

    number = subject.transition_index[transition]
    trace = find_firing(subject.net, number, budget.share(most_bytes=NEAR)).trace
    if trace is None:
        try:
            trace = way_to_firing(space, subject.names, number)
        except DiagramMemoryError:
            return None
    return witness_of(subject, trace)


def _deadlocks(subject: Subject, space: SymbolicStateSpace, report: Report) -> None:
    from dineros.analysis.questions.deadlocks import deadlock_groups, group_text  # most models need no ways

    found = False
    try:
        for group in deadlock_groups(subject, space):
            found = True
            waiting = dict.fromkeys(subject.transition_element(cause.transition) for cause in group.causes)
            witness = witness_of(subject, group.trace)
            elements = (*waiting, str(subject.model.id))
            report.findings.append(
                Finding("deadlock", "warning", elements, group_text(subject, group), witness)
            )
    except DiagramMemoryError:
        question = "what else is a deadlock" if found else "whether there is a deadlock"
        report.unknown.append(Outcome.left_open(question, OUT_OF_MEMORY))
        return
    if not found:
        report.proved.append("no deadlock")


def _behaviour(
    subject: Subject,
    space: SymbolicStateSpace,
    drops: set[int],
    report: Report,
    budget: Budget,
    work: int | None,
) -> None:
    """Liveness, reversibility, home markings. Few applications are live, so what fails is a note, no fault.

    Losing messages for ever is no part of being live. What needs more than the work given stays unknown.
    """
    from dineros.analysis.questions.behaviour import TooMuchWorkError, behaviour

    try:
        answer = behaviour(space, budget, work)
    except TooMuchWorkError:
        reason, hint = "left, as it takes more work than a check may cost", "--behaviour decides it"
        report.unknown.append(Outcome.left_open(BEHAVIOUR, reason, hint, may_be_fault=False))
        return
    except DiagramMemoryError:
        report.unknown.append(Outcome.left_open(BEHAVIOUR, OUT_OF_MEMORY, may_be_fault=work is None))
        return
    identity = (str(subject.model.id),)
    shut_off = (subject.transition_text(t) for t in answer.not_live if t not in drops)
    names = tuple(dict.fromkeys([*subject.blocked, *shut_off]))
    if names:
        shown = ", ".join(names[:5]) + (f" and {len(names) - 5} more" if len(names) > 5 else "")
        text = f"some marking shuts off for ever: {shown}"
        report.findings.append(Finding("not-live", "note", identity, text))
    else:
        report.proved.append("the net is live: every transition can always fire again")
    if answer.reversible:
        report.proved.append("the net is reversible: the initial marking can always be reached again")
    else:
        text = "the initial marking cannot always be reached again"
        report.findings.append(Finding("not-reversible", "note", identity, text))
    if answer.home_markings:
        report.proved.append(f"{answer.home_markings} home markings can always be reached")
    else:
        text = "no marking can always be reached"
        report.findings.append(Finding("no-home-marking", "note", identity, text))
