"""Firing selection: which of the enabled transitions fires next (paper, Listing 2).

By default, an enabled transition is drawn uniformly at random. A developer's function may choose instead: it
gets the enabled transitions with the tokens that they would take, and returns one of them, one with other
tokens, or None.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from random import Random
from types import MappingProxyType
from typing import overload

from dineros.metamodel.errors import DinerosError, near_matches
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.tokens import Token, copy_data


class SelectionError(DinerosError):
    """A selection function returned something that cannot fire."""


@dataclass(frozen=True)
class Choice:
    """A transition and the tokens that it takes from some of its places; made by `Enabled.taking`."""

    enabled: Enabled
    tokens: Mapping[str, tuple[int, ...]]


class Enabled:
    """A transition that can fire.

    Attributes
    ----------
    transition : str
        Id of the transition in the model.
    instance : int or None
        Number of its server instance, from 1.
    id : str
        Its id in the running net.
    """

    def __init__(self, engine: Engine, number: int) -> None:
        structure = engine.structure
        self.transition = structure.transition_names[number]
        self.instance = structure.instances[number]
        self.id = structure.transitions[number]
        self._engine = engine
        self._number = number

    @cached_property
    def inputs(self) -> Mapping[str, tuple[Token, ...]]:
        """Copies of the tokens that it would take or read, by the place's id."""
        engine, number = self._engine, self._number
        return named_copies(engine, [*engine.would_take(number), *engine.would_read(number)])

    @cached_property
    def available(self) -> Mapping[str, tuple[Token, ...]]:
        """Copies of all tokens that it may take, the oldest first, by the place's id in the model."""
        engine, number = self._engine, self._number
        tokens = [(place, engine.available(number, place)) for place, _ in engine.structure.inputs[number]]
        return named_copies(engine, tokens)

    def taking(self, tokens: Mapping[str, Token | int | Sequence[Token | int]]) -> Choice:
        """Return the choice to fire with these tokens; other places give their oldest tokens."""
        chosen = {}
        for place, some in tokens.items():
            several = [some] if isinstance(some, (Token, int)) else list(some)
            chosen[place] = tuple(token.id if isinstance(token, Token) else token for token in several)
        return Choice(self, chosen)

    def __repr__(self) -> str:
        return f"<Enabled {self.id}>"


class Candidates(Sequence[Enabled]):
    """The enabled transitions, in model order."""

    def __init__(self, members: Sequence[Enabled], random: Random) -> None:
        self._members = tuple(members)
        self._random = random

    @overload
    def __getitem__(self, index: int) -> Enabled: ...
    @overload
    def __getitem__(self, index: slice) -> Sequence[Enabled]: ...
    def __getitem__(self, index: int | slice) -> Enabled | Sequence[Enabled]:
        """Return one or several of them."""
        return self._members[index]

    def __len__(self) -> int:
        return len(self._members)

    def __iter__(self) -> Iterator[Enabled]:
        return iter(self._members)

    def named(self, transition: str) -> Enabled | None:
        """Return the first transition with this id, in the model or in the running net; None: no such one."""
        for member in self._members:
            if transition in (member.transition, member.id):
                return member
        return None

    def random(self) -> Enabled:
        """Return one of them, drawn uniformly with the seed of the net."""
        return self._members[int(self._random.random() * len(self._members))]


SelectionFunction = Callable[[Candidates], Enabled | Choice | None]


def named_copies(engine: Engine, tokens: Tokens) -> Mapping[str, tuple[Token, ...]]:
    """Return copies of tokens by the ids of their places in the model."""
    names = engine.structure.place_names
    copies: dict[str, tuple[Token, ...]] = {}
    for place, some in tokens:
        made = tuple(Token(token.id, copy_data(token.data)) for token in some)
        copies[names[place]] = copies.get(names[place], ()) + made
    return MappingProxyType(copies)


def chosen_tokens(engine: Engine, candidates: Candidates, chosen: object) -> tuple[int, Tokens] | None:
    """Return the transition and the tokens that a selection function chose.

    Raises
    ------
    SelectionError
        It is not a candidate, its tokens are not available, or their number does not match the arcs.
    """
    if chosen is None:
        return None
    enabled, tokens = (chosen.enabled, chosen.tokens) if isinstance(chosen, Choice) else (chosen, {})
    if not isinstance(enabled, Enabled) or enabled not in list(candidates):
        raise SelectionError(
            f"the selection returned {chosen!r}", hint="return one of the given transitions, or None"
        )
    number = enabled._number
    structure = engine.structure
    taken = engine.would_take(number)
    places = {structure.place_names[place]: position for position, (place, _) in enumerate(taken)}
    for name, ids in tokens.items():
        if name not in places:
            raise SelectionError(
                f"{enabled.id} takes nothing from {name!r}", hint=near_matches(name, list(places))
            )
        place, oldest = taken[places[name]]
        known = {token.id: token for token in engine.available(number, place)}
        if len(set(ids)) != len(oldest) or not known.keys() >= set(ids) or len(ids) != len(oldest):
            raise SelectionError(
                f"{enabled.id} takes {len(oldest)} of the tokens {sorted(known)} from {name!r}, not {ids}"
            )
        taken[places[name]] = (place, [known[id] for id in ids])
    return number, taken
