"""Time as a counter: a plain net with the markings of a time Petri net whose intervals are closed.

With closed intervals, whole units of time are enough: every marking that can be reached at all can be reached
with firings at multiples of the unit (Henzinger, Manna, Pnueli, ICALP 1992; Popova, 1991). So time becomes
places. Each transition with an interval has a counter that holds 0 while the transition is disabled. One
token says what happens: the net may fire while it lies on `now`; it walks through the counters when time
passes, or when a firing may have disabled others.

Worked example. ``t`` takes from ``p`` within [1, 2]. Its counter has the values 0, 1, 2. From ``now`` a
unit of time passes: ``t`` is enabled, so its counter goes up to 1, and in a second round to 2. A third round
gets stuck at ``t``, which is enabled and has reached its latest bound: it never comes back to ``now``. ``t``
fires at 1 or at 2, by one transition for each value, which also sets the counter back.

A transition with priority over others holds them back as soon as it is enabled if its earliest bound is 0.
Then a firing first walks past all that stand above its transition, and gets stuck at one that is enabled.
With a later earliest bound, whole units are not enough: a firing that must come strictly before one moment
and strictly after another one may have no whole number between them. Such nets are refused.

This engine shares nothing with state classes but the net, so each can confirm the other.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from dineros.analysis.nets.compiled import CompiledNet, Transition, unused
from dineros.analysis.timed.nets import TimedNet
from dineros.metamodel.errors import DinerosError

MOST_TRANSITIONS = 5_000
"""A net with more is not made: the bounds are too far apart for counters."""

Arcs = dict[str, int]


@dataclass(frozen=True)
class IntegerNet:
    """A plain net in which time is counted.

    Attributes
    ----------
    net : CompiledNet
        The places of the timed net under their own names, counters and what continues.
    now : str
        Marked between two rounds; then the other places hold a marking of the timed net.
    end : str
        Marked when all counters are forgotten: each marking with it is one of the timed net.
    firing : tuple of tuples of str
        By transition of the timed net: the transitions that begin its firing.
    """

    net: CompiledNet
    now: str
    end: str
    firing: tuple[tuple[str, ...], ...]


def integer_net(net: TimedNet) -> IntegerNet:
    """Make a plain net of a time Petri net.

    Raises
    ------
    DinerosError
        An interval is open, a transition with priority over others has an earliest bound above 0, or the
        counters are too long.
    """
    for name, interval in zip(net.untimed.transitions, net.intervals, strict=True):
        if interval.is_open_below or interval.is_open_above:
            raise DinerosError(
                f"the interval {interval} of transition {name} is open, so time cannot be counted in whole "
                "units",
                element=name,
                hint="state classes (--classes) support open intervals",
            )
    for above in net.above:
        for high in above:
            if net.intervals[high].earliest:
                name, begins = net.untimed.transitions[high], net.intervals[high].earliest
                raise DinerosError(
                    f"transition {name} has priority over others only from {begins} on, "
                    "so time cannot be counted in whole units",
                    element=name,
                    hint="state classes support such priorities: --classes S",
                )
    return _Maker(net).made()


@dataclass(frozen=True)
class _TransitionCounter:
    """The counter of a transition: from 0 to `top`, as two places whose tokens add up to that."""

    transition: int
    earliest: int
    top: int
    is_bounded: bool
    count: str
    rest: str

    def at(self, value: int) -> Arcs:
        """Return the tokens of a value."""
        return {place: n for place, n in ((self.count, value), (self.rest, self.top - value)) if n}


@dataclass(frozen=True)
class _Case:
    """One way in which a step can go: what it takes, puts and reads, and what must not be there."""

    takes: Arcs = field(default_factory=dict)
    puts: Arcs = field(default_factory=dict)
    reads: Arcs = field(default_factory=dict)
    inhibitors: Arcs = field(default_factory=dict)


class _Maker:
    """Adds places and transitions to a plain net."""

    def __init__(self, timed: TimedNet) -> None:
        untimed = timed.untimed
        self._timed = timed
        self._places = dict(zip(untimed.places, untimed.initial.tolist(), strict=True))
        self._transitions: list[Transition] = []
        self._now = self._place("now", 1)
        lower, upper = timed.scaled()
        self._clocks: dict[int, _TransitionCounter] = {}
        for t, interval in enumerate(timed.intervals):
            if interval.is_free:
                continue
            name, earliest = untimed.transitions[t], (1 - int(lower[t])) // 2
            top = earliest if interval.latest is None else int(upper[t]) // 2
            self._clocks[t] = _TransitionCounter(
                t,
                earliest,
                top,
                interval.latest is not None,
                self._place(f"clock of {name}"),
                self._place(f"rest of {name}", top),
            )
            if sum(clock.top for clock in self._clocks.values()) > MOST_TRANSITIONS:
                raise DinerosError(
                    f"the bounds have too many units of {timed.unit} to be counted",
                    hint="state classes (--classes) do not count units",
                )

    def made(self) -> IntegerNet:
        transitions = range(len(self._timed.untimed.transitions))
        firing = tuple(self._fire(transition) for transition in transitions)
        # Those that let no time pass at all come first: a round that gets stuck does so early.
        in_turn = sorted(self._clocks.values(), key=lambda clock: clock.top)
        self._steps("time", self._now, self._now, [list(self._ticks(clock)) for clock in in_turn])
        end = self._place("end")
        forgets = [[self._reset(clock, v) for v in range(clock.top + 1)] for clock in in_turn]
        self._steps("end", self._now, end, forgets)
        return IntegerNet(CompiledNet.build(self._places, self._transitions), self._now, end, firing)

    def _fire(self, transition: int) -> tuple[str, ...]:
        """Add a transition for a firing, which also resets the counters of the transitions that it disables.

        Returns
        -------
        tuple of str
            The transitions that take the tokens: once one has fired, nothing gets stuck.
        """
        timed, net = self._timed, self._timed.untimed
        take, put = dict(timed.take.row(transition)), dict(timed.put.row(transition))
        at_once = [
            clock
            for t, clock in self._clocks.items()
            if t != transition and any(place in take for place, _ in timed.untimed.pre.row(t))
        ]
        after = [
            clock
            for t, clock in self._clocks.items()
            if t != transition and any(place in put for place, _ in net.inhibitor.row(t))
        ]
        conditions = self._enabled(transition)
        taken = self._named(take)
        reads = {
            place: weight - taken.get(place, 0)
            for place, weight in conditions.reads.items()
            if weight > taken.get(place, 0)
        }
        own = self._clocks.get(transition)
        resets = [_Case()] if own is None else [self._reset(own, v) for v in range(own.earliest, own.top + 1)]
        first = [
            _Case({**taken, **reset.takes}, dict(reset.puts), {**reads, **reset.reads}, conditions.inhibitors)
            for reset in resets
        ]
        puts = [[_Case(puts=self._named(put))]] if put else []
        higher = [list(self._disabled(t)) for t in timed.above[transition]]
        steps = [
            *higher,
            first,
            *([*self._kept(clock), *self._lost(clock)] for clock in at_once),
            *puts,
            *([*self._kept(clock), *self._lost(clock)] for clock in after),
        ]
        if not at_once:
            # Nothing looks at the marking between taking and putting.
            steps[len(higher) : len(higher) + 1 + len(puts)] = [
                [_Case(c.takes, _sum(c.puts, self._named(put)), c.reads, c.inhibitors) for c in first]
            ]
        begins = len(self._transitions) + sum(map(len, higher))
        self._steps(net.transitions[transition], self._now, self._now, steps)
        return tuple(each.name for each in self._transitions[begins : begins + len(first)])

    def _ticks(self, clock: _TransitionCounter) -> Iterator[_Case]:
        """What a unit of time does to a counter; nothing if the counter would exceed the latest bound."""
        conditions = self._enabled(clock.transition)
        if clock.top:
            yield _Case({clock.rest: 1}, {clock.count: 1}, conditions.reads, conditions.inhibitors)
        if not clock.is_bounded:
            yield _Case(reads=_sum(conditions.reads, clock.at(clock.top)), inhibitors=conditions.inhibitors)
        yield from self._disabled(clock.transition)

    def _kept(self, clock: _TransitionCounter) -> Iterator[_Case]:
        yield self._enabled(clock.transition)

    def _lost(self, clock: _TransitionCounter) -> Iterator[_Case]:
        for reason in self._disabled(clock.transition):
            for value in range(clock.top + 1):
                reset = self._reset(clock, value)
                yield _Case(reset.takes, reset.puts, _sum(reason.reads, reset.reads), reason.inhibitors)

    def _reset(self, clock: _TransitionCounter, value: int) -> _Case:
        """Set a counter back from a value."""
        if value == 0:
            return _Case(reads=clock.at(0))
        others = {clock.rest: clock.top - value} if value < clock.top else {}
        return _Case({clock.count: value}, {clock.rest: value}, others)

    def _enabled(self, transition: int) -> _Case:
        """Read that a transition is enabled."""
        timed = self._timed
        return _Case(
            reads=self._named(dict(timed.untimed.pre.row(transition))),
            inhibitors=self._named(dict(timed.untimed.inhibitor.row(transition))),
        )

    def _disabled(self, transition: int) -> Iterator[_Case]:
        """Read that a transition is disabled, in each way in which it can be."""
        for place, weight in self._timed.untimed.pre.row(transition):
            yield _Case(inhibitors=self._named({place: weight}))
        for place, weight in self._timed.untimed.inhibitor.row(transition):
            yield _Case(reads=self._named({place: weight}))

    def _steps(self, name: str, source: str, target: str, steps: list[list[_Case]]) -> None:
        """Add steps, one after the other; each goes in any of its ways, or gets stuck without one."""
        at = source
        for number, cases in enumerate(steps, 1):
            goes_to = target if number == len(steps) else self._place(f"{name} {number}")
            for way, case in enumerate(cases, 1):
                self._transitions.append(
                    Transition(
                        f"{len(self._transitions)} {name} {number} {way}",
                        _sum(case.takes, {at: 1}),
                        _sum(case.puts, {goes_to: 1}),
                        case.inhibitors,
                        case.reads,
                    )
                )
            at = goes_to
        if not steps:
            self._transitions.append(Transition(f"{len(self._transitions)} {name}", {source: 1}, {target: 1}))
        if len(self._transitions) > MOST_TRANSITIONS:
            raise DinerosError(
                f"the bounds are too many units of {self._timed.unit} long to be counted",
                hint="state classes (--classes) do not count units",
            )

    def _place(self, name: str, tokens: int = 0) -> str:
        made = unused(name, self._places)
        self._places[made] = tokens
        return made

    def _named(self, row: Mapping[int, int]) -> Arcs:
        names = self._timed.untimed.places
        return {names[place]: weight for place, weight in row.items()}


def _sum(one: Arcs, other: Arcs) -> Arcs:
    return {place: one.get(place, 0) + other.get(place, 0) for place in (*one, *other)}
