"""When rules run: each declares a phase and its variants, and the order follows from what it looks up."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from enum import IntEnum, auto
from heapq import heapify, heappop, heappush
from typing import ClassVar, Literal, TypeAlias

from dineros.transformations.language.engine import makers
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.rule import Rule

SignalVariant: TypeAlias = Literal["none", "fully-enabled", "input-enabled", "io-enabled"]
MiddlewareVariant: TypeAlias = Literal["ros1", "ros2"]
OverflowVariant: TypeAlias = Literal["weighted", "inhibitor"]


class Phase(IntEnum):
    """A part of flattening. Phases run in this order; within one, lookups decide."""

    instances = auto()
    """Copies of server pages: one channel after the other, before all other rules."""
    services = auto()
    """Calls of services, request histories, time-outs."""
    goals = auto()
    """Goals of actions, and requests to cancel them, on their way to the server."""
    outcomes = auto()
    """What the server of an action does with a goal, and what the client receives."""
    publications = auto()
    """Histories of publishers."""
    deliveries = auto()
    """Histories of subscribers under ROS 1, and best-effort links."""
    drops = auto()
    """When a full queue drops a message: needs all queues."""
    signals = auto()
    """Signals and clauses. Their places are those of the model: rules above add none to a clause."""
    beginnings = auto()
    """Threads of executors, and how callbacks begin."""
    endings = auto()
    """How callbacks end."""
    exclusion = auto()
    """Locks of callback groups, and what happens between callbacks."""
    lifecycle = auto()
    """States of managed nodes, and what each state allows."""
    appearing = auto()
    """Messages to and from a node that is not there yet or no longer."""
    disappearing = auto()
    """Writers that are replaced, and servers that are absent."""
    forgetting = auto()
    """Lost requests that no client counts: removes what rules above made."""
    timing = auto()
    """How long callbacks work and messages are on their way, where times count."""
    intervals = auto()
    """Firing intervals of transitions of the model, when all is asked that they change."""
    bounds = auto()
    """Capacities of places. From here on, rules look at all arcs, also those of additional rules."""
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
        The only middleware under which it runs.
    signals : tuple of SignalVariant, optional
        The only variants of signals with which it runs.
    overflow : {"weighted", "inhibitor"}, optional
        The only variant of overflow with which it runs.
    times : bool, optional
        Whether it runs only where times count, or only where they do not.
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
        """Tell whether the rule runs in a variant."""
        return (
            cls.middleware in (None, middleware)
            and (not cls.signals or signals in cls.signals)
            and cls.overflow in (None, overflow)
            and cls.times in (None, times)
        )


def in_order(rules: Sequence[type[StandardRule]]) -> list[type[StandardRule]]:
    """Sort rules by phase, and in each phase by what they look up.

    A rule comes after all rules that make what it looks up, and otherwise as early as the order given allows:
    Kahn's algorithm (Communications of the ACM 5, 1962) with the position as priority.

    Raises
    ------
    RuleError
        A rule looks up what a later phase makes, or rules of one phase look each other up in a circle.
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
    """Yield the rules of one phase, each after those that it needs."""
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
