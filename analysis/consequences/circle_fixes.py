"""Changes after which callbacks no longer wait for each other in a circle."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Sequence
from itertools import count

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.stages import Share
from dineros.analysis.callbacks.blocking import Blocked
from dineros.analysis.callbacks.circles import Circle
from dineros.analysis.callbacks.searching import searched
from dineros.analysis.callbacks.waiting import Waiting
from dineros.analysis.model.subject import Subject, base_subject
from dineros.analysis.suggestions.changes import Changes, against_circle
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.elements import channels
from dineros.metamodel.settings import apply
from dineros.transformations.language.copying import deep_copy

MOST_CHANGES = 4
"""Changes together that are tried against callbacks that wait for each other."""
MOST_MODELS = 12
"""Models that are tried."""
CHANGES = Share(time=0.5)
"""Part of the time in which such changes are tried; time-outs of calls have the rest."""
Fix = Callable[[sym.SystemModel], None]
"""Changes a copy of the model in place."""


def against_waiting(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Search for the fewest changes after which the callbacks of a circle do not wait in one.

    Raises
    ------
    BudgetExceededError
        Time or memory ran out before a change was found.
    """
    circle = circle_of(finding)
    if circle is None:
        return None
    pages = _pages_in(circle)
    order, known, tried = count(), {Changes()}, 0
    without_circle: Fix | None = None
    queue = _added(Changes(), circle, known, order)
    trying = CHANGES.share(budget)
    ended: BudgetExceededError | None = None
    while queue and tried < MOST_MODELS:
        (size, *_), _, changes = heapq.heappop(queue)
        if size > MOST_CHANGES:
            break
        tried += 1
        try:
            trying.check_time()
            blocked = _blocked(changes.applied(model), pages, trying)
        except BudgetExceededError as error:
            ended = error
            break
        if blocked is None:
            continue
        fix = with_settings([setting for _, each in changes.steps(model) for setting in each])
        if not blocked:
            return fix
        left = _circle_in(blocked)
        if left is None:  # they wait for something else: another fault
            without_circle = without_circle or fix
            continue
        for more in _added(changes, left, known, order):
            heapq.heappush(queue, more)
    last = _with_time_outs(model, circle, pages, budget) or without_circle
    if last is None and ended is not None:
        raise ended
    return last


def let_calls_end(model: sym.SystemModel, finding: Finding, budget: Budget) -> Fix | None:
    """Return time-outs for the calls of callbacks that wait in a circle; None if they wait all the same.

    This is cheaper than a search for groups and threads, and lets the callbacks do more.
    """
    circle = circle_of(finding)
    return None if circle is None else _with_time_outs(model, circle, _pages_in(circle), budget)


def circle_of(finding: Finding) -> Circle | None:
    """Return the circle of a finding, from the marking that its witness leads to."""
    witness = finding.witness
    return None if witness is None or witness.subject is None else circle_after(finding, witness.subject)


def circle_after(finding: Finding, subject: Subject) -> Circle | None:
    """Return the circle of a finding after the steps of its witness; None if they do not close it."""
    assert finding.witness is not None
    marking, waiting = finding.witness.ends_at(subject), Waiting(subject)
    if marking is None:
        return None
    closed = [waiting.circle(marking, callback.waiter) for callback in waiting.callbacks.values()]
    return next((each for each in closed if each is not None and each.elements == finding.elements), None)


def _pages_in(circle: Circle) -> set[str]:
    return {waiter.element for waiter in circle.waiters if waiter.kind == "callback"}


def _with_time_outs(model: sym.SystemModel, circle: Circle, pages: set[str], budget: Budget) -> Fix | None:
    """Let the callbacks of a circle end without responses; None if they wait all the same.

    If they wait in another circle then, the calls of that circle end as well.
    """
    ended: set[str] = set()

    def fix(copied: sym.SystemModel) -> None:
        for service in channels(copied, sym.ServiceChannel):
            if service.id in ended:
                for client in service.clients:
                    page = callback_page_of(client.request)
                    if page is not None and page.id in pages:
                        end_call(client)

    left: Circle | None = circle
    while left is not None and not ended.issuperset(left.elements):
        ended.update(left.elements)
        copied, _ = deep_copy(model)
        assert isinstance(copied, sym.SystemModel)
        fix(copied)
        blocked = _blocked(copied, pages, budget)
        if not blocked:
            return fix if blocked == [] else None
        left = _circle_in(blocked)
    return None


def _circle_in(blocked: Sequence[Blocked]) -> Circle | None:
    """Return a circle in which callbacks wait, if there is one."""
    return next((each.circle for each in blocked if each.circle is not None), None)


def end_call(client: sym.ClientPort) -> None:
    """Let a client continue without a response."""
    client.timeout, client.timedOut = client.timeout or 1.0, client.response


_Entry = tuple[tuple[int, int, int, int, int], int, Changes]


def _added(changes: Changes, circle: Circle, known: set[Changes], order: count[int]) -> list[_Entry]:
    """Return these changes, each with one more that may break a circle, as entries of a heap."""
    found = [more for more in against_circle(changes, circle) if more not in known]
    known.update(found)
    return sorted((more.cost, next(order), more) for more in dict.fromkeys(found))


def _blocked(model: sym.SystemModel, pages: set[str], budget: Budget) -> list[Blocked] | None:
    """Return the callbacks of some pages that can wait forever; None if it is unknown."""
    subject = base_subject(model)
    search = searched(subject.net, Waiting(subject), budget, pages)
    found = [each for each in search.blocked if _is_of(each, pages)]
    return found if found or search.is_settled else None


def _is_of(blocked: Blocked, pages: set[str]) -> bool:
    inside = (blocked.callback, *(blocked.circle.waiters if blocked.circle is not None else ()))
    return any(waiter.kind == "callback" and waiter.element in pages for waiter in inside)


def with_settings(settings: Sequence[str]) -> Fix:
    """Return the change that applies some settings."""

    def fix(copied: sym.SystemModel) -> None:
        for setting in settings:
            apply(copied, setting)

    return fix
