"""Determines which messages have to be tried before another one, and which can be published after it."""

from __future__ import annotations

from math import prod

from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.following import FULL, Follower, Product, State
from dineros.observation.explaining.marking_sets import NOTHING, SetsFullError

Waiting = tuple[tuple[str, int], ...]
"""Topics, with the number of messages that remain to be published."""

MOST_CHOICES = 5_000
"""Limit of the sets of waiting messages for which a part is queried; beyond it, all messages are tried."""
MOST_KNOWN = 50_000
"""Limit of the cached answers."""
FREE_LOOKS = 5_000
"""Number of sets of waiting messages for which a part is always queried."""
LOOK_EVERY = 8
"""Queries for each further set; beyond this limit, all messages are tried."""


class Commuting:
    """Looks for messages that need not be tried before others.

    After some messages, it suffices to try a set of topics next if, for all messages of other topics that may
    be published first, the next message of each topic in the set can be *drawn forward* past them: all
    markings that are possible in that order are also possible in this one. Such sets are persistent sets
    [1]_, except that the two orders may lead to different markings: one may allow more. It holds where it
    holds in each part of the net.

    `follower`: the model.

    References
    ----------
    .. [1] P. Godefroid, *Partial-Order Methods for the Verification of Concurrent Systems*, LNCS 1032,
       Springer, 1996.
    """

    def __init__(self, follower: Follower) -> None:
        self._follower = follower
        self._near: dict[tuple[str, tuple[str, ...]], tuple[str, ...]] = {}
        self._needed: dict[tuple[str, Waiting, tuple[Product, ...]], tuple[str, ...]] = {}
        self._asked: dict[tuple[str, Waiting], tuple[Waiting, list[int]]] = {}
        self._met: dict[tuple[str, Waiting], list[tuple[int, int, Waiting]]] = {}
        self._blockers: dict[tuple[int, int, int, Waiting], str | None] = {}
        self._questions = self._looks = 0
        self._forgotten = follower.forgotten

    def near(self, topic: str, others: tuple[str, ...]) -> tuple[str, ...]:
        """Return the topics that depend on a given one, directly or through others.

        The other topics never affect it.
        """
        found = self._near.get((topic, others))
        if found is None:
            parts_of = self._follower.parts_of
            near, reached = {topic}, [topic]
            while reached:
                parts = parts_of[reached.pop()]
                met = {one for one in others if one not in near and not parts.isdisjoint(parts_of[one])}
                near |= met
                reached += met
            found = self._near[topic, others] = tuple(sorted(near - {topic}))
        return found

    def needed(self, state: State, topic: str, waiting: Waiting) -> tuple[str, ...]:
        """Return the topics whose next message has to be tried next if a message of `topic` follows.

        Parameters
        ----------
        state : State
            The current state.
        topic : str
            The topic of the message that is to come; it is the first of those returned.
        waiting : tuple of (str, int)
            The messages of other topics that may have been published before it.

        Raises
        ------
        BudgetError
            There are too many markings.
        """
        self._questions += 1
        if self._forgotten != self._follower.forgotten or self._is_full():
            self._forget()
        waiting, parts = self._ask(topic, waiting)
        # No other part has to do with any of them.
        key = topic, waiting, tuple([tuple([product[part] for part in parts]) for product in state.products])
        found = self._needed.get(key)
        if found is None:
            try:
                found = self._find(state, topic, waiting)
            except SetsFullError:
                self._follower.forget()
                self._forget()
                try:
                    found = self._find(state, topic, waiting)
                except SetsFullError:
                    raise BudgetError(FULL) from None
            self._needed[key] = found
        return found

    def _is_full(self) -> bool:
        return max(len(self._needed), len(self._asked), len(self._blockers), len(self._near)) > MOST_KNOWN

    def _forget(self) -> None:
        """Clear all caches: discarded sets of markings have lost their numbers."""
        for known in (self._near, self._needed, self._asked, self._met, self._blockers):
            known.clear()
        self._forgotten = self._follower.forgotten

    def _ask(self, topic: str, waiting: Waiting) -> tuple[Waiting, list[int]]:
        """Return the waiting messages, as one object for equal ones, and the parts that they affect."""
        found = self._asked.get((topic, waiting))
        if found is None:
            parts_of = self._follower.parts_of
            parts = parts_of[topic].union(*(parts_of[other] for other, _ in waiting))
            found = self._asked[topic, waiting] = waiting, sorted(parts)
        return found

    def _find(self, state: State, topic: str, waiting: Waiting) -> tuple[str, ...]:
        needed, unasked = [topic], [topic]
        while unasked:
            one = unasked.pop()
            while (blocker := self._blocker(state, one, waiting)) is not None:
                waiting = tuple(each for each in waiting if each[0] != blocker)
                needed.append(blocker)
                unasked.append(blocker)
        return tuple(needed)

    def _blocker(self, state: State, topic: str, waiting: Waiting) -> str | None:
        """Return a topic whose messages one of another topic cannot be moved before; None: all can."""
        known = self._blockers
        for transition, number, here in self._meetings(topic, waiting):
            if prod([count + 1 for _, count in here]) > MOST_CHOICES:
                return here[0][0]
            for factor in {product[number] for product in state.products}:
                key = number, factor, transition, here
                found = known[key] if key in known else self._blocker_in(*key)
                if found is not None:
                    return found
        return None

    def _meetings(self, topic: str, waiting: Waiting) -> list[tuple[int, int, Waiting]]:
        """Return the transitions that show a message, the changed parts, and the messages waiting there."""
        found = self._met.get((topic, waiting))
        if found is None:
            follower = self._follower
            found = self._met[topic, waiting] = [
                (transition, number, here)
                for transition in follower.net.shown[topic]
                for number in follower.touched[transition]
                if (here := tuple(each for each in waiting if number in follower.parts_of[each[0]]))
            ]
        return found

    def _blocker_in(self, number: int, factor: int, transition: int, waiting: Waiting) -> str | None:
        """Return a topic whose messages a shown transition cannot be moved before, in one part.

        It can be past one and more messages if it can be past all but the first, after that, and then past
        the first: if more is possible before a message, more is possible after it.
        """
        key = number, factor, transition, waiting
        if key in self._blockers:
            return self._blockers[key]
        if self._looks > FREE_LOOKS + self._questions // LOOK_EVERY:
            return waiting[0][0]
        self._looks += 1
        found, follower = None, self._follower
        sets = follower.parts[number]
        first = sets.step(factor, transition)
        later: list[tuple[int, Waiting]] = []
        for at, (topic, count) in enumerate(waiting):
            left = (*waiting[:at], *(((topic, count - 1),) if count > 1 else ()), *waiting[at + 1 :])
            for other in follower.net.shown[topic]:
                if number not in follower.touched[other]:
                    continue  # it changes nothing here
                after = sets.step(factor, other)
                late = sets.step(after, transition)
                if late != NOTHING and not sets.covers(sets.step(first, other), late):
                    found = topic
                elif after != NOTHING and left:
                    later.append((after, left))
        for after, left in later:
            if found is None:
                found = self._blocker_in(number, after, transition, left)
        self._blockers[key] = found
        return found
