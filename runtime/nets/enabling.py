"""Keeps track of enabled transitions incrementally: the cost of a change depends on its own arcs only.

Each transition counts its violated conditions: an input place with too few free tokens, a read or inhibitor
arc, a false disjunction of its clause, an output place without room, a hold. It is *ready* if this count is
0. Each place knows the thresholds at which a condition changes, so a change of its token count updates only
the conditions that change. Tokens that fulfil a guard are counted like the tokens of a place, after the
places (see `Kinds`). Departures (tokens of a place that a port sends) are counted like transitions, after the
transitions.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import fulfils
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token


class Enabling:
    """Counts of tokens and of violated conditions.

    Attributes
    ----------
    ready : list of int
        Transitions that can fire with free tokens, in no particular order. Read-only for callers.
    due : list of int
        Numbers of the departures whose place has a free token to send. Read-only for callers.
    free, total : list of int
        For each place, its number of free (not reserved) tokens and its number of all tokens; then the same
        for each kind of tokens.
    kinds_taken, kinds_read : list of tuple of int
        For each transition, the kinds of tokens of which its guard needs one to take or to read: indices into
        `free` and `total`.
    room : list of int or None
        For each place, how many more tokens it may hold, without reserved room; None: any number.
    opened : list of int
        Places that had no room and got some; the component that waits for room reads and clears it.
    signals : list of bool or str
        Values of the signals.
    broken : set of int or None
        Transitions that have stopped being ready, even if only during a firing; the user reads and clears it.
        None: they are not recorded.
    """

    __slots__ = (
        "_consumers",
        "_disjunctions",
        "_literals",
        "_missing",
        "_places",
        "_positions",
        "_raisers",
        "_signal_literals",
        "_tight",
        "_transitions",
        "_true",
        "_watchers",
        "broken",
        "due",
        "free",
        "kinds_read",
        "kinds_taken",
        "opened",
        "ready",
        "room",
        "signals",
        "total",
    )

    def __init__(self, structure: Structure, counts: Sequence[int], signals: Sequence[SignalSetting]) -> None:
        self._transitions = len(structure.transitions)
        self._places = len(structure.places) + len(structure.kinds)
        self.free = [0] * self._places
        self.total = [0] * self._places
        kinds = {kind: number for number, kind in enumerate(structure.kinds, len(structure.places))}
        decisions = structure.decisions
        self.kinds_taken = [tuple(kinds[kind] for kind in decision.takes) for decision in decisions]
        self.kinds_read = [tuple(kinds[kind] for kind in decision.reads) for decision in decisions]
        self.room = [*structure.limits, *[None] * len(structure.kinds)]
        self.opened: list[int] = []
        self.broken: set[int] | None = None
        self.ready: list[int] = []
        self.due: list[int] = []
        self._missing = [0] * self._transitions
        self._positions = [-1] * self._transitions
        # Place -> [transition, free tokens it needs]: lists, because tokens put aside raise the threshold.
        self._consumers: list[list[list[int]]] = [[] for _ in range(self._places)]
        # Place -> (transition, threshold of all tokens, whether it needs at least that many, or fewer).
        self._watchers: list[list[tuple[int, int, bool]]] = [[] for _ in range(self._places)]
        # Place -> (transition, room it needs).
        self._raisers: list[list[tuple[int, int]]] = [[] for _ in range(self._places)]
        self._connect(structure)
        # Place -> with at least this room, before and after, a change of room changes nothing else.
        self._tight = [max((need for _, need in raisers), default=1) for raisers in self._raisers]
        self._disjunctions: list[int] = []  # the transition of each
        self._true: list[int] = []  # how many of its literals are true
        self._signal_literals: list[list[tuple[int, SignalSetting, bool]]] = [[] for _ in structure.signals]
        self.signals: list[SignalSetting] = [False] * len(structure.signals)
        self._connect_clauses(structure)
        for index in range(self._transitions):
            if not self._missing[index]:
                self._enter(index)
        for place, count in enumerate(counts):
            if count:
                self.change(place, count, count)
        for signal, value in enumerate(signals):
            self.set_signal(signal, value)

    def _connect(self, structure: Structure) -> None:
        for transition in range(self._transitions):
            for place, weight in structure.inputs[transition]:
                self._consumers[place].append([transition, weight])
                self._missing[transition] += 1
            for place, need in structure.reads[transition]:
                self._watchers[place].append((transition, need, True))
                self._missing[transition] += 1
            for place, limit in structure.inhibitors[transition]:
                self._watchers[place].append((transition, limit, False))
            for place, more in structure.raises[transition]:
                self._raisers[place].append((transition, more))
                self._missing[transition] += (self.room[place] or 0) < more
            for kind in self.kinds_taken[transition]:
                self._consumers[kind].append([transition, 1])
                self._missing[transition] += 1
            for kind in self.kinds_read[transition]:
                self._watchers[kind].append((transition, 1, True))
                self._missing[transition] += 1

    def add_departure(self, place: int, least: int = 1) -> int:
        """Register a departure: tokens of a place that a port sends; return its number; on hold at first.

        It is due if the place has at least `least` free tokens.
        """
        index = len(self._missing)
        self._consumers[place].append([index, least])
        self._missing.append(1 if self.free[place] >= least else 2)
        self._positions.append(-1)
        return index

    def _connect_clauses(self, structure: Structure) -> None:
        """Count true literals of each disjunction, with all signals false: those with values have none."""
        for transition, clause in enumerate(structure.clauses):
            for disjunction in clause:
                number = len(self._disjunctions)
                self._disjunctions.append(transition)
                self._true.append(sum(negated for _, _, negated in disjunction))
                for signal, wanted, negated in disjunction:
                    self._signal_literals[signal].append((number, wanted, negated))
                if not self._true[number]:
                    self._missing[transition] += 1

    def change(self, place: int, free: int, total: int) -> None:
        """Add to the number of free tokens and of all tokens of a place."""
        if free:
            before = self.free[place]
            after = self.free[place] = before + free
            if free > 0:
                for index, need in self._consumers[place]:
                    if before < need <= after:
                        self.satisfied(index)
            else:
                for index, need in self._consumers[place]:
                    if after < need <= before:
                        self.violated(index)
        if total:
            before = self.total[place]
            after = self.total[place] = before + total
            room = self.room[place]
            if room is not None:
                left = room - total
                tight = self._tight[place]
                if left < tight or room < tight:
                    self.change_room(place, -total)
                else:
                    self.room[place] = left
            watchers = self._watchers[place]
            if watchers:
                for index, threshold, wanted in watchers:
                    reached = after >= threshold
                    if reached is not (before >= threshold):
                        if reached is wanted:
                            self.satisfied(index)
                        else:
                            self.violated(index)

    def change_room(self, place: int, more: int) -> None:
        """Add to the room of a place with a capacity."""
        before = self.room[place]
        assert before is not None
        after = self.room[place] = before + more
        for index, need in self._raisers[place]:
            if before < need <= after:
                self.satisfied(index)
            elif after < need <= before:
                self.violated(index)
        if before < 1 <= after:
            self.opened.append(place)

    def set_need(self, transition: int, place: int, need: int) -> None:
        """Change the number of free tokens of an input place that a transition needs."""
        for consumer in self._consumers[place]:
            if consumer[0] == transition:
                held, holds = self.free[place] >= consumer[1], self.free[place] >= need
                consumer[1] = need
                if holds and not held:
                    self.satisfied(transition)
                elif held and not holds:
                    self.violated(transition)

    def set_signal(self, signal: int, value: SignalSetting) -> None:
        """Set a signal and count the literals that turn."""
        before = self.signals[signal]
        if before == value:
            return
        self.signals[signal] = value
        for disjunction, wanted, negated in self._signal_literals[signal]:
            is_value = value == wanted
            if is_value is (before == wanted):
                continue
            if is_value is not negated:
                self._true[disjunction] += 1
                if self._true[disjunction] == 1:
                    self.satisfied(self._disjunctions[disjunction])
            else:
                self._true[disjunction] -= 1
                if not self._true[disjunction]:
                    self.violated(self._disjunctions[disjunction])

    def satisfied(self, index: int) -> None:
        """Record that one more condition of a transition or departure holds."""
        missing = self._missing[index] = self._missing[index] - 1
        if not missing:
            self._enter(index)

    def violated(self, index: int) -> None:
        """Record that one condition of a transition or departure no longer holds."""
        missing = self._missing[index] = self._missing[index] + 1
        if missing == 1:
            members = self.ready if index < self._transitions else self.due
            if self.broken is not None and index < self._transitions:
                self.broken.add(index)
            last = members.pop()
            if last != index:
                position = self._positions[index]
                members[position] = last
                self._positions[last] = position
            self._positions[index] = -1

    def _enter(self, index: int) -> None:
        members = self.ready if index < self._transitions else self.due
        self._positions[index] = len(members)
        members.append(index)

    def is_ready(self, index: int) -> bool:
        """Return whether all conditions of a transition or departure hold."""
        return not self._missing[index]


class Kinds:
    """Reports to `Enabling` how many tokens of each place fulfil the guard of some transition.

    Parameters
    ----------
    structure : Structure
        The net.
    enabling : Enabling
        Keeps these counts after those of the places.

    Attributes
    ----------
    places : frozenset of int
        The places that occur in guards.
    """

    def __init__(self, structure: Structure, enabling: Enabling) -> None:
        self._enabling = enabling
        self._at: dict[int, list[tuple[int, Condition]]] = {}
        for number, (place, condition) in enumerate(structure.kinds, len(structure.places)):
            self._at.setdefault(place, []).append((number, condition))
        self.places = frozenset(self._at)

    def change(self, place: int, tokens: Collection[Token], free: int, total: int) -> None:
        """Update the counts: each of these tokens changes the free tokens and all tokens by these amounts."""
        for number, condition in self._at[place]:
            count = sum(fulfils(condition, token.data) for token in tokens)
            if count:
                self._enabling.change(number, free * count, total * count)

    def hide(self, transition: int, place: int, tokens: Collection[Token]) -> None:
        """Raise a transition's need by its matching free tokens that are put aside."""
        for number, condition in self._at.get(place, ()):
            if number in self._enabling.kinds_taken[transition]:
                hidden = sum(fulfils(condition, token.data) for token in tokens)
                self._enabling.set_need(transition, number, 1 + hidden)
