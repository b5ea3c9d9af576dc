"""What happens within a time: formulas such as ``G (a -> F[<=d] b)``, decided by an observer.

The observer guesses a moment at which the formula is violated, and measures. It lets one moment begin a
window: one at which ``a`` holds, or the firing that ``a`` is about. From then on, if ``b`` is to come,
classes and firings with ``b`` in the window are left out, and the observer looks for one that outlasts the
window. If ``b`` is to hold, it looks for a moment without it in the window. A guess is free to miss, so the
runs of the net stay what they are; a run that shows a violation has its times. So linear classes decide it.

A condition with ``fired(T)`` is asked at each firing, another one at each marking, from the moment at which
it is reached to the moment at which it is left. Runs in which time does not continue are left out.

References
----------
J. Toussaint, F. Simonot-Lion, J.-P. Thomesse, *Time constraint verification methods based on time Petri
nets*, FTDCS 1997 (observers).
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import FiredAt, Outcome
from dineros.analysis.logic.graphs.predicates import Flags, MarkingMatrix, combination, holds
from dineros.analysis.logic.language.atoms import BoundAtoms, SomeFired
from dineros.analysis.logic.language.bounded import Bounded, Window, is_step
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.durations.paths import shortest_way
from dineros.analysis.timed.durations.watched import GATE, Watched, Watcher, watched
from dineros.analysis.timed.graph import TimedGraph, first_classes
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.schedules import schedule

FREE = Interval()
FIRST_LOOKS = (5_000, 100_000)
"""Classes among which a violation is looked for before all are built: there may be no end of them."""
BY = "state classes and an observer"


def decide_bounded(
    net: TimedNet,
    formula: Bounded,
    names: Names | None = None,
    budget: Budget = UNLIMITED,
    kind: Kind | None = None,
) -> Outcome:
    """Decide whether all runs satisfy a formula that bounds times.

    Parameters
    ----------
    net, formula, names, budget
        The net, the formula, what its names stand for, and limits.
    kind
        Which state classes; by default linear ones if there are no priorities.

    Returns
    -------
    Outcome
        ``holds``, or ``violated`` with a schedule up to the moment that shows it.

    Raises
    ------
    FormulaError
        The formula names something unknown.
    """
    budget = budget.begun()
    atoms = BoundAtoms(net.untimed, formula, names or NetNames(net.untimed))
    observed = _observed(net, formula, atoms)
    way = None
    for most in (*FIRST_LOOKS, None):
        try:
            graph, is_complete = first_classes(
                observed.net, kind or ("S" if net.has_priorities else "W"), budget, most
            )
        except BudgetExceededError as limit:
            return Outcome("unknown", seconds=budget.spent, reason=RAN_OUT.get(str(limit), str(limit)))
        way = _View(graph, observed, formula, atoms).violation()
        if way is not None:
            break
        if is_complete:
            return Outcome("holds", states=graph.classes, seconds=budget.spent, by=BY)
    assert way is not None, "the last look sees all"
    trace = [int(graph.label[edge]) for edge in way]
    times, began = _times(observed, trace)
    plain = observed.trace_of(trace)
    schedule(net, plain)  # a sequence without a schedule is an error of this program
    return Outcome(
        "violated",
        plain,
        states=graph.classes,
        seconds=budget.spent,
        by=BY,
        reason=_reason(formula, began),
        ends_at_fault=True,
        times=times,
    )


def _observed(net: TimedNet, formula: Bounded, atoms: BoundAtoms) -> Watched:
    """Return the net with the observer that a formula needs."""
    window, trigger = formula.window, formula.trigger
    begins = {"idle": int(trigger is not None), "begun": int(trigger is None)}
    is_late = not window.begins_at_once and not (formula.always and not is_step(formula.condition))
    armed = "armed" if is_late else "begun"
    places = {**begins, **({"early": begins["begun"], "armed": 0} if is_late else {})}
    puts = ("begun", "early") if is_late else ("begun",)
    watchers = list(_watchers(formula, armed))
    noticed: Iterable[int] = ()
    if trigger is not None and is_step(trigger):
        noticed = _fired(trigger, atoms)
    elif trigger is not None:
        watchers.append(Watcher("guess", FREE, ("idle",), puts, (GATE,)))
    return watched(net, places, watchers, noticed, ("idle",), puts)


def _watchers(formula: Bounded, armed: str) -> Iterable[Watcher]:
    """Yield what measures the window.

    ``b`` must come: it is tested from the beginning of the window. A run arms the observer before the
    first moment of the window, after all that happens before; the window is over once it can be.

    ``b`` is to hold: a look in the window shows what is there then, or the window is open for firings.
    """
    window = formula.window
    if formula.always and not is_step(formula.condition):
        yield Watcher("look", _interval(window), (GATE,), (), ("begun",))
        return
    if formula.always:
        if armed == "armed":
            opens = Interval(window.earliest, None, window.is_open_below)
            yield Watcher("arm", opens, ("early",), ("armed",), (GATE,))
        yield Watcher(
            "close",
            Interval(Fraction(0), window.latest, False, window.is_open_above),
            (GATE,),
            (),
            ("begun",),
        )
        return
    if armed == "armed":
        # Armed before the window: at its first moment all counts, also what happens in no time.
        arms = Interval(Fraction(0), window.earliest, False, not window.is_open_below)
        yield Watcher("arm", arms, ("early",), ("armed",), (GATE,))
    yield Watcher("late", Interval(window.latest, None, not window.is_open_above), (GATE,), (), ("begun",))


def _interval(window: Window) -> Interval:
    return Interval(window.earliest, window.latest, window.is_open_below, window.is_open_above)


def _fired(condition: Formula, atoms: BoundAtoms) -> list[int]:
    """Return the transitions that a condition names as fired; all of them if it may hold without these."""
    named = {t for one in atoms.conditions.values() if isinstance(one, SomeFired) for t in one.transitions}
    by_others = holding_without_firings(condition, atoms)
    return sorted(range(len(atoms.net.transitions)) if by_others else named)


def holding_without_firings(condition: Formula, atoms: BoundAtoms) -> bool:
    """Whether a condition may hold at a firing of a transition that it does not name."""
    from itertools import product

    others = [atom for atom in condition.subformulas() if isinstance(atom, Atom) and atom in atoms.conditions]
    free = [atom for atom in others if not isinstance(atoms.conditions[atom], SomeFired)]
    if len(free) > 10:
        return True
    for values in product((False, True), repeat=len(free)):
        chosen = dict(zip(free, values, strict=True))
        if combination(condition, lambda atom: np.array([chosen.get(atom, False)]), 1)[0]:  # noqa: B023
            return True
    return False


@dataclass(frozen=True)
class _View:
    """The classes of a net with its observer, and what a formula asks of them."""

    graph: TimedGraph
    observed: Watched
    formula: Bounded
    atoms: BoundAtoms

    def violation(self) -> list[int] | None:
        """Return edges that lead to a violation, the last one included; None if there is none."""
        graph, formula = self.graph, self.formula
        allowed = np.ones(len(graph.source), dtype=np.bool_)
        if formula.trigger is not None:
            begins = self._begins()
            allowed &= ~begins | self._at_edges(formula.trigger)
            if is_step(formula.trigger) and not formula.is_after_step:
                now = self._at_edges(formula.condition)
                if not formula.always and formula.window.begins_at_once:
                    allowed &= ~begins | ~now
        if not formula.always:
            return self._outlasting(allowed)
        counts_step = formula.trigger is not None and is_step(formula.trigger) and not formula.is_after_step
        if counts_step and formula.window.begins_at_once:
            at_once = self._begins() & ~self._at_edges(formula.condition)
            way = shortest_way(graph, allowed, at_once)
            if way is not None:
                return way
        if not is_step(formula.condition):
            looks = graph.label == self.observed.transition["look"]
            return shortest_way(graph, allowed, looks & ~self._at_edges(formula.condition))
        fires = self._is_of_net() & self._marked(self._armed)[graph.source]
        return shortest_way(graph, allowed, fires & ~self._at_edges(formula.condition))

    def _outlasting(self, allowed: Flags) -> list[int] | None:
        """Return a way on which the window passes without the condition."""
        graph, condition = self.graph, self.formula.condition
        armed = self._marked(self._armed)
        if is_step(condition):
            allowed &= ~(armed[graph.source] & self._is_of_net() & self._at_edges(condition))
        else:
            met = armed & self._at_classes(condition)
            if met[0]:
                return None
            allowed &= ~met[graph.source] & ~met[graph.target]
        return shortest_way(graph, allowed, graph.label == self.observed.transition["late"])

    @property
    def _armed(self) -> str:
        return "armed" if "armed" in self.observed.place else "begun"

    def _begins(self) -> Flags:
        """Return by edge whether it begins a window."""
        starts = [*self.observed.copy_of, self.observed.transition.get("guess", -2)]
        return np.isin(self.graph.label, starts)

    def _is_of_net(self) -> Flags:
        """Return by edge whether it fires a transition of the net."""
        most = len(self.observed.original.untimed.transitions)
        return ((self.graph.label >= 0) & (self.graph.label < most)) | np.isin(
            self.graph.label, list(self.observed.copy_of)
        )

    def _marked(self, place: str) -> Flags:
        marked = self.graph.markings[:, self.observed.place[place]] > 0
        return np.asarray(marked)[self.graph.marking_of]

    def _at_classes(self, condition: Formula) -> Flags:
        """Return by class whether a condition on markings holds."""
        return combination(condition, self._of_marking, self.graph.classes)

    def _of_marking(self, atom: Atom) -> Flags:
        graph, asked = self.graph, self.atoms.conditions[atom]
        return holds(MarkingMatrix(self.observed.original.untimed, graph.markings), asked)[graph.marking_of]

    def _at_edges(self, condition: Formula) -> Flags:
        """Return by edge whether a condition holds where it begins, with what it fires."""
        graph = self.graph

        def of_edge(atom: Atom) -> Flags:
            asked = self.atoms.conditions[atom]
            if isinstance(asked, SomeFired):
                copies = [copy for copy, t in self.observed.copy_of.items() if t in asked.transitions]
                return np.isin(graph.label, [*asked.transitions, *copies])
            return self._of_marking(atom)[graph.source]

        return combination(condition, of_edge, len(graph.source))


def _times(observed: Watched, trace: list[int]) -> tuple[tuple[FiredAt, ...], Fraction]:
    """Return when the firings of the net happen in a violation, and when the window begins."""
    found = schedule(observed.net, trace)
    began = Fraction(0)
    times: list[FiredAt] = []
    for one in found:
        if one.transition in observed.copy_of or one.transition == observed.transition.get("guess"):
            began = one.at
        if observed.in_original(one.transition) is not None:
            latest = None if one.latest is None else float(one.latest)
            times.append((float(one.at), float(one.earliest), latest))
    return tuple(times), began


def _reason(formula: Bounded, began: Fraction) -> str:
    """Return what the schedule shows."""
    window, text = formula.window, str(formula.condition)
    start = "" if formula.trigger is None else f", counted from {float(began):g}"
    if formula.always:
        return f"{text} does not hold throughout {window}{start}"
    return f"{text} does not come in {window}{start}"
