"""The order of rules: each declares a phase and its variants; lookups decide the order within a phase."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import IntEnum, auto
from heapq import heapify, heappop, heappush
from typing import ClassVar, Literal, TypeAlias

from dineros.transformations.language import Rule, RuleError
from dineros.transformations.language.engine import makers

SignalVariant: TypeAlias = Literal["none", "fully-enabled", "input-enabled", "io-enabled"]
MiddlewareVariant: TypeAlias = Literal["ros1", "ros2"]
OverflowVariant: TypeAlias = Literal["weighted", "inhibitor"]


class Phase(IntEnum):
    """A part of flattening. Phases run in this order; within a phase, lookups decide."""

    instances = auto()
    """Copies of server pages: one channel after the other, before all other rules."""
    services = auto()
    """Service calls, request histories, time-outs."""
    goals = auto()
    """Goals of actions and cancel requests under way to the server."""
    outcomes = auto()
    """The server's handling of a goal, and the messages that its client receives."""
    publications = auto()
    """Histories of publishers."""
    deliveries = auto()
    """Histories of subscribers under ROS 1, and best-effort links."""
    drops = auto()
    """Drops of full queues; all queues must exist."""
    signals = auto()
    """Signals and clauses. Only places of the model count: earlier rules do not affect clauses."""
    beginnings = auto()
    """Threads of executors, and the beginning of callbacks."""
    endings = auto()
    """The end of callbacks."""
    exclusion = auto()
    """Locks of callback groups, and actions between callbacks."""
    lifecycle = auto()
    """States of managed nodes, and restrictions in each state."""
    appearing = auto()
    """Messages to and from a node that is not or no longer configured."""
    disappearing = auto()
    """Writers that are replaced, and servers that are absent."""
    forgetting = auto()
    """Lost requests without an effect on their clients: removes elements of earlier rules."""
    timing = auto()
    """Durations of callbacks and latencies of messages, if time is modelled."""
    intervals = auto()
    """Firing intervals of transitions of the model, after all queries that they affect."""
    bounds = auto()
    """Capacities of places. From here on, rules consider all arcs, including those of additional rules."""
    rooms = auto()
    """Capacities at actions."""
    wiring = auto()
    """Arcs for all capacities."""


class StandardRule(Rule, is_base=True):
    """Base class of the rules of flattening.

    Class keywords
    --------------
    phase : Phase
        When the rule runs.
    middleware : {"ros1", "ros2"}, optional
        Only middleware under which it runs.
    signals : tuple of SignalVariant, optional
        Only variants of signals with which it runs.
    overflow : {"weighted", "inhibitor"}, optional
        Only variant of overflow with which it runs.
    times : bool, optional
        Whether it runs only if time is modelled, or only if it is not.
    """

    phase: ClassVar[Phase]
    middleware: ClassVar[MiddlewareVariant | None] = None
    signals: ClassVar[tuple[SignalVariant, ...]] = ()
    overflow: ClassVar[OverflowVariant | None] = None
    times: ClassVar[bool | None] = None

    def __init_subclass__(
        cls,
        *,
        phase: Phase,
        middleware: MiddlewareVariant | None = None,
        signals: tuple[SignalVariant, ...] = (),
        overflow: OverflowVariant | None = None,
        times: bool | None = None,
    ) -> None:
        super().__init_subclass__()
        cls.phase, cls.middleware, cls.signals, cls.overflow = phase, middleware, signals, overflow
        cls.times = times

    @classmethod
    def runs_with(
        cls,
        signals: SignalVariant,
        overflow: OverflowVariant,
        middleware: MiddlewareVariant,
        times: bool = False,
    ) -> bool:
        """Return whether the rule runs in a variant."""
        return (
            cls.middleware in (None, middleware)
            and (not cls.signals or signals in cls.signals)
            and cls.overflow in (None, overflow)
            and cls.times in (None, times)
        )


def in_order(rules: Sequence[type[StandardRule]]) -> list[type[StandardRule]]:
    """Sort rules by phase, and within each phase by their lookups.

    A rule comes after all rules that make elements which it looks up, and otherwise as early as the given
    order allows: Kahn's algorithm (Communications of the ACM 5, 1962) with the position as priority.

    Raises
    ------
    RuleError
        A rule looks up elements of a later phase, or lookups within a phase are cyclic.
    """
    ordered: list[type[StandardRule]] = []
    needed = {rule: makers(rule, rules) for rule in rules}
    for rule, found in needed.items():
        for maker in found:
            if maker.phase > rule.phase:
                raise RuleError(
                    f"{rule.__name__} looks up what {maker.__name__} makes, which runs later",
                    location=rule.lhs[0].location,
                    hint=f"phase {maker.phase.name} comes after {rule.phase.name}",
                )
    for phase in Phase:
        ordered += _by_lookups([rule for rule in rules if rule.phase is phase], needed)
    return ordered


def _by_lookups(
    rules: Sequence[type[StandardRule]],
    needed: dict[type[StandardRule], set[type[StandardRule]]],
) -> Iterable[type[StandardRule]]:
    """Yield the rules of one phase, each after the rules that it needs."""
    place = {rule: number for number, rule in enumerate(rules)}
    missing = {rule: {maker for maker in needed[rule] if maker in place} for rule in rules}
    ready = [place[rule] for rule in rules if not missing[rule]]
    heapify(ready)
    while ready:
        done = rules[heappop(ready)]
        del missing[done]
        yield done
        for rule, makers_left in missing.items():
            if done in makers_left:
                makers_left.remove(done)
                if not makers_left:
                    heappush(ready, place[rule])
    if missing:
        names = ", ".join(rule.__name__ for rule in missing)
        raise RuleError(f"rules look each other up in a circle: {names}")
