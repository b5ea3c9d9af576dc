"""Ways to a marking in time: a firing sequence that some schedule has, or the proof that there is none.

Classes are compared by inclusion, so only the largest ones are kept; they reach the same markings.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.graphs.predicates import Flags, MarkingMatrix, combination, holds
from dineros.analysis.logic.language.atoms import BoundAtoms, NoneEnabled
from dineros.analysis.logic.language.names import Names, NetNames, resolved
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Atom, Formula, Name
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.schedules import schedule
from dineros.analysis.timed.search import ClassSearch

Found = tuple[int, tuple[int, ...]]
"""A class, and what is fired there last."""


def find_timed(
    net: TimedNet,
    condition: str | Formula,
    names: Names | None = None,
    budget: Budget = UNLIMITED,
    observed: TimedNet | None = None,
    kind: Kind | None = None,
) -> Outcome:
    """Find a firing sequence to a marking that fulfils a condition, with as few firings as possible.

    Parameters
    ----------
    condition
        On markings. ``enabled(t)`` says that the tokens are there; ``deadlock`` that nothing can fire any
        more, however long one waits.
    names
        What names stand for; by default places and transitions of the net.
    observed
        The net without its observer, if `net` has one: ``deadlock`` is about that.
    kind
        Which state classes; by default the largest ones that the net allows.

    Returns
    -------
    Outcome
        ``reachable`` with a sequence that has a schedule, or ``unreachable``.

    Raises
    ------
    FormulaError
        The condition is not one on markings, or names something unknown.
    """
    names = names or NetNames(net.untimed)
    tree = parse(condition, "state") if isinstance(condition, str) else condition
    atoms = BoundAtoms(net.untimed, tree, names)
    looked = 0

    def where(markings: np.ndarray[tuple[int, ...], np.dtype[np.int64]], dead: Flags) -> Flags:
        def evaluate(atom: Atom) -> Flags:
            condition = atoms.conditions[atom]
            if not isinstance(condition, NoneEnabled):
                return holds(MarkingMatrix(net.untimed, markings), condition)
            return dead if observed is None else MarkingMatrix(observed.untimed, markings).deadlocks()

        return combination(tree, evaluate, len(markings))

    def among_markings(search: ClassSearch) -> Found | None:
        nonlocal looked
        markings = search.markings(looked)
        rows = np.flatnonzero(where(markings, np.zeros(len(markings), dtype=np.bool_)))
        first, looked = looked, looked + len(markings)
        if not len(rows):
            return None
        return int(np.flatnonzero(np.isin(search.marking_of, first + rows))[0]), ()

    def among_classes(search: ClassSearch) -> Found | None:
        if search.reason is not None or not search.is_done:
            return None
        held = where(search.markings()[search.marking_of], search.dead())
        return (int(np.flatnonzero(held)[0]), ()) if held.any() else None

    asks_for_deadlock = any(isinstance(one, NoneEnabled) for one in atoms.conditions.values())
    is_late = asks_for_deadlock and observed is None
    return _searched(net, budget, among_classes if is_late else among_markings, kind)


def find_timed_firing(
    net: TimedNet,
    transition: str,
    names: Names | None = None,
    budget: Budget = UNLIMITED,
    kind: Kind | None = None,
) -> Outcome:
    """Find a firing sequence whose last transition is one of a name; see `find_timed`.

    With time, a transition may have its tokens and never fire, as others are always sooner.
    """
    chosen = sorted(resolved((names or NetNames(net.untimed)).transitions, Name(transition)))

    def by_edge(search: ClassSearch) -> Found | None:
        edge = search.first_edge(chosen)
        return None if edge is None else (edge[0], (edge[1],))

    return _searched(net, budget, by_edge, kind)


def _searched(
    net: TimedNet, budget: Budget, look: Callable[[ClassSearch], Found | None], kind: Kind | None
) -> Outcome:
    """Search until a class is found; what leads there has a schedule."""
    budget = budget.begun()
    kind = kind or ("E" if net.has_priorities else "M")
    search = ClassSearch(net, kind, budget, keeps_edges=True, keeps_parents=True, is_breadth_first=True)
    found: list[Found] = []

    def is_met() -> bool:
        met = look(search)
        if met is not None:
            found.append(met)
        return met is not None

    search.run(is_met)
    if found or is_met():
        number, last = found[0]
        trace = (*search.trace(number), *last)
        schedule(net, trace)  # a sequence without a schedule is an error of this program
        return Outcome("reachable", trace, states=search.classes, seconds=budget.spent, by="state classes")
    if search.reason is None:
        return Outcome("unreachable", states=search.classes, seconds=budget.spent, by="state classes")
    reason = RAN_OUT.get(search.reason, search.reason)
    return Outcome("unknown", states=search.classes, seconds=budget.spent, reason=reason)
