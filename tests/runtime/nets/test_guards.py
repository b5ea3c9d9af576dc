"""Guards in the engine, compared with an interpreter that gives every token its data."""

from __future__ import annotations

import random
from collections.abc import Iterator
from itertools import permutations, product

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.passing import Tokens
from dineros.runtime.nets.structure import Structure, read_structure
from dineros.runtime.nets.tokens import Token
from dineros.transformations.flattening.split import split
from tests.support.references.guards import GUARDS, Choice, Rules, data_states, modelled
from tests.support.references.messages import ALL, Data

State = tuple[tuple[str, tuple[Data, ...]], ...]

_SOME = st.lists(st.integers(0, 3), min_size=1, max_size=2, unique=True).map(tuple)
CHOICES = st.lists(
    st.builds(
        Choice,
        takes=_SOME,
        puts=st.lists(st.integers(0, 3), max_size=1).map(tuple),
        reads=st.none() | st.integers(0, 3),
        guard=st.none() | st.integers(0, len(GUARDS) - 1),
        ok=st.none() | st.booleans(),
        copied=st.booleans(),
    ),
    min_size=1,
    max_size=4,
)
DATA = st.lists(st.sampled_from(ALL), min_size=1, max_size=2)


def _structure(model: sym.SystemModel) -> Structure:
    (part,) = split(model)
    return read_structure(part)


def _as_data(some: Data) -> dict[str, object]:
    return {"ok": some[0], "level": some[1]}


def _state(engine: Engine) -> State:
    places = enumerate(engine.structure.places)
    return tuple(
        sorted(
            (id, tuple(sorted((bool(t.data["ok"]), int(str(t.data["level"]))) for t in engine.tokens(place))))
            for place, id in places
        )
    )


def _engines(structure: Structure, state: State) -> Iterator[Engine]:
    """Yield the engine with the tokens of a state, in each order of each place."""
    by_place = dict(state)
    orders = [sorted(set(permutations(by_place[id]))) for id in structure.places]
    for order in product(*orders):
        number = iter(range(1, 100))
        marking = [[Token(next(number), _as_data(each)) for each in tokens] for tokens in order]  # type: ignore[arg-type]
        yield Engine(structure, marking, next_token=100)


def _choices(engine: Engine, transition: int) -> Iterator[Tokens]:
    """Yield what a transition may take; its arcs take one token each."""
    inputs = engine.structure.inputs[transition]
    for tokens in product(*(engine.available(transition, place) for place, _ in inputs)):
        yield [(place, [token]) for (place, _), token in zip(inputs, tokens, strict=True)]


def _reached(structure: Structure) -> dict[State, set[str]]:
    """Return the states that the engine reaches with all orders, choices and handlers."""
    start = _state(Engine(structure))
    found: dict[State, set[str]] = {}
    todo = [start]
    while todo:
        state = todo.pop()
        if state in found:
            continue
        enabled = found[state] = set()
        for engine in _engines(structure, state):
            ready = sorted(engine.ready)
            enabled.update(structure.transitions[each] for each in ready)
            assert ready == [each for each in range(len(structure.transitions)) if engine.is_enabled(each)]
            for transition in ready:
                assert engine.would_take(transition) == next(_choices(engine, transition))
                outputs = structure.outputs[transition]
                for number in range(len(list(_choices(engine, transition)))):
                    for values in product(ALL, repeat=len(outputs)):
                        (other,) = (e for e in _engines(structure, state) if _same(e, engine))
                        taken = list(_choices(other, transition))[number]
                        given = {
                            place: [_as_data(each)] for (place, _), each in zip(outputs, values, strict=True)
                        }
                        passed = other.passing.passed_on(transition, taken)
                        other.commit(taken, other.made(transition, taken, passed, given))  # type: ignore[arg-type]
                        todo.append(_state(other))
    return found


def _same(one: Engine, other: Engine) -> bool:
    return all(one.tokens(place) == other.tokens(place) for place in range(len(one.structure.places)))


@settings(max_examples=40, deadline=None)
@given(CHOICES, DATA)
def test_the_engine_reaches_what_tokens_with_data_reach(chosen: list[Choice], data: list[Data]) -> None:
    model, meanings = modelled(chosen, data)
    expected = data_states(model, meanings)
    assert expected is not None
    assert _reached(_structure(model)) == expected


class _Play:
    """Random moves of an engine; after each, what is ready is what the meanings of the guards say."""

    def __init__(self, structure: Structure, meanings: dict[str, Rules], seed: int) -> None:
        self.engine, self.structure, self.meanings = Engine(structure), structure, meanings
        self.random = random.Random(seed)
        self.flights: list[tuple[int, Tokens]] = []
        self.aside: dict[int, set[int]] = {}

    def _allows(self, transition: int, place: int, token: Token) -> bool:
        rules = self.meanings.get(self.structure.transitions[transition], Rules({}, {}, {}))
        holds = rules.guard.get(self.structure.places[place])
        return holds is None or holds((bool(token.data["ok"]), int(str(token.data["level"]))))

    def check(self) -> None:
        reserved = {token.id for _, taken in self.flights for _, tokens in taken for token in tokens}
        for transition in range(len(self.structure.transitions)):
            hidden = reserved | self.aside.get(transition, set())

            def fits(place: int, without: set[int], transition: int = transition) -> bool:
                return any(
                    token.id not in without and self._allows(transition, place, token)
                    for token in self.engine.tokens(place)
                )

            takes = {place for place, _ in self.structure.inputs[transition]}
            reads = {place for place, _ in self.structure.reads[transition]} - takes
            can_read = all(fits(place, set()) for place in reads)
            assert self.engine.is_ready(transition) == (can_read and all(fits(p, hidden) for p in takes))
            assert self.engine.is_enabled(transition) == (can_read and all(fits(p, set()) for p in takes))
            assert self.engine.is_allowed(transition) == can_read
            if self.engine.is_ready(transition):
                for place, (token,) in (
                    *self.engine.would_take(transition),
                    *self.engine.would_read(transition),
                ):
                    known = hidden if place in takes else set()
                    first = next(
                        each
                        for each in self.engine.tokens(place)
                        if each.id not in known and self._allows(transition, place, each)
                    )
                    assert token is first

    def move(self) -> None:
        engine, draw = self.engine, self.random
        place = draw.randrange(len(self.structure.places))
        ready = sorted(engine.ready)
        match draw.choice(["fire", "fire", "reserve", "end", "put", "take", "aside", "release"]):
            case "fire" if ready:
                engine.fire(draw.choice(ready))
            case "reserve" if ready:
                transition = draw.choice(ready)
                taken = engine.would_take(transition)
                engine.reserve(transition, taken)
                self.flights.append((transition, taken))
            case "end" if self.flights:
                transition, taken = self.flights.pop(draw.randrange(len(self.flights)))
                engine.release(transition, taken)
                if draw.random() < 0.5 and engine.is_allowed(transition):
                    engine.commit(
                        taken, engine.made(transition, taken, engine.passing.passed_on(transition, taken))
                    )
            case "put" if engine.count(place) < 3:
                engine.put(place, engine.new_token(_as_data(draw.choice(ALL))))  # type: ignore[arg-type]
            case "take" if engine.free_tokens(place):
                engine.take(place)
            case "aside" if ready:
                transition = draw.choice(ready)
                taken = engine.would_take(transition)
                engine.aside.put(transition, taken)
                self.aside.setdefault(transition, set()).update(t.id for _, some in taken for t in some)
            case "release" if self.aside:
                transition = draw.choice(sorted(self.aside))
                del self.aside[transition]
                engine.aside.release(transition)


@settings(max_examples=40, deadline=None)
@given(CHOICES, DATA, st.integers(0, 2**32))
def test_what_is_ready_follows_every_move(chosen: list[Choice], data: list[Data], seed: int) -> None:
    model, meanings = modelled([each._replace(guard=each.guard or 0) for each in chosen], data)
    for number in range(5):
        play = _Play(_structure(model), meanings, seed + number)
        play.check()
        for _ in range(60):
            play.move()
            play.check()


def test_assigned_fields_and_those_of_loops() -> None:
    """What a loop takes comes back as it is, but for the fields that are assigned."""
    model, _ = modelled([Choice((0,), (0,), None, 0, False, copied=False)], [(True, 2)])
    engine = Engine(_structure(model))
    (before,) = engine.tokens(0)
    engine.fire(0)
    (after,) = engine.tokens(0)
    assert dict(after.data) == {"ok": False, "level": 2}
    assert after.id != before.id
    assert not engine.ready  # the guard asks for `ok`
    find(model, "T0", sym.Transition).assigns = "P0.ok := true"
    engine = Engine(_structure(model))
    (before,) = engine.tokens(0)
    engine.fire(0)
    assert engine.tokens(0) == (before,)
