"""The smallest change of callback groups and threads after which no callback waits forever.

Changes are tried in the order of their number. If a model with some changes still has a circle, only such
changes are added as may break it. One kind lets more happen: a callback or client leaves an exclusive group,
a group becomes reentrant, an executor has more threads. The other kind prevents the run that leads to the
circle: callbacks that run at once in it share an exclusive group, or the executor has fewer threads, or a
callback that runs twice at once gets an exclusive group. Without one of these, the run stays possible and its
circle closed. So every change that fixes the model is found this way, and the smallest first (R. Reiter, *A
theory of diagnosis from first principles*, Artificial Intelligence 32(1), 1987: hitting sets). Changes that
reduce concurrency count as two.

A callback that never ends, and is in no circle, cannot be repaired if it would not end even with enough
threads and free groups. A cancel request that the server never receives may also be fixed by `async def`.

Each model is checked as `check` does: what is suggested is proved.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import count

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.callbacks.walking import Walks
from dineros.analysis.checks.blocking import Callbacks, Deadlock
from dineros.analysis.checks.boundedness import Boundedness
from dineros.analysis.checks.check import check
from dineros.analysis.checks.goals import Cancels, Goals
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.checks.properties import Properties
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.witness import replay
from dineros.analysis.suggestions.changes import (
    Changes,
    against_circle,
    against_run,
    against_unheard,
    against_waiting,
)
from dineros.analysis.witnesses.findings import Finding, Report
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find

MOST_CHANGES = 8
"""Changes together, beyond which the search gives up."""

QUESTIONS = (Boundedness(), Overflow(), Deadlock(), Callbacks(), Cancels())
WAITS = frozenset({Callbacks.CIRCLE.rule, Callbacks.ENDLESS.rule, Goals.UNHEARD.rule})


@dataclass
class Suggestion:
    """What to change."""

    faults: list[Finding] = field(default_factory=list)
    """What is to be fixed: callbacks that can wait forever, requests to cancel that are never heard."""
    changes: list[tuple[str, tuple[str, ...]]] = field(default_factory=list)
    """Each change in words, and as settings of the model."""
    others: list[list[tuple[str, tuple[str, ...]]]] = field(default_factory=list)
    """As many other changes that fix all of it, too: callbacks that await."""
    breaks: list[str] = field(default_factory=list)
    """Messages about properties of the model that do not hold any more with the changes."""
    is_found: bool = False
    """Whether the changes fix all of it; without faults there are none."""
    is_proved: bool = False
    """Whether it is proved that no smaller change does; if nothing is found, that no change does."""
    tried: int = 0
    """How many models were checked."""
    proved: list[str] = field(default_factory=list)
    """What is proved of the model with the changes."""
    reason: str = "not yet searched"
    """Why nothing is found, or why it is not proved that there is nothing smaller."""


def suggest_callback_groups(
    model: sym.SystemModel, budget: Budget = UNLIMITED, suggestion: Suggestion | None = None
) -> Suggestion:
    """Return the smallest change after which no callback waits forever and no more queues overflow.

    Callbacks and clients of services and actions may get callback groups of their own, or share one, groups
    may become reentrant, and executors may get more or fewer threads; what the callbacks do stays as it is.
    Only a callback that works on goals, and never receives a cancel request, may await instead.

    Parameters
    ----------
    model : sym.SystemModel
        The model; it is not changed.
    budget : Budget, optional
        Of all searches together; its memory is that of each.
    suggestion : Suggestion, optional
        Where to put the answer as it comes, for those who want it after an interruption.
    """
    suggestion = Suggestion() if suggestion is None else suggestion
    search = _ChangeSearch(model, budget.begun(), suggestion)
    try:
        search.run()
    except BudgetExceededError as limit:
        suggestion.reason = str(limit)
    return suggestion


class _ChangeSearch:
    """A search through changes, the fewest first."""

    def __init__(self, model: sym.SystemModel, budget: Budget, suggestion: Suggestion) -> None:
        self._model = model
        self._budget = budget
        self._suggestion = suggestion
        self._lost: set[tuple[str, ...]] = set()
        """Elements of the queues that overflow in the model as it is."""
        self._open = ""
        """Why some model that was tried is not decided."""

    def run(self) -> None:
        """Find the changes."""
        suggestion, order, known = self._suggestion, count(), {Changes()}
        queue = [(Changes().cost, next(order), Changes())]
        while queue:
            (size, *_), _, changes = heapq.heappop(queue)
            if size > MOST_CHANGES:
                suggestion.reason = f"no {MOST_CHANGES} changes suffice, and more were not tried"
                return
            self._budget.stage(f"{size} changes, {suggestion.tried} models")
            self._budget.check_time()
            made = self._changed(changes)
            if made is None:
                continue
            report = check(made, self._budget, questions=QUESTIONS)
            suggestion.tried += 1
            faults = self._faults(report, is_first=not changes.cost[0])
            if not faults and not report.unknown:
                self._found(changes, made, report)
                self._find_others([changes for (cost, *_), _, changes in queue if cost == size])
                return
            if not faults:
                self._open = self._open or str(report.unknown[0])
                continue
            for more in self._least_added(changes, faults):
                if more not in known:
                    known.add(more)
                    heapq.heappush(queue, (more.cost, next(order), more))
        suggestion.is_proved = not self._open
        suggestion.reason = self._open or "no change of callback groups and threads suffices"

    def _found(self, changes: Changes, made: sym.SystemModel, report: Report) -> None:
        suggestion = self._suggestion
        suggestion.changes = list(changes.steps(self._model))
        suggestion.proved = report.proved
        suggestion.is_found = True
        suggestion.is_proved = not self._open or changes.cost[0] <= 1
        suggestion.reason = "" if suggestion.is_proved else self._open
        if suggestion.changes and self._model.properties:
            questions = (Boundedness(), Properties())
            before = {
                each.elements for each in check(self._model, self._budget, questions=questions).findings
            }
            after = check(made, self._budget, questions=questions).findings
            suggestion.breaks = [each.message for each in after if each.elements not in before]

    def _find_others(self, left: list[Changes]) -> None:
        """Try the remaining changes of the same size in which callbacks await: another kind of change."""
        for changes in left:
            made = self._changed(changes) if changes.awaiting else None
            if made is None:
                continue
            self._budget.check_time()
            report = check(made, self._budget, questions=QUESTIONS)
            self._suggestion.tried += 1
            if not report.unknown and not self._faults(report, is_first=False):
                self._suggestion.others.append(list(changes.steps(self._model)))

    def _changed(self, changes: Changes) -> sym.SystemModel | None:
        """Return the model with some changes; None if the changed model would be invalid."""
        copied = changes.applied(self._model)
        if changes.cost[0] and any(found.severity == "error" for found in validate(copied)):
            return None
        return copied

    def _faults(self, report: Report, is_first: bool) -> list[Finding]:
        """Return the faults to avoid: callbacks that wait forever, and losses that are new in the model."""
        waits = [finding for finding in report.findings if finding.rule in WAITS]
        losses = [finding for finding in report.findings if finding.rule == Overflow.LOSES.rule]
        if is_first:
            self._suggestion.faults = waits
            self._lost = {finding.elements for finding in losses}
            if report.unknown and not waits:
                self._suggestion.reason = str(report.unknown[0])
        return [*waits, *(finding for finding in losses if finding.elements not in self._lost)]

    def _least_added(self, changes: Changes, faults: list[Finding]) -> list[Changes]:
        """Return additions of which each solution has one; none if some fault cannot be fixed."""
        added = list(self._added(changes, faults[0]))
        for fault in faults[1:] if added else []:
            was_open, self._open = self._open, ""
            is_fixed = next(self._added(changes, fault), None) is not None or self._open
            self._open = was_open
            if not is_fixed:
                return []
        return added

    def _added(self, changes: Changes, fault: Finding) -> Iterator[Changes]:
        """Yield these changes with one more that may fix a fault."""
        if fault.rule == Goals.UNHEARD.rule:
            action = find(self._model, fault.elements[0], sym.ActionChannel)
            if isinstance(action.server.page, sym.CallbackPage):
                yield from against_unheard(changes, action.server.page)
            return
        witness = fault.witness
        if witness is None or witness.subject is None:
            self._open = self._open or f"the cause is unknown: {fault.message}"
            return
        subject = witness.subject
        waiting = Waiting(subject)
        trace = [subject.transition_index[step.transition] for step in witness.steps]
        markings = replay(subject.net, trace)
        circle = waiting.circle(markings[-1])
        if circle is not None:
            yield from against_circle(changes, circle)
        elif fault.rule == Callbacks.ENDLESS.rule:
            yield from self._against_endless(changes, fault, waiting, subject, markings[-1])
        yield from against_run(changes, list(waiting.callbacks.values()), markings)

    def _against_endless(
        self, changes: Changes, fault: Finding, waiting: Waiting, subject: Subject, marking: list[int]
    ) -> Iterator[Changes]:
        """Yield changes that may repair a callback that never ends and is in no known circle."""
        walks = Walks(subject.net, waiting)
        ended = [
            each
            for each in waiting.callbacks.values()
            if each.waiter.element == fault.elements[0] and each.has_begun(marking)
        ]
        if all(walks.never_ends_at_best(each, marking) for each in ended):
            return
        taken = [waiter for place, waiter in waiting.resources.items() if marking[place] == 0]
        self._open = self._open or f"not all remedies are known for: {fault.message}"
        yield from against_waiting(changes, taken)
