"""What happens within a time, proved by an observer that stops the net once it has happened.

The observer of `bounded_response` leaves out what follows a condition that is met, so its classes have to be
compared by equality. Here a transition of the observer stops the net at once if the condition is met in the
window. So all classes can be compared by inclusion, of which there are far fewer: the formula holds if the
observer never measures that the window is over.

Other transitions may fire in the same moment before the net is stopped, also some that end the condition. So
this proves formulas, and violates none.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, SomeFired
from dineros.analysis.logic.language.bounded import Bounded, is_step
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.syntax import And, Atom, Formula, Or
from dineros.analysis.nets.compiled import Transition, unused
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.analysis.timed.search import ClassSearch

BY = "state classes compared by inclusion, and an observer"
LOOK = 1.5
"""Classes between two looks for a measured window, as a factor."""


def always_within(net: TimedNet, formula: Bounded, names: Names | None, budget: Budget) -> Outcome | None:
    """Prove a formula ``G (a -> F[<=d] b)``; None if that is not possible.

    ``b`` is one of some firings, or joined by ``|`` and ``&`` from comparisons of places.
    """
    window = formula.window
    if net.has_priorities or formula.always or not window.begins_at_once or window.latest is None:
        return None
    atoms = BoundAtoms(net.untimed, formula, names or NetNames(net.untimed))
    trigger = formula.trigger
    if trigger is None or not isinstance(trigger, Atom) or not is_step(trigger):
        return None
    begins = atoms.conditions[trigger]
    if not isinstance(begins, SomeFired):
        return None
    try:
        tests = list(_alternatives(formula.condition, atoms))
    except ValueError:
        return None
    if any(each.fired for each in tests) and not all(each.fired for each in tests):
        return None  # places are compared at each firing then, and not at each moment
    observed = _Observed(net)
    late = Interval(window.latest, None, not window.is_open_above)
    found = observed.net(begins.transitions, tests, late, formula.is_after_step)
    search = ClassSearch(found, "M", budget)
    late_number = found.untimed.transitions.index(observed.late)
    next_look = 1_000

    def is_late() -> bool:
        nonlocal next_look
        if search.classes < next_look:
            return False
        next_look = int(LOOK * search.classes)
        return search.first_edge([late_number]) is not None

    search.run(is_late)
    if not search.is_done or search.first_edge([late_number]) is not None:
        return None
    return Outcome("holds", states=search.classes, seconds=budget.spent, by=BY)


class _Test:
    """One way in which a condition is met: a firing, or places with at least or less than some tokens."""

    def __init__(
        self,
        fired: frozenset[int] = frozenset(),
        least: Mapping[int, int] | None = None,
        below: Mapping[int, int] | None = None,
    ) -> None:
        self.fired, self.least, self.below = fired, dict(least or {}), dict(below or {})

    def joined(self, other: _Test) -> _Test:
        """Return the test that both are met."""
        if self.fired or other.fired:
            raise ValueError
        least = {p: max(self.least.get(p, 0), other.least.get(p, 0)) for p in {*self.least, *other.least}}
        below = {
            p: min(each.below[p] for each in (self, other) if p in each.below)
            for p in {*self.below, *other.below}
        }
        return _Test(least=least, below=below)


def _alternatives(condition: Formula, atoms: BoundAtoms) -> Iterator[_Test]:
    """Yield tests of which one is met if a condition is, as far as arcs can test it.

    Raises
    ------
    ValueError
        They cannot.
    """
    if isinstance(condition, Or):
        for each in condition.operands:
            yield from _alternatives(each, atoms)
        return
    if isinstance(condition, And):
        met = [_Test()]
        for each in condition.operands:
            more = list(_alternatives(each, atoms))
            met = [one.joined(other) for one in met for other in more]
        yield from met
        return
    asked = atoms.conditions[condition] if isinstance(condition, Atom) else None
    if isinstance(asked, SomeFired):
        yield _Test(fired=asked.transitions)
        return
    if not isinstance(asked, Linear) or any(factor != 1 for factor in asked.factors.values()):
        raise ValueError
    bound, operator = asked.bound, asked.operator
    if operator in ("<", "<=", "==") and bound + (operator != "<") == 1:
        yield _Test(below=dict.fromkeys(asked.factors, 1))
    elif operator in (">", ">=") and len(asked.factors) == 1:
        yield _Test(least=dict.fromkeys(asked.factors, bound + (operator == ">")))
    elif operator in (">", ">=") and bound + (operator == ">") == 1:
        for place in asked.factors:
            yield _Test(least={place: 1})
    else:
        raise ValueError


class _Observed:
    """A net with such an observer.

    `net`: the net.
    """

    def __init__(self, net: TimedNet) -> None:
        self._plain = net
        self.late = unused("observer late", net.untimed.transitions)

    def net(
        self, begins: frozenset[int], tests: list[_Test], late: Interval, is_after_step: bool
    ) -> TimedNet:
        """Return it: a firing of `begins` may begin the window, and tests stop all."""
        plain = self._plain
        names = plain.untimed.places
        gate, idle, begun, met, room = (
            unused(f"observer {name}", names) for name in ("gate", "idle", "begun", "met", "room")
        )
        tokens, rows = plain.by_names()
        tokens |= {gate: 1, idle: 1, begun: 0, met: 0, room: 1}
        intervals = dict(zip(plain.untimed.transitions, plain.intervals, strict=True))
        fired = frozenset(t for test in tests for t in test.fired)
        made: list[Transition] = []
        copies: list[Transition] = []
        for t, row in enumerate(rows):
            own = row._replace(reads={**row.reads, gate: 1})
            plainly = own
            if t in fired:
                own = own._replace(inputs={**own.inputs, room: 1}, outputs={**own.outputs, met: 1})
            if t in begins:
                lock = unused(f"lock of {row.name}", tokens)
                tokens[lock] = 1
                own, plainly = (
                    each._replace(inputs={**each.inputs, lock: 1}, outputs={**each.outputs, lock: 1})
                    for each in (own, plainly)
                )
                name = unused(f"{row.name} noticed", intervals)
                intervals[name] = intervals[row.name]
                if t not in fired or is_after_step:
                    copies.append(
                        plainly._replace(
                            name=name,
                            inputs={**plainly.inputs, idle: 1},
                            outputs={**plainly.outputs, begun: 1},
                        )
                    )
            made.append(own)
        at_once = Interval(latest=late.earliest * 0)
        watchers = [Transition(self.late, {gate: 1}, {}, {}, {begun: 1})]
        intervals[self.late] = late
        for number, test in enumerate(tests):
            takes = {gate: 1, **({met: 1} if test.fired else {})}
            name = unused(f"observer stop {number}", intervals)
            intervals[name] = at_once
            reads = {begun: 1, **{names[p]: w for p, w in test.least.items() if w}}
            watchers.append(Transition(name, takes, {}, {names[p]: w for p, w in test.below.items()}, reads))
        if fired:
            name = unused("observer forget", intervals)
            intervals[name] = at_once
            watchers.append(Transition(name, {met: 1}, {room: 1}, {}, {idle: 1}))
        return TimedNet.build(tokens, [*made, *copies, *watchers], intervals)
