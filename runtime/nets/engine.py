"""The marking with its balloon tokens, and the only four ways to change it: fire, put, take, set a signal.

The engine has no handlers, clock or transport; `dineros.runtime.firing` decides which transition fires when.
A place is a queue; a transition takes the oldest tokens that fulfil its guard, unless the caller chooses
tokens. Tokens can be *reserved* for a firing in flight, together with room for the tokens that it will put:
they stay on their places and read and inhibitor arcs see them, but no other firing takes them or fills the
room.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import islice

from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import fulfils
from dineros.metamodel.token_data import Value
from dineros.runtime.nets.aside import PutAside
from dineros.runtime.nets.enabling import Enabling, Kinds
from dineros.runtime.nets.passing import Passing, Tokens
from dineros.runtime.nets.ports import Data
from dineros.runtime.nets.structure import Structure
from dineros.runtime.nets.tokens import Token
from dineros.runtime.nets.weights import FEW, Weights

_new_tuple = tuple.__new__
"""Makes a token without a call of Python code: engines make one or more in each firing."""


def _always(transition: int) -> bool:
    return True


class Engine:
    """A marked net.

    Parameters
    ----------
    structure : Structure
        The net.
    marking : sequence of sequence of Token, optional
        For each place its tokens, the oldest first; by default the initial marking.
    signals : sequence of bool or str, optional
        Values of the signals; by default the initial ones.
    next_token : int
        The first id for new tokens; larger than any id in the marking.

    Attributes
    ----------
    passing : Passing
        Which data a firing passes on.
    aside : PutAside
        Tokens put aside for one transition after a failure.
    ready : list of int
        Transitions that can fire now with free tokens, ignoring priorities. Read-only for callers.
    due : list of int
        Numbers of the departures that can happen now. Read-only for callers.
    opened : list of int
        Places with a capacity that were full and now have room; the component that adds tokens reads and
        clears it.
    """

    def __init__(
        self,
        structure: Structure,
        marking: Sequence[Sequence[Token]] | None = None,
        signals: Sequence[SignalSetting] | None = None,
        next_token: int = 1,
    ) -> None:
        self.structure = structure
        self.passing = Passing(structure, self.would_read)
        self.next_token = next_token
        if marking is None:
            marking = [[self.new_token(data) for data in initial] for initial in structure.initial]
        self._tokens = [deque(tokens) for tokens in marking]
        self._enabling = Enabling(
            structure,
            [len(tokens) for tokens in marking],
            structure.initial_signals if signals is None else signals,
        )
        self._kinds = Kinds(structure, self._enabling)
        self._asked = self._kinds.places
        for place in self._asked:
            self._kinds.change(place, marking[place], 1, 1)
        # Transition -> place -> condition of its guard for the token that it takes or reads there.
        self._asks: tuple[dict[int, Condition], ...] = tuple(
            dict((*decision.takes, *decision.reads)) for decision in structure.decisions
        )
        self.weights = Weights(structure, self._enabling, self._tokens)
        self._weighed, self._counted = self.weights.places, self.weights.counted
        self._total = self._enabling.total
        for place in self._weighed:
            self.weights.add(place, self._tokens[place])
        self.ready = self._enabling.ready
        self.due = self._enabling.due
        self.opened = self._enabling.opened
        self.opened.clear()
        enabling = self._enabling
        self.is_ready, self.change_room = enabling.is_ready, enabling.change_room
        self.add_departure, self.set_least = enabling.add_departure, enabling.set_need
        # A held transition is not ready, a held departure is not due, until all holds are undone.
        self.hold, self.unhold = enabling.violated, enabling.satisfied
        self._reserved: dict[int, int] = {}  # token -> place
        self.aside = PutAside(structure, self._enabling, self._kinds, self._tokens, self._reserved)
        self._aside = self.aside.by_transition
        # A pipe takes one token and passes its data on: the most frequent kind of transition, with the
        # fastest code. No guard depends on its data, neither its own nor that of a transition that takes its
        # token.
        self._pipes = tuple(
            (inputs[0][0], tuple(place for place, _ in outputs))
            if len(inputs) == 1
            and not loops
            and all(weight == 1 for _, weight in (*inputs, *outputs))
            and all(structure.types[place] is structure.types[inputs[0][0]] for place, _ in outputs)
            and not assigns
            and self._asked.isdisjoint(place for place, _ in (*inputs, *outputs))
            else None
            for inputs, outputs, loops, assigns in zip(
                structure.inputs, structure.outputs, self.passing.loops, self.passing.assigns, strict=True
            )
        )
        self.prioritised = any(structure.superiors)

    # Reading the state.

    @property
    def signals(self) -> Sequence[SignalSetting]:
        """Values of the signals."""
        return self._enabling.signals

    def tokens(self, place: int) -> tuple[Token, ...]:
        """Return the tokens of a place, the oldest first, including reserved tokens."""
        return tuple(self._tokens[place])

    def free_tokens(self, place: int) -> list[Token]:
        """Return the tokens of a place that are not reserved by a firing in flight, the oldest first."""
        return [token for token in self._tokens[place] if token.id not in self._reserved]

    def count(self, place: int) -> int:
        """Return the number of tokens on a place."""
        return self._enabling.total[place]

    def has_room(self, place: int) -> bool:
        """Return whether a place may get one more token; from any thread."""
        room = self._enabling.room[place]
        return room is None or room > 0

    def is_enabled(self, transition: int) -> bool:
        """Return whether a transition is enabled, ignoring reservations, holds and priorities."""
        total, structure = self._enabling.total, self.structure
        return (
            all(total[place] >= weight for place, weight in structure.inputs[transition])
            and all(total[kind] for kind in self._enabling.kinds_taken[transition])
            and all(
                total[place] + more <= capacity
                for place, more in structure.raises[transition]
                if (capacity := structure.capacities[place]) is not None
            )
            and self._conditions_hold(transition)
        )

    def is_overridden(self, transition: int, could_fire: Callable[[int], bool] = _always) -> bool:
        """Return whether a transition of higher priority is enabled and `could_fire`."""
        return any(
            self.is_enabled(above) and could_fire(above) for above in self.structure.superiors[transition]
        )

    def note_breaks(self) -> set[int]:
        """Return a set that collects transitions that stop being ready, even if only during a firing.

        A firing first takes all its tokens and then puts others. The caller clears the set.
        """
        if self._enabling.broken is None:
            self._enabling.broken = set()
        return self._enabling.broken

    def is_allowed(self, transition: int) -> bool:
        """Return whether a transition may fire, given that its input tokens are there."""
        return self._conditions_hold(transition) and not self.is_overridden(transition)

    def _conditions_hold(self, transition: int) -> bool:
        """Return whether clause, read and inhibitor arcs, and guards on read arcs, allow a transition."""
        total, signals = self._enabling.total, self._enabling.signals
        structure = self.structure
        return (
            all(total[place] >= need for place, need in structure.reads[transition])
            and all(total[kind] for kind in self._enabling.kinds_read[transition])
            and all(total[place] < limit for place, limit in structure.inhibitors[transition])
            and all(
                any((signals[signal] == wanted) is not negated for signal, wanted, negated in disjunction)
                for disjunction in structure.clauses[transition]
            )
        )

    def available(self, transition: int, place: int) -> list[Token]:
        """Return the tokens of a place that a transition may take, the oldest first."""
        found = self._fulfilling(transition, place)
        if not self._reserved and not self._aside:
            return list(found)
        aside = self._aside.get(transition, {}).get(place, ())
        return [token for token in found if token.id not in self._reserved and token.id not in aside]

    def _fulfilling(self, transition: int, place: int) -> Iterable[Token]:
        """Return the tokens of a place that fulfil a guard's condition for it, the oldest first."""
        condition = self._asks[transition].get(place)
        tokens = self._tokens[place]
        return tokens if condition is None else (each for each in tokens if fulfils(condition, each.data))

    def would_take(self, transition: int) -> Tokens:
        """Return the tokens that a ready transition takes by default."""
        if not self._reserved and not self._aside:
            pipe = self._pipes[transition]
            if pipe is not None:
                return [(pipe[0], [self._tokens[pipe[0]][0]])]
            return [
                (place, list(islice(self._fulfilling(transition, place), weight)))
                for place, weight in self.structure.inputs[transition]
            ]
        return [
            (place, self.available(transition, place)[:weight])
            for place, weight in self.structure.inputs[transition]
        ]

    def would_read(self, transition: int) -> Tokens:
        """Return the tokens that read arcs of a ready transition see: the oldest after those it takes."""
        takes = dict(self.structure.inputs[transition])
        return [
            (place, list(islice(self._fulfilling(transition, place), takes.get(place, 0), need)))
            for place, need in self.structure.reads[transition]
        ]

    # Firing.

    def fire(self, transition: int) -> None:
        """Fire a ready transition; data is passed on unchanged."""
        pipe = self._pipes[transition]
        if pipe is not None and not self._reserved and not self._aside:
            place, outputs = pipe
            change, tokens = self._enabling.change, self._tokens
            total, weighed = self._total, self._weighed
            taken_one = tokens[place].popleft()
            data = taken_one[1]
            change(place, -1, -1)
            if place in self._counted:
                self.weights.remove(place, [taken_one])
            number = self.next_token
            for output in outputs:
                tokens[output].append(_new_tuple(Token, (number, data)))
                number += 1
                change(output, 1, 1)
                if total[output] > FEW and output in weighed:
                    self.weights.add(output, [taken_one])
            self.next_token = number
            return
        taken = self.would_take(transition)
        self.commit(taken, self.made(transition, taken, self.passing.passed_on(transition, taken)))

    def made(
        self, transition: int, taken: Tokens, data: Data, given: Mapping[int, Sequence[Data]] | None = None
    ) -> Tokens:
        """Make the tokens that a firing puts.

        Parameters
        ----------
        transition, taken : int, Tokens
            The transition, and the tokens it takes.
        data : mapping
            The data that is passed on.
        given : mapping, optional
            Data of all tokens for some of the output places, checked and complete.

        Returns
        -------
        Tokens
            For each output place, as many tokens as its arc's weight. A token of a loop is put back
            unchanged, except for assigned fields.
        """
        pipe = self._pipes[transition]
        if pipe is not None and given is None:
            return [(place, [self.new_token(data)]) for place in pipe[1]]
        own = dict(taken) if self.passing.loops[transition] else {}
        made: Tokens = []
        for place, weight in self.structure.outputs[transition]:
            if given is not None and place in given:
                tokens = [self.new_token(each) for each in given[place]]
            else:
                tokens = own.get(place, [])[:weight]
                fits = self.passing.is_result(transition, place)
                each = data if fits else self.passing.data_for(transition, taken, place)
                tokens += [self.new_token(each) for _ in range(weight - len(tokens))]
            if assigned := self.passing.assigned(transition, taken, place):
                tokens = [self._with(token, place, assigned) for token in tokens]
            made.append((place, tokens))
        return made

    def _with(self, token: Token, place: int, assigned: dict[str, Value]) -> Token:
        """Return a token with assigned values; the token itself, if it has these values."""
        if all(token.data[name] == value for name, value in assigned.items()):
            return token
        return self.new_token(self.passing.checkers[place].complete(assigned, token.data))

    def commit(self, taken: Tokens, made: Tokens) -> None:
        """Take free tokens and put others in one step."""
        change, total = self._enabling.change, self._total
        for place, tokens in taken:
            self._remove(place, tokens)
            if place in self._asked:
                self._kinds.change(place, tokens, -1, -1)
            change(place, -len(tokens), -len(tokens))
            if place in self._counted:
                self.weights.remove(place, tokens)
        for place, tokens in made:
            self._tokens[place].extend(tokens)
            change(place, len(tokens), len(tokens))
            if place in self._asked:
                self._kinds.change(place, tokens, 1, 1)
            if total[place] > FEW and place in self._weighed:
                self.weights.add(place, tokens)
        if self._aside:
            self.aside.forget(taken)

    def reserve(self, transition: int, taken: Tokens) -> None:
        """Reserve free tokens for a firing in flight, and room for the tokens it will put."""
        for place, more in self.structure.raises[transition]:
            self._enabling.change_room(place, -more)
        for place, tokens in taken:
            self._reserved.update((token.id, place) for token in tokens)
            if place in self._asked:
                self._kinds.change(place, tokens, -1, 0)
            self._enabling.change(place, -len(tokens), 0)
        if self._aside:
            self.aside.refresh(place for place, _ in taken)

    def release(self, transition: int, taken: Tokens) -> None:
        """Release a reservation."""
        for place, more in self.structure.raises[transition]:
            self._enabling.change_room(place, more)
        for place, tokens in taken:
            for token in tokens:
                del self._reserved[token.id]
            self._enabling.change(place, len(tokens), 0)
            if place in self._asked:
                self._kinds.change(place, tokens, 1, 0)
        if self._aside:
            self.aside.refresh(place for place, _ in taken)

    # Tokens and signals from outside.

    def new_token(self, data: Data) -> Token:
        """Return a new token that is on no place yet."""
        token = _new_tuple(Token, (self.next_token, data))
        self.next_token += 1
        return token

    def oldest(self, place: int) -> Token:
        """Return the oldest free token of a place; there must be one."""
        if not self._reserved:
            return self._tokens[place][0]
        return next(token for token in self._tokens[place] if token.id not in self._reserved)

    def put(self, place: int, token: Token) -> None:
        """Put a received token on a place; the place must have room."""
        self._tokens[place].append(token)
        self._enabling.change(place, 1, 1)
        if place in self._asked:
            self._kinds.change(place, [token], 1, 1)
        if self._total[place] > FEW and place in self._weighed:
            self.weights.add(place, [token])

    def take(self, place: int) -> Token:
        """Take the oldest free token of a place; there must be one."""
        tokens = self._tokens[place]
        if not self._reserved and not self._aside:
            token = tokens.popleft()
            if place in self._asked:
                self._kinds.change(place, [token], -1, -1)
            self._enabling.change(place, -1, -1)
            if place in self._counted:
                self.weights.remove(place, [token])
            return token
        token = self.oldest(place)
        self.commit([(place, [token])], [])
        return token

    def set_signal(self, signal: int, value: SignalSetting) -> bool:
        """Set a signal; return whether it changed."""
        changed = self._enabling.signals[signal] != value
        self._enabling.set_signal(signal, value)
        return changed

    def _remove(self, place: int, tokens: Sequence[Token]) -> None:
        queue = self._tokens[place]
        for token in tokens:
            if queue[0] is token:
                queue.popleft()
            else:
                queue.remove(token)
