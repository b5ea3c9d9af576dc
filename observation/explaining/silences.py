"""Finds topics that fall silent before a recording ends, although the model must continue.

A model that explains a recording may stop or continue: no message is overdue, because times are ignored here.
But if a topic was regular, received nothing for a long time while others continued, and the model cannot stay
silent, then the recorded system has stopped although the model must continue.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

from dineros.analysis.symbolic.saturation import DiagramMemoryError
from dineros.analysis.symbolic.vector_sets import Scope
from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.following import FULL, Follower, State
from dineros.observation.explaining.marking_sets import NOTHING, MarkingSets, SetsFullError

LEAST_MESSAGES = 6
"""Messages before a topic counts as regular."""
UNEVEN = 4.0
"""Largest ratio of the longest gap to the mean gap of a regular topic."""
LONG = 5.0
"""Least ratio of the silence of a topic to its longest gap."""
LEAST_SECONDS = 1.0
"""Least seconds of silence."""


@dataclass(frozen=True)
class Silence:
    """A topic without further messages."""

    topic: str
    """Full name, or name of an event."""
    seconds: float
    """From its last message to the end of the recording."""
    every: float
    """Mean seconds between its messages before."""

    def __str__(self) -> str:
        return (
            f"nothing on {self.topic} for {self.seconds:.3g} s; until then every {self.every:.3g} s; "
            "the model must continue"
        )


@dataclass
class Rhythm:
    """Arrival times of the messages of a topic, in nanoseconds."""

    first: int
    last: int
    count: int = 1
    longest: int = 0

    def add(self, time: int) -> None:
        """Process the next message."""
        self.longest = max(self.longest, time - self.last)
        self.last = time
        self.count += 1

    def silence(self, topic: str, end: int) -> Silence | None:
        """Return the silence of a topic at the end, if it was regular before and the silence is long."""
        if self.count < LEAST_MESSAGES:
            return None
        every, silent = (self.last - self.first) / (self.count - 1), end - self.last
        is_regular = self.longest <= UNEVEN * every
        if not is_regular or silent < max(LONG * self.longest, LEAST_SECONDS * 1e9):
            return None
        return Silence(topic, silent / 1e9, every / 1e9)


def unexpected(follower: Follower, state: State, silent: Collection[Silence]) -> tuple[Silence, ...]:
    """Return the silences that the model does not allow.

    A topic has to continue if, for all choices of the model's own transitions, its next message eventually
    becomes possible and stays possible until it comes. All other transitions are fair: steps that are enabled
    repeatedly, such as that an executor takes a callback, do happen. Only topics that are not silent
    themselves help.

    Parameters
    ----------
    follower : Follower
        The model.
    state : State
        The state at the end of the recording.
    silent : collection of Silence
        All topics that fell silent.

    Raises
    ------
    BudgetError
        The memory is not enough to tell.
    """
    if not follower.is_certain or not state.products:
        return ()
    shown = follower.net.shown
    names = {silence.topic for silence in silent}
    free = {number for topic, found in shown.items() if topic not in names for number in found}
    try:
        return tuple(
            silence
            for silence in silent
            if _must_go_on(follower, state, frozenset(shown[silence.topic]), free)
        )
    except (DiagramMemoryError, SetsFullError):
        raise BudgetError(FULL) from None


def _must_go_on(follower: Follower, state: State, wanted: frozenset[int], free: Collection[int]) -> bool:
    """Return whether one of the wanted transitions must eventually fire, from all possible markings."""
    groups: dict[tuple[int, ...], list[int]] = {}
    for transition in wanted:
        asked = tuple(part for part in follower.touched[transition] if follower.parts[part].asks(transition))
        groups.setdefault(asked, []).append(transition)
    ways = [
        (asked, some)
        for asked, found in groups.items()
        for some in ([found] if len(asked) == 1 else [[each] for each in found])
    ]
    own = follower.net.own
    return all(
        any(
            all(_comes(follower.parts[part], product[part], some, free, own) for part in asked)
            for asked, some in ways
        )
        for product in state.products
    )


def _comes(
    part: MarkingSets, states: int, some: Collection[int], free: Collection[int], own: Collection[int]
) -> bool:
    """Return whether one of some shown transitions eventually becomes enabled in a part, and stays enabled.

    A game on sets of markings: the model's own transitions try to avoid it forever; any of the other
    transitions may come next. `away` is the largest set in which they can stay.
    """
    if not part.has_levels:
        return True
    silent = [each for at, each in enumerate(part.part.transitions) if at in part.part.silent]
    moving = {*silent, *free}
    choices = [
        chosen
        for place in range(len(part.part.places))
        if len(chosen := frozenset(part.consumers(place)) & frozenset(own) & moving) > 1
    ]
    moves, nature = part.restricted(moving), part.restricted(moving.difference(*choices))
    sets, everywhere = part.sets, part.anywhere
    with Scope(part.space.diagram) as scope:
        scope.hold(states)
        reached = states if moves is None else moves.closure(states, everywhere, False)
        scope.hold(reached)
        if part.meets_edge(reached):
            return False
        enabled = NOTHING
        for transition in some:
            found = part.enabled(reached, transition)
            scope.hold(reached, enabled, found)
            enabled = sets.union(enabled, found)
        scope.hold(reached, enabled)
        if moves is not None:
            left = moves.image(enabled, everywhere, False)
            scope.hold(reached, enabled, left)
            if sets.difference(left, enabled):
                return False
        scope.hold(reached, enabled)
        away = sets.difference(reached, enabled)
        alternatives = [each for chosen in choices if (each := part.restricted(chosen)) is not None]
        while away:
            scope.hold(reached, enabled, away)
            outside = sets.difference(reached, away)
            scope.hold(reached, enabled, away, outside)
            leaving = NOTHING if nature is None else nature.image(outside, away, True)
            for each in alternatives:
                scope.hold(reached, enabled, away, outside, leaving)
                staying = each.image(away, away, True)
                scope.hold(reached, enabled, away, outside, leaving, staying)
                forced = each.image(outside, away, True)
                scope.hold(reached, enabled, away, outside, leaving, staying, forced)
                forced = sets.difference(forced, staying)
                scope.hold(reached, enabled, away, outside, leaving, forced)
                leaving = sets.union(leaving, forced)
            if not leaving:
                return False
            scope.hold(reached, enabled, away, leaving)
            away = sets.difference(away, leaving)
        return True
