"""Signals through a real MQTT broker and real HTTP, all on 127.0.0.1."""

from __future__ import annotations

import logging
import os
import time
from collections.abc import Iterator

import httpx
import pytest

from dineros.metamodel.errors import DinerosError, UnknownElementError
from dineros.runtime.bridges.mqtt import MqttSignals
from dineros.runtime.bridges.rest import RestPoll, RestServer
from dineros.runtime.bridges.values import SignalValueError, read_truth
from dineros.runtime.nodes.net import Net
from dineros.transformations.flattening.split import split
from tests.runtime.bridges.broker import PATIENCE, Broker, free_port
from tests.support.systems.talker import talker


class TestMqtt:
    def test_message_sets_signal(self, net: Net, broker: Broker) -> None:
        with MqttSignals(net, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            sources: list[object] = []
            net.on_change(lambda change: sources.append(change.fields.get("source")))
            broker.publish("talker/signals/Button", "true")
            state = net.wait_for(lambda state: state.count("Said") == 3, PATIENCE)
            assert state.signals["Button"]
            broker.publish("talker/signals/Button", '{"value": "off"}')
            net.wait_for(lambda state: not state.signals["Button"], PATIENCE)
        assert "mqtt talker/signals/Button" in sources

    def test_retained_message_counts_for_those_who_come_later(self, net: Net, broker: Broker) -> None:
        broker.publish("cell/button", "1", retain=True)
        with MqttSignals(net, {"cell/button": "Button"}, port=broker.port):
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)

    def test_nonsense_changes_nothing(
        self, net: Net, broker: Broker, caplog: pytest.LogCaptureFixture
    ) -> None:
        with MqttSignals(net, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            broker.publish("talker/signals/Button", "maybe")
            broker.publish("talker/signals/Button", "true")
            net.wait_for(lambda state: state.signals["Button"], PATIENCE)
        assert "'maybe' is not a truth value (send true or false)" in caplog.text

    def test_several_signals_at_once(self, pair: Net, broker: Broker) -> None:
        """One message changes all of them, or none."""
        topics = {"cell/door": "Button", "cell/all": ["Button", "Bell"], "cell/bell": ["Bell"]}
        seen: list[dict[str, bool]] = []
        with (
            MqttSignals(pair, topics, port=broker.port) as custom,
            MqttSignals(pair, port=broker.port) as usual,
        ):
            assert custom.wait(PATIENCE)
            assert usual.wait(PATIENCE)
            pair.on_change(
                lambda change: seen.append(dict(pair.inspect().signals)) if change.event == "signal" else None
            )
            broker.publish("cell/bell", '{"Bell": true, "Button": true}')
            broker.publish("cell/all", '{"Bell": true, "Button": "maybe"}')
            broker.publish("cell/all", '{"Bell": true, "Button": true}')
            pair.wait_for(lambda state: state.signals["Bell"], PATIENCE)
            broker.publish("talker/signals", '{"Button": "off", "Bell": 0}')
            pair.wait_for(lambda state: not state.signals["Bell"], PATIENCE)
            assert pair.inspect().sources[0].refused == 2
        assert seen == [{"Button": True, "Bell": True}] * 2 + [{"Button": False, "Bell": False}] * 2

    def test_a_signal_with_values(self, moded: Net, broker: Broker) -> None:
        with MqttSignals(moded, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            broker.publish("talker/signals/Mode", "true")
            broker.publish("talker/signals/Mode", "loud")
            moded.wait_for(lambda state: state.signals["Mode"] == "loud", PATIENCE)
            broker.publish("talker/signals", '{"Mode": "mute", "Button": true}')
            moded.wait_for(lambda state: state.signals == {"Button": True, "Mode": "mute"}, PATIENCE)
            assert moded.inspect().sources[0].refused == 1

    def test_broker_that_comes_back(self, net: Net, broker: Broker) -> None:
        with MqttSignals(net, port=broker.port) as bridge:
            assert bridge.wait(PATIENCE)
            broker.stop()
            broker.start()
            end = time.monotonic() + PATIENCE
            while not net.inspect().signals["Button"] and time.monotonic() < end:
                broker.publish("talker/signals/Button", "true")
                time.sleep(0.1)
            assert net.inspect().signals["Button"]

    def test_unknown_signal(self, net: Net) -> None:
        with pytest.raises(UnknownElementError, match="no signal 'Buton'"):
            MqttSignals(net, {"topic": "Buton"})


class TestRest:
    @pytest.fixture
    def server(self, net: Net) -> Iterator[RestServer]:
        with RestServer(net, port=0) as running:
            yield running

    def test_a_signal_with_values(self, moded: Net) -> None:
        with RestServer(moded, port=0) as server:
            url = f"{server.url}/signals/Mode"
            assert httpx.put(url, json={"value": "loud"}).json() == {"value": "loud"}
            moded.wait_for(lambda state: state.signals["Mode"] == "loud", PATIENCE)
            assert httpx.get(f"{server.url}/signals").json() == {"Button": False, "Mode": "loud"}
            for wrong in ("lout", True, None):
                assert httpx.put(url, json={"value": wrong}).status_code == 422
            answer = httpx.put(f"{server.url}/signals", json={"Button": True, "Mode": False})
            assert answer.status_code == 422 and not moded.inspect().signals["Button"]

    def test_put_sets_signal(self, net: Net, server: RestServer) -> None:
        assert httpx.get(f"{server.url}/signals").json() == {"Button": False}
        answer = httpx.put(f"{server.url}/signals/Button", json={"value": True})
        assert (answer.status_code, answer.json()) == (200, {"value": True})
        net.wait_for(lambda state: state.count("Said") == 3, PATIENCE)
        assert httpx.get(f"{server.url}/signals/Button").json() == {"value": True}
        assert httpx.put(f"{server.url}/signals/Button", content="off").json() == {"value": False}

    def test_several_signals_at_once(self, pair: Net) -> None:
        with RestServer(pair, port=0) as server:
            url = f"{server.url}/signals"
            for values, status in (
                ({"Button": True, "Bel": True}, 404),
                ({"Button": True, "Bell": None}, 422),
                ([True], 422),
                ({"Button": True, "Bell": True}, 200),
            ):
                assert httpx.put(url, json=values).status_code == status
                are_set = status == 200
                assert httpx.get(url).json() == {"Button": are_set, "Bell": are_set}

    def test_wrong_questions(self, net: Net, server: RestServer) -> None:
        answer = httpx.put(f"{server.url}/signals/Buton", json={"value": True})
        assert (answer.status_code, "no signal 'Buton'" in answer.json()["error"]) == (404, True)
        for body in ("maybe", "{", '{"value": null}', ""):
            assert httpx.put(f"{server.url}/signals/Button", content=body).status_code == 422
        assert httpx.post(f"{server.url}/signals/Button").status_code == 405
        assert not net.inspect().signals["Button"]

    def test_port_that_is_taken(self, net: Net, server: RestServer) -> None:
        port = int(server.url.rpartition(":")[2])
        with pytest.raises(DinerosError, match=f"cannot listen on 127.0.0.1:{port}"):
            RestServer(net, port=port).open()

    def test_listens_on_this_machine_only(self, server: RestServer) -> None:
        from tests.runtime.ros.sockets import bound_addresses

        assert bound_addresses(os.getpid()) <= {"127.0.0.1"}

    def test_poll(self, net: Net, server: RestServer, caplog: pytest.LogCaptureFixture) -> None:
        """One net asks another one; one that does not answer is told of once."""
        caplog.set_level(logging.WARNING)
        (part,) = (part for part in split(talker()) if part.node.id == "talker")
        with Net(part) as asking:
            url = f"{server.url}/signals/Button"
            with RestPoll(asking, {"Button": url}, period=0.02):
                net.signal("Button").set(True)
                asking.wait_for(lambda state: state.signals["Button"], PATIENCE)
                net.signal("Button").set(False)
                asking.wait_for(lambda state: not state.signals["Button"], PATIENCE)
            nobody = f"http://127.0.0.1:{free_port()}/"
            with RestPoll(asking, {"Button": nobody}, period=0.01):
                time.sleep(0.3)
            assert not asking.inspect().signals["Button"]
        assert caplog.text.count("gives no truth value") == 1


@pytest.mark.parametrize("text", ["", "2", "tru", "null", '{"value": 2}', "{}", '["true"]', b"\xff"])
def test_no_truth_value(text: str | bytes) -> None:
    with pytest.raises(SignalValueError):
        read_truth(text)
