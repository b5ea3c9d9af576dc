"""Compiled time Petri nets: a place/transition net with exact firing intervals and priorities.

Read arcs are kept apart from loops: a read arc takes nothing, so a firing does not disturb the clocks of
transitions that only read the same place, while a loop does.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import gcd, lcm

import numpy as np

from dineros.analysis.nets.compiled import ArcTable, CompiledNet, Int64Array, Transition
from dineros.analysis.nets.models import initial_and_arcs
from dineros.metamodel import pn
from dineros.metamodel.elements import transitions
from dineros.metamodel.errors import DinerosError

LARGEST_BOUND = 1 << 40
"""Largest bound in units of time: sums of bounds must fit into 64 bits."""


@dataclass(frozen=True)
class Interval:
    """A firing interval.

    Attributes
    ----------
    earliest : Fraction
        In units of the model, 0 or more.
    latest : Fraction or None
        None: no latest bound.
    is_open_below, is_open_above : bool
        Whether the bound itself is left out.
    """

    earliest: Fraction = Fraction(0)
    latest: Fraction | None = None
    is_open_below: bool = False
    is_open_above: bool = False

    @classmethod
    def of(cls, given: pn.TimeInterval | None) -> Interval:
        """Return the interval of a model; its bounds are exact by their decimal text.

        Raises
        ------
        DinerosError
            A bound is not a finite number, the earliest is negative, or the interval is empty.
        """
        if given is None:
            return cls()
        earliest, latest = exact(given.earliest), None if given.latest is None else exact(given.latest)
        made = cls(earliest, latest, bool(given.earliestExcluded), bool(given.latestExcluded))
        if earliest < 0:
            raise DinerosError(f"the interval {made} begins before 0")
        if latest is not None and (
            latest < earliest or (latest == earliest and (made.is_open_below or made.is_open_above))
        ):
            raise DinerosError(f"the interval {made} is empty")
        return made

    @property
    def is_free(self) -> bool:
        """Whether it restricts nothing: ``[0, inf)``."""
        return not self.earliest and self.latest is None and not self.is_open_below

    def __str__(self) -> str:
        left = "]" if self.is_open_below else "["
        right = "[" if self.is_open_above or self.latest is None else "]"
        return f"{left}{self.earliest},{'w' if self.latest is None else self.latest}{right}"


def exact(number: float) -> Fraction:
    """Return a number by its decimal text: 0.1 is one tenth.

    Raises
    ------
    DinerosError
        It is infinite or not a number.
    """
    try:
        return Fraction(repr(number))
    except ValueError:
        raise DinerosError(f"a bound of an interval must be a finite number, not {number}") from None


@dataclass(frozen=True)
class TimedNet:
    """A time Petri net.

    Attributes
    ----------
    untimed : CompiledNet
        The same net without its times: names, initial marking, inhibitor arcs, and a read arc as a pair of
        arcs.
    take, put : ArcTable
        By transition: tokens taken, and tokens put. Those that must be there are ``untimed.pre``.
    intervals : tuple of Interval
        By transition.
    above : tuple of tuples of int
        By transition: those with priority over it.
    time_passes : bool
        Whether infinitely many firings in finite time are no run, as of a system in the real world.
    """

    untimed: CompiledNet
    take: ArcTable
    put: ArcTable
    intervals: tuple[Interval, ...]
    above: tuple[tuple[int, ...], ...] = field(default=())
    time_passes: bool = False

    @classmethod
    def build(
        cls,
        places: Mapping[str, int],
        transitions: Sequence[Transition],
        intervals: Mapping[str, Interval],
        priorities: Sequence[tuple[str, str]] = (),
    ) -> TimedNet:
        """Compile a net that is given by names.

        Parameters
        ----------
        intervals
            By transition; one that is left out is ``[0, inf)``.
        priorities
            Pairs (higher, lower). The relation is transitive.

        Raises
        ------
        NetError
            See `CompiledNet.build`.
        """
        untimed = CompiledNet.build(places, transitions)
        index = {name: position for position, name in enumerate(places)}
        take, put = (
            ArcTable.from_rows([{index[p]: w for p, w in row.items()} for row in rows])
            for rows in ([one.inputs for one in transitions], [one.outputs for one in transitions])
        )
        names = {name: t for t, name in enumerate(untimed.transitions)}
        above = _closed([(names[high], names[low]) for high, low in priorities], len(names))
        given = tuple(intervals.get(name, Interval()) for name in untimed.transitions)
        return cls(untimed, take, put, given, above)

    def by_names(self) -> tuple[dict[str, int], list[Transition]]:
        """Return the places with their tokens, and the transitions, in the form of `build`."""
        names, (tokens, rows) = self.untimed.places, self.untimed.by_names()
        for t, row in enumerate(rows):
            take, put = ({names[p]: w for p, w in table.row(t)} for table in (self.take, self.put))
            reads = {p: w - take.get(p, 0) for p, w in row.inputs.items() if w > take.get(p, 0)}
            rows[t] = row._replace(inputs=take, outputs=put, reads=reads)
        return tokens, rows

    @property
    def has_times(self) -> bool:
        """Whether any interval restricts anything."""
        return any(not interval.is_free for interval in self.intervals)

    @property
    def is_unforced(self) -> bool:
        """Whether nothing ever has to fire: no interval has a latest bound, and there are no priorities.

        Then the net can do with time what it can do without: a run waits before each firing until the
        earliest bound of what fires has passed, and waiting forbids nothing.
        """
        return not self.has_priorities and all(interval.latest is None for interval in self.intervals)

    @property
    def has_priorities(self) -> bool:
        """Whether any transition has priority over another."""
        return any(self.above)

    @cached_property
    def unit(self) -> Fraction:
        """The largest length of time of which every bound is a multiple; 1 if there is no bound above 0."""
        bounds = [b for i in self.intervals for b in (i.earliest, i.latest) if b]
        if not bounds:
            return Fraction(1)
        whole = lcm(*(bound.denominator for bound in bounds))
        return Fraction(gcd(*(int(bound * whole) for bound in bounds)), whole)

    def scaled(self) -> tuple[Int64Array, Int64Array]:
        """Return the bounds in `unit`, as kernels compare them.

        Returns
        -------
        lower, upper : int64 arrays, shape (transitions,)
            Of the difference bounds ``-t <= -earliest`` and ``t <= latest``: twice the number, plus 1 if the
            bound belongs to the interval; `UNBOUNDED` without a latest bound.

        Raises
        ------
        DinerosError
            A bound is too large to be counted in the unit.
        """
        lower, upper = [], []
        for name, interval in zip(self.untimed.transitions, self.intervals, strict=True):
            low = int(interval.earliest / self.unit)
            high = 0 if interval.latest is None else int(interval.latest / self.unit)
            if max(low, high) > LARGEST_BOUND:
                raise DinerosError(
                    f"the interval {interval} of transition {name} is too long in units of {self.unit}",
                    hint="bounds whose ratio is smaller can be counted",
                )
            lower.append(-2 * low + (not interval.is_open_below))
            upper.append(UNBOUNDED if interval.latest is None else 2 * high + (not interval.is_open_above))
        return np.array(lower, dtype=np.int64), np.array(upper, dtype=np.int64)


UNBOUNDED = 1 << 60
"""The bound of a difference that has none."""


def compile_timed_net(net: pn.Net) -> TimedNet:
    """Compile a plain net with its firing intervals and priorities; names are ids.

    Raises
    ------
    DinerosError
        An interval is empty or too long to be counted, an arc joins two nodes of a kind, or a place has a
        capacity that no arc obeys.
    """
    initial, named = initial_and_arcs(net)
    intervals = {}
    for transition in transitions(net):
        try:
            intervals[transition.id] = Interval.of(transition.interval)
        except DinerosError as error:
            raise DinerosError(f"transition {transition.id}: {error}", element=transition.id) from None
    made = TimedNet.build(
        initial,
        named,
        intervals,
        [(high.id, low.id) for high in transitions(net) for low in high.overrides],
    )
    made.scaled()  # a bound that cannot be counted is refused before anything is asked
    return made


def _closed(pairs: Sequence[tuple[int, int]], size: int) -> tuple[tuple[int, ...], ...]:
    """Return the transitions with priority over each transition, directly or through others."""
    directly: list[set[int]] = [set() for _ in range(size)]
    for high, low in pairs:
        directly[low].add(high)
    closed = []
    for low in range(size):
        found: set[int] = set()
        todo = list(directly[low])
        while todo:
            high = todo.pop()
            if high not in found:
                found.add(high)
                todo.extend(directly[high])
        closed.append(tuple(sorted(found)))
    return tuple(closed)
