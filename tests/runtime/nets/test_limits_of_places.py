"""Places that others can fill hold a limited number of tokens in a run, whatever the model says."""

from __future__ import annotations

import logging
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import flow, here
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.nets import capacities, weights
from dineros.runtime.nets import engine as engine_module
from dineros.runtime.nets.engine import Engine
from dineros.runtime.nets.structure import Structure, read_structure
from dineros.runtime.nodes.health import HealthWatch
from dineros.transformations.flattening.split import split
from tests.support.systems.talker import talker


def structure_of(model: sym.SystemModel, node: str) -> Structure:
    return read_structure(next(each for each in split(model) if each.node.id == node))


def limits(model: sym.SystemModel, node: str) -> dict[str, int | None]:
    structure = structure_of(model, node)
    return dict(zip(structure.places, structure.limits, strict=True))


@pytest.mark.parametrize("middleware", ["ros1", "ros2"])
def test_what_others_can_fill_is_limited(middleware: str) -> None:
    model = talker()
    model.middleware = middleware
    in_hand = 1 if middleware == "ros2" else 10_000
    assert limits(model, "listener") == {"Heard": in_hand, "Noted": 10_000}
    # Nobody else puts tokens into the talker.
    assert limits(model, "talker") == {"Words": None, "Said": 1 if middleware == "ros2" else None}


def test_what_the_model_says_counts() -> None:
    model = talker()
    heard, noted = find(model, "Heard", sym.Place), find(model, "Noted", sym.Place)
    noted.capacity = 50_000
    heard.tokens = 3_000
    assert limits(model, "listener") == {"Heard": 30_000, "Noted": 50_000}
    model.channels[0].subscribers[0].inHand = -1  # type: ignore[attr-defined]
    assert limits(model, "listener") == {"Heard": None, "Noted": 50_000}
    structure = structure_of(model, "listener")
    assert dict(zip(structure.places, structure.capacities, strict=True)) == {"Heard": None, "Noted": 50_000}


def test_a_service_that_notes_its_requests() -> None:
    model = sym.SystemModel(id="shop", middleware="ros2")
    shop, user = sym.NodeNet(id="shop", net=model), sym.NodeNet(id="user", net=model)
    page = sym.CallbackPage(id="Serve", kind="server", page=shop)
    asked, answer = sym.Place(id="Asked", page=page), sym.Place(id="Answer", page=page)
    sold = sym.Place(id="Sold", page=shop)
    serve = sym.Transition(id="Sell", page=page)
    flow(asked, serve, answer)
    flow(serve, here(sold, page))
    ask, got = sym.Place(id="Ask", tokens=1, page=user), sym.Place(id="Got", page=user)
    client = sym.ClientPort(client="user", request=ask, response=got)
    server = sym.ServerPort(entry=asked, exit=answer, page=page)
    model.channels.append(sym.ServiceChannel(id="S", service="/s", server=server, clients=[client]))
    assert limits(model, "shop") == {"S[1].Asked": 10_000, "S[1].Answer": 10_000, "Sold": 10_000}
    assert set(limits(model, "user").values()) == {None}


def test_a_flood_stops_at_the_limit(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Messages wait, and are lost as the queue's limit says; the node says why, once."""
    monkeypatch.setattr(capacities, "MOST_TOKENS", 20)
    model = talker()
    find(model, "Words", sym.Place).tokens = 100
    with LocalApplication(split(model), seed=1) as application:
        speaker, listener = application.nets["talker"], application.nets["listener"]
        speaker.signal("Button").set(True)
        watch = HealthWatch(listener.core)
        while application.step():
            pass
        counts = dict(zip(listener.structure.places, map(listener.core.engine.count, (0, 1)), strict=True))
        assert counts == {"Heard": 20, "Noted": 20}
        with caplog.at_level(logging.WARNING):
            assert {each.element for each in watch.look().concerns} >= {"Noted", "Heard"}
            watch.look()
    told = [each.getMessage() for each in caplog.records]
    said = "place Noted holds 20 tokens and accepts no more; the model gives it no capacity [place-limit]"
    assert told.count(said) == 1


def test_large_messages_stop_at_a_size(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Long before there are many tokens what comes waits; it continues when some are taken."""
    monkeypatch.setattr(weights, "MOST_BYTES", 10_000)
    monkeypatch.setattr(weights, "size_of", lambda data: 1_000)
    model = talker()
    find(model, "Words", sym.Place).tokens = 100
    find(model, "listener", sym.NodeNet).signals.append(sym.InputSignal(id="Broom"))
    tidy = sym.Transition(id="Tidy", page=find(model, "OnChatter", sym.CallbackPage))
    flow(find(model, "Noted", sym.Place), tidy)
    set_clause(tidy, "Broom")
    with LocalApplication(split(model), seed=1) as application:
        speaker, listener = application.nets["talker"], application.nets["listener"]
        speaker.signal("Button").set(True)
        engine = listener.core.engine
        watch = HealthWatch(listener.core)
        while application.step():
            pass
        places = listener.structure.places
        assert {places[place] for place in engine.weights.heavy} == {"Heard", "Noted"}
        assert [engine.count(places.index(name)) for name in ("Heard", "Noted")] == [10, 10]
        assert {each.element for each in watch.look().concerns} >= {"Noted", "Heard"}
        told = [each.getMessage() for each in caplog.records]
        assert "place Noted holds 64 MiB in 10 tokens and accepts no more" in str(told)
        listener.signal("Broom").set(True)
        while application.step():
            pass
        assert not engine.weights.heavy
        assert [engine.count(place) for place in range(len(places))] == [0] * len(places)


def test_the_size_of_data() -> None:
    data: Any = {
        "text": "four",
        "list": [1, 2, 3],
        "parts": [{"a": "xy"}, {"a": "z"}],
        "rows": [[1.0], []],
        "b": True,
    }
    assert weights.size_of(data) == 4 + 24 + 3 + 8 + 8


@settings(deadline=None, max_examples=50)
@given(st.lists(st.sampled_from(["put", "fire", "take"]), max_size=60), st.sampled_from([0, 2, 5]))
def test_bytes_are_those_of_the_tokens_there(steps: list[str], few: int) -> None:
    """Whatever is put, fired and taken: bytes are those of the tokens, and at the limit there is no room."""
    structure = structure_of(talker(), "listener")
    engine = Engine(structure)
    heard, noted = structure.places.index("Heard"), structure.places.index("Noted")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(weights, "MOST_BYTES", 40)
        for module in (weights, engine_module):
            patch.setattr(module, "FEW", few)
        patch.setattr(weights, "size_of", lambda data: 10)
        for step in steps:
            if step == "put" and engine.has_room(heard):
                engine.put(heard, engine.new_token(engine.passing.checkers[heard].default))
            elif step == "fire" and engine.ready:
                engine.fire(engine.ready[0])
            elif step == "take" and engine.count(noted):
                engine.take(noted)
            for place in (heard, noted):
                is_heavy = engine.count(place) > few and 10 * engine.count(place) >= 40
                assert engine.has_room(place) is not is_heavy
                assert (place in engine.weights.heavy) is is_heavy
