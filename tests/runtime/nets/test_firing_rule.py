"""Any sequence of firings, arrivals, departures and signal changes equals the plain firing rule on counts."""

from __future__ import annotations

import random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.runtime import Aside, Net, Node, Policy, Retry
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.structure import read_structure
from tests.runtime.nets.reference_rule import ReferenceNet, references
from tests.support.ros2_systems.history_models import history_models
from tests.support.systems.models import system_models
from tests.support.systems.small_systems import small_system_models

MODELS = st.one_of(small_system_models(), system_models(), history_models(small_system_models()))


def counts(engine: Engine) -> dict[str, int]:
    return {id: engine.count(place) for place, id in enumerate(engine.structure.places)}


def allowed(engine: Engine) -> set[str]:
    transitions = engine.structure.transitions
    return {transitions[t] for t in engine.ready if not engine.is_overridden(t)}


@given(MODELS)
@settings(max_examples=12)
def test_the_structure_is_that_of_the_flattened_net(model: sym.SystemModel) -> None:
    for node, reference in references(model):
        structure = read_structure(node)
        assert set(structure.places) == set(reference.marking)
        assert set(structure.transitions) == set(reference.names)
        for number, id in enumerate(structure.transitions):
            takes = {structure.places[place]: weight for place, weight in structure.inputs[number]}
            # A read arc is there as a pair: what must be there in all, and what comes back.
            needs = takes | {structure.places[place]: need for place, need in structure.reads[number]}
            assert needs == {p: n for p, n in reference.takes[id].items() if p not in reference.room}
            gives = {structure.places[place]: weight for place, weight in structure.outputs[number]}
            puts = {p: n for p, n in reference.puts[id].items() if p not in reference.room}
            for place in needs:
                puts[place] = puts.get(place, 0) - (needs[place] - takes.get(place, 0))
            assert gives == {place: weight for place, weight in puts.items() if weight}


class _Play:
    """Plays an engine and the reference side by side."""

    def __init__(self, engine: Engine, reference: ReferenceNet, draw: random.Random) -> None:
        self.engine = engine
        self.reference = reference
        self.random = draw
        self.in_flight: list[tuple[int, Any]] = []

    def check(self) -> None:
        assert counts(self.engine) == dict(self.reference.marking)
        for place, id in enumerate(self.engine.structure.places):
            capacity = self.engine.structure.capacities[place]
            assert capacity is None or self.engine.count(place) <= capacity
            assert (capacity is None) == (id not in self.reference.room_of)
            if not self.in_flight:
                assert self.engine.has_room(place) == self.reference.has_room(id)
        if not self.in_flight:
            assert allowed(self.engine) == self.reference.allowed()
        else:  # reserved tokens are nobody else's
            assert allowed(self.engine) <= self.reference.allowed()

    def move(self) -> None:
        move = self.random.choice(["fire", "fire", "fire", "begin", "end", "put", "take", "signal"])
        getattr(self, move)()
        self.check()

    def fire(self) -> None:
        candidates = sorted(allowed(self.engine))
        if candidates:
            id = self.random.choice(candidates)
            self.engine.fire(self.engine.structure.transitions.index(id))
            self.reference.fire(id)

    def begin(self) -> None:
        candidates = sorted(allowed(self.engine))
        if candidates:
            number = self.engine.structure.transitions.index(self.random.choice(candidates))
            taken = self.engine.would_take(number)
            self.engine.reserve(number, taken)
            self.in_flight.append((number, taken))

    def end(self) -> None:
        if not self.in_flight:
            return
        number, taken = self.in_flight.pop(self.random.randrange(len(self.in_flight)))
        may_commit = self.engine.is_allowed(number)
        id = self.engine.structure.transitions[number]
        # Its tokens and its room are still there, so it is allowed exactly if the plain rule allows it.
        assert may_commit == (id in self.reference.allowed())
        self.engine.release(number, taken)
        if may_commit and self.random.random() < 0.7:
            made = self.engine.made(number, taken, self.engine.passing.passed_on(number, taken))
            self.engine.commit(taken, made)
            self.reference.fire(id)

    def put(self) -> None:
        place = self.random.randrange(len(self.engine.structure.places))
        if self.engine.has_room(place):
            self.engine.put(place, self.engine.new_token(self.engine.passing.checkers[place].default))
            self.reference.arrive(self.engine.structure.places[place], 1)

    def take(self) -> None:
        reserved = [place for _, taken in self.in_flight for place, tokens in taken for _ in tokens]
        free = [
            place
            for place in range(len(self.engine.structure.places))
            if self.engine.count(place) > reserved.count(place)
        ]
        if free:
            place = self.random.choice(free)
            self.engine.take(place)
            self.reference.arrive(self.engine.structure.places[place], -1)

    def signal(self) -> None:
        if self.engine.structure.signals:
            number = self.random.randrange(len(self.engine.structure.signals))
            value = self.random.random() < 0.5
            self.engine.set_signal(number, value)
            self.reference.signals[self.engine.structure.signals[number]] = value


@given(MODELS, st.integers(0, 2**32))
@settings(max_examples=20)
def test_the_engine_follows_the_plain_rule(model: sym.SystemModel, seed: int) -> None:
    for node, reference in references(model):
        play = _Play(Engine(read_structure(node)), reference, random.Random(seed))
        play.check()
        for _ in range(40):
            play.move()


class _FaultError(Exception):
    pass


def faulty(draw: random.Random) -> Any:
    """Return a handler that does something wrong now and then."""

    def handler(firing: Any) -> Any:
        kind = draw.choice(["none", "none", "data", "raise", "wrong", "unknown", "vandal", "give"])
        if kind == "raise":
            raise _FaultError
        if kind == "wrong":
            return 42
        if kind == "unknown":
            return {"no such field": 1}
        if kind == "vandal":  # what it gets are copies
            firing.data.clear()
            for tokens in firing.inputs.values():
                for token in tokens:
                    token.data.clear()
            if draw.random() < 0.5:
                raise SystemExit(3)
        if kind == "give":
            return firing.give(
                {place: [{}] * draw.choice([1, weight]) for place, weight in firing.outputs.items()}
            )
        return None

    return handler


@pytest.mark.long
@pytest.mark.filterwarnings("error")
@given(MODELS, st.integers(0, 2**32))
@settings(max_examples=15)
def test_faulty_handlers_change_nothing(model: sym.SystemModel, seed: int) -> None:
    draw = random.Random(seed)
    for node_model, reference in references(model):
        recorder = ListRecorder()
        policies: list[Policy] = [Aside(), Retry(attempts=3, delay=0.0, then=Aside())]
        policy = draw.choice(policies)
        net = Net(node_model, seed=seed, policy=policy)
        for number, id in enumerate(net.structure.transitions):
            for each in range(draw.choice([0, 1, 2])):
                net.handler(id, name=f"{number}.{each}", priority=draw.choice([0, 1]))(faulty(draw))
        node = Node(net, recorder=recorder)
        node.open()
        for _ in range(60):
            before = net.inspect()
            seen = len(recorder.records)
            if draw.random() < 0.2 and net.structure.signals:
                signal = draw.choice(net.structure.signals)
                value = draw.random() < 0.5
                net.signal(signal).set(value)
                reference.signals[signal] = value
            node.step()
            after = net.inspect()
            fired = [record for record in recorder.records[seen:] if record["event"] == "fire"]
            for record in fired:
                reference.fire(str(record["transition"]))
            if not fired:
                assert after.marking == before.marking
            assert {place: len(tokens) for place, tokens in after.marking.items()} == dict(reference.marking)
            for place, tokens in after.marking.items():
                fields = {field.name for field in net.structure.ports.type_at(place).fields}
                assert all(set(token.data) == fields for token in tokens)
            assert set(after.enabled) == reference.allowed()
        node.close()
