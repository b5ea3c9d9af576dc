"""Servers and clients: instances, order, requests that come twice, time-outs, going on after a restart."""

from __future__ import annotations

import json
from typing import Any

import pytest

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net, Node
from dineros.runtime.channels.transport import Receiver, Transport
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.journal.saved import SavedState
from dineros.runtime.nets.ports import (
    Check,
    ClientPort,
    Data,
    Message,
    Port,
    Ports,
    PublisherPort,
    ServerPort,
)
from tests.runtime.tiny import events, token_type


def server_model(instances: int = 2, middleware: str = "ros1", depth: int = 10) -> rtm.RuntimeModel:
    """Return a node that serves: entry -> start -> run -> finish -> exit."""
    node = sym.NodeNet(id="server", name="server")
    model = rtm.RuntimeModel(
        id="m.server", systemModel="m", pages=[node], node=node, tokenType=token_type(), middleware=middleware
    )
    sym.InputSignal(id="go", node=node)
    page = sym.CallbackPage(id="page", kind="server", page=node)
    entry, run, exit_ = (rtm.Place(id=id, page=page) for id in ("entry", "run", "exit"))
    start, finish = (sym.Transition(id=id, page=page) for id in ("start", "finish"))
    flow(entry, start, run, finish, exit_)
    port = rtm.ServerPort(channel="s", service="/s", exit=exit_, page=page, instances=instances, depth=depth)
    entry.ports.append(port)
    return model


def client_model() -> rtm.RuntimeModel:
    """Return a node that asks: todo -> ask -> request ~ response -> take -> done -> tell -> said."""
    node = sym.NodeNet(id="client", name="client")
    model = rtm.RuntimeModel(id="m.client", systemModel="m", pages=[node], node=node, tokenType=token_type())
    todo, request, response, done, said = (
        rtm.Place(id=id, page=node) for id in ("todo", "request", "response", "done", "said")
    )
    todo.tokens = 3
    ask, take, tell = (sym.Transition(id=id, page=node) for id in ("ask", "take", "tell"))
    flow(todo, ask, request)
    flow(response, take, done, tell, said)
    request.ports.append(rtm.ClientPort(channel="s", service="/s", client="c", response=response))
    said.ports.append(rtm.PublisherPort(channel="t", topic="/t", limit=2))
    return model


class Wire(Transport):
    """A transport whose other end is the test."""

    def __init__(self) -> None:
        self.sent: list[tuple[str, Message]] = []
        self.fails = 0
        self.is_open = False
        self.largest: int | None = None

    def open(self, ports: Ports, receiver: Receiver) -> None:
        self.ports, self.receiver, self.is_open = ports, receiver, True

    def publish(self, port: PublisherPort, message: Message) -> bool:
        self._send(port.topic, message)
        return True

    def request(self, port: ClientPort, message: Message) -> None:
        self._send(port.service, message)

    def _send(self, name: str, message: Message) -> None:
        if self.fails:
            self.fails -= 1
            raise OSError("the cable is out")
        self.sent.append((name, message))

    def check(self, port: Port, part: str = "") -> Check | None:
        def small(data: Data) -> None:
            if data["count"] > largest:  # type: ignore[operator]
                raise ValueError("count is too large")

        largest = self.largest
        return small if largest is not None else None

    def close(self) -> None:
        self.is_open = False

    def ids(self) -> list[str]:
        return [message.id for _, message in self.sent]


class Asked:
    """Requests of the test and the responses to them."""

    def __init__(self, node: Node, wire: Wire) -> None:
        self.node, self.wire = node, wire
        self.answers: list[Message] = []

    @property
    def port(self) -> ServerPort:
        return self.wire.ports.servers[0]

    def ask(self, id: str, **data: Any) -> None:
        self.wire.receiver.request_arrived(self.port, Message(id, data), self.answers.append)
        self.node.run_until_idle()

    def answered(self) -> list[str]:
        return [message.id for message in self.answers]


def serving(
    instances: int = 2, resume: SavedState | None = None, **options: Any
) -> tuple[Net, Node, Asked, ListRecorder]:
    net, wire, recorder = Net(server_model(instances, **options)), Wire(), ListRecorder()
    node = Node(net, wire, recorder, resume=resume)
    return net, node, Asked(node, wire), recorder


def place_counts(net: Net) -> dict[str, int]:
    return {place: len(tokens) for place, tokens in net.inspect().marking.items() if tokens}


def clause_free(net: Net) -> None:
    """Let `finish` wait for the signal, by the selection."""
    net.selection(
        lambda enabled: next(
            (each for each in enabled if each.transition == "start" or net.signal("go").value), None
        )
    )


def test_each_instance_serves_one_request_and_the_oldest_waits_first() -> None:
    net, node, asked, recorder = serving()
    clause_free(net)
    node.open()
    for number, sender in enumerate("abc", start=1):
        asked.ask(f"{sender}/p/1", count=number)
    assert place_counts(net) == {"s[1].run": 1, "s[2].run": 1}
    assert net.inspect().waiting_requests == 1
    net.signal("go").set(True)
    node.run_until_idle()
    assert place_counts(net) == {}
    assert {(message.id, message.data["count"]) for message in asked.answers} == {
        ("a/p/1", 1), ("b/p/1", 2), ("c/p/1", 3)
    }  # fmt: skip
    serves = events(recorder, "serve")
    assert [(record["message"], record["instance"]) for record in serves[:2]] == [("a/p/1", 1), ("b/p/1", 2)]
    assert serves[2]["message"] == "c/p/1"
    assert len(events(recorder, "reply")) == 3
    node.close()


def test_a_request_that_comes_twice_is_served_once_and_answered_twice() -> None:
    net, node, asked, recorder = serving(instances=1)
    clause_free(net)
    node.open()
    asked.ask("a/p/1", count=1)
    asked.ask("a/p/1", count=1)  # being served
    asked.ask("b/p/1", count=2)
    asked.ask("b/p/1", count=2)  # waiting
    net.signal("go").set(True)
    node.run_until_idle()
    assert sorted(message.id for message in asked.answers) == ["a/p/1", "a/p/1", "b/p/1", "b/p/1"]
    asked.ask("a/p/1", count=1)  # done
    assert asked.answers[-1].id == "a/p/1"
    assert asked.answers[-1].data["count"] == 1
    assert len(events(recorder, "serve")) == 2
    node.close()


def test_what_comes_again_is_answered_while_all_instances_serve_others() -> None:
    """Its response was lost, and its client may be the one who ends what the instances wait for."""
    net, node, asked, recorder = serving(instances=1, middleware="ros2", depth=2)
    net.signal("go").set(True)
    clause_free(net)
    node.open()
    asked.ask("a/p/1", count=1)
    net.signal("go").set(False)
    asked.ask("b/p/1", count=2)
    assert (place_counts(net), asked.answered()) == ({"s[1].run": 1}, ["a/p/1"])
    assert asked.wire.receiver.is_open(asked.port)
    asked.ask("a/p/1", count=1)
    assert asked.answered() == ["a/p/1", "a/p/1"]
    for sender in "cde":  # the history keeps two, and what comes again takes no room in it
        asked.ask(f"{sender}/p/1", count=3)
        asked.ask("a/p/1", count=1)
    assert net.inspect().waiting_requests == 2
    assert [event["message"] for event in events(recorder, "drop")] == ["c/p/1"]
    net.signal("go").set(True)
    node.run_until_idle()
    assert [id for id in asked.answered() if id != "a/p/1"] == ["b/p/1", "d/p/1", "e/p/1"]
    node.close()


def test_the_next_request_of_a_sender_acknowledges_the_response_before() -> None:
    _, node, asked, recorder = serving(instances=1)
    node.open()
    for number in range(1, 8):
        asked.ask(f"a/p/{number}", count=number)
        asked.ask(f"b/p/{number}", count=number)
    assert list(node.checkpoint()["responses"]["s"]) == ["a/p/7", "b/p/7"]
    answers, served = len(asked.answers), len(events(recorder, "serve"))
    asked.ask("a/p/7", count=7)
    asked.ask("a/p/2", count=2)  # a late copy, which nobody waits for
    assert [message.id for message in asked.answers[answers:]] == ["a/p/7"]
    assert len(events(recorder, "serve")) == served
    node.close()


def test_a_request_that_does_not_fit_is_recorded_and_the_next_one_served() -> None:
    _, node, asked, recorder = serving(instances=1)
    node.open()
    asked.ask("a/p/1", colour="red")
    asked.ask("b/p/1", color="red")
    assert [message.id for message in asked.answers] == ["b/p/1"]
    assert "no field 'colour'" in str(events(recorder, "error")[0]["error"])
    node.close()


def asking(**options: Any) -> tuple[Net, Node, Wire, ListRecorder, list[float]]:
    now = [0.0]
    net, wire, recorder = Net(client_model(), clock=lambda: now[0]), Wire(), ListRecorder()
    return net, Node(net, wire, recorder, **options), wire, recorder, now


def test_a_client_has_one_request_under_way() -> None:
    net, node, wire, recorder, _ = asking()
    node.open()
    node.run_until_idle()
    assert wire.ids() == ["client/request/1"]
    assert place_counts(net) == {"request": 2}
    port = wire.ports.clients[0]
    wire.receiver.response_arrived(port, Message("client/request/9", {}))  # nobody waits for it
    node.run_until_idle()
    assert wire.ids() == ["client/request/1"]
    for number in (1, 2, 3):
        message = Message(f"client/request/{number}", {"count": number})
        wire.receiver.response_arrived(port, message)
        wire.receiver.response_arrived(port, message)  # comes twice, counts once
        node.run_until_idle()
    requests, said = (["client/request/1", "client/request/2", "client/request/3"], "client/said/")
    assert wire.ids() == [*requests[:2], f"{said}1", requests[2], f"{said}2", f"{said}3"]
    assert [record["message"] for record in events(recorder, "response")] == [
        f"client/request/{number}" for number in (1, 2, 3)
    ]
    node.close()


def test_a_request_without_response_is_recorded_and_sent_again_with_its_id() -> None:
    _, node, wire, recorder, now = asking(request_timeout=2.0)
    node.open()
    for _ in range(60):
        node.run_until_idle()
        now[0] += 0.1
    assert set(wire.ids()) == {"client/request/1"}
    assert len(wire.sent) == 3
    timeouts = events(recorder, "timeout")
    assert [(record["message"], record["attempt"]) for record in timeouts] == [
        ("client/request/1", 1), ("client/request/1", 2)
    ]  # fmt: skip
    wire.receiver.request_failed(
        wire.ports.clients[0], "client/request/1", "no server"
    )  # the transport knows
    node.run_until_idle()
    assert len(events(recorder, "timeout")) == 3
    wire.receiver.response_arrived(wire.ports.clients[0], Message("client/request/1", {}))
    node.run_until_idle()
    assert wire.ids()[-2:] == ["client/request/2", "client/said/1"]
    node.close()


def test_what_was_lost_is_asked_for_again_where_a_simulation_stands_still() -> None:
    now, wire = [0.0], Wire()
    net = Net(client_model(), clock=lambda: 0.0, steady=lambda: now[0])
    node = Node(net, wire)
    node.open()
    node.run_until_idle()
    assert wire.ids() == ["client/request/1"]
    wire.receiver.request_failed(wire.ports.clients[0], "client/request/1", "no response")
    node.run_until_idle()
    assert len(wire.sent) == 1
    now[0] = 0.11
    node.run_until_idle()
    assert wire.ids() == ["client/request/1"] * 2
    node.close()


def test_what_the_transport_does_not_take_stays_and_is_sent_later() -> None:
    net, node, wire, recorder, now = asking()
    wire.fails = 2
    node.open()
    node.run_until_idle()
    assert place_counts(net)["request"] == 3
    assert "the cable is out" in str(events(recorder, "error")[0]["error"])
    for _ in range(30):
        node.run_until_idle()
        now[0] += 0.1
    assert wire.ids() == ["client/request/1"]
    node.close()


def json_copy(checkpoint: SavedState) -> SavedState:
    copied: SavedState = json.loads(json.dumps(checkpoint))
    return copied


def test_a_client_goes_on_where_it_ended() -> None:
    net, node, wire, recorder, _ = asking()
    node.open()
    node.run_until_idle()
    wire.receiver.response_arrived(wire.ports.clients[0], Message("client/request/1", {"count": 4}))
    node.run_until_idle()
    saved = json_copy(node.checkpoint())
    assert json.loads(json.dumps(node.checkpoint())) == node.checkpoint()
    last = max(token.id for tokens in net.inspect().marking.values() for token in tokens)

    net, again, wire, recorder, _ = asking(resume=saved)
    again.open()
    assert json_copy(again.checkpoint()) == saved
    again.run_until_idle()
    assert wire.ids() == ["client/said/1", "client/request/2"]  # sent and asked again
    wire.receiver.response_arrived(wire.ports.clients[0], Message("client/request/2", {"count": 5}))
    again.run_until_idle()
    assert wire.ids()[2:] == ["client/request/3", "client/said/2"]
    assert events(recorder, "start")[0]["resumed"] is True
    tokens = [record["token"] for record in recorder.records if record["event"] == "response"]
    assert all(isinstance(token, int) and token > last for token in tokens)
    again.close()


def test_a_server_goes_on_where_it_ended() -> None:
    net, node, asked, _ = serving(instances=1)
    clause_free(net)
    node.open()
    asked.ask("a/p/1", count=1)
    asked.ask("b/p/7", count=2)  # waits: it was not served, so nothing depends on it
    saved = json_copy(node.checkpoint())

    net, again, asked, _ = serving(instances=1, resume=saved)
    clause_free(net)
    again.open()
    net.signal("go").set(True)
    again.run_until_idle()
    assert asked.answers == []  # nobody to tell yet
    asked.ask("a/p/1", count=1)  # the client asks again
    asked.ask("b/p/7", count=2)
    assert [(message.id, message.data["count"]) for message in asked.answers] == [("a/p/1", 1), ("b/p/7", 2)]
    again.close()


def test_a_run_that_is_not_resumed_may_have_ids_of_its_own() -> None:
    _, node, wire, _, _ = asking(run="r7")
    node.open()
    node.run_until_idle()
    assert wire.ids() == ["client@r7/request/1"]
    assert node.checkpoint()["run"] == "r7"
    node.close()


def test_a_checkpoint_of_another_model_is_refused() -> None:
    _, node, _, _ = serving()
    for key, value in {
        "marking": {"nowhere": [[1, {}]]},
        "signals": {"nothing": True},
        "serving": {"s[9].entry": "a/p/1"},
        "requests": {"s/nobody": {"message": "x/y/1", "data": {}, "attempts": 1}},
        "seen": {"t/nowhere": {"x": 1}},
    }.items():
        saved: Any = {**node.checkpoint(), key: value}
        with pytest.raises(DinerosError):
            serving(resume=saved)
    saved = {**node.checkpoint(), "marking": {"s[1].run": [[1, {"colour": 1}]]}}
    with pytest.raises(DinerosError, match="start the node again"):
        serving(resume=saved)


def test_a_response_that_cannot_be_sent_fails_where_the_handler_returns_it() -> None:
    net, node, asked, recorder = serving()
    asked.wire.largest = 127
    node.open()
    net.handler("finish")(lambda firing: {"count": 300})
    asked.ask("client/request/1")
    assert place_counts(net) == {"s[1].run": 1}
    (error,) = events(recorder, "error")
    assert (error["transition"], error["handler"]) == ("s[1].finish", "<lambda>")
    assert (error["error"], error["policy"]) == ("ValueError: count is too large", "halt")
    assert (asked.answers, events(recorder, "reply")) == ([], [])
    net.handler("finish", name="<lambda>", replace=True)(lambda firing: {"count": 3})
    net.proceed()
    node.run_until_idle()
    assert [answer.data["count"] for answer in asked.answers] == [3]
    node.close()


@pytest.mark.parametrize("is_observed", [True, False])
def test_what_is_passed_on_without_a_handler_is_checked_as_well(is_observed: bool) -> None:
    net, wire = Net(client_model()), Wire()
    wire.largest = -1
    node = Node(net, wire, ListRecorder() if is_observed else None)
    node.open()
    node.run_until_idle()
    state = net.inspect()
    assert (place_counts(net), wire.sent) == ({"todo": 3}, [])
    assert state.halted == "the firing of ask failed: ValueError: count is too large"
    assert state.errors[0].handler is None
    node.close()
