"""Clients with several requests under way, and clients that give up: with and without a restart."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from dineros.metamodel import rtm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError
from dineros.runtime import Net, Node
from dineros.runtime.channels.services import KEPT_RESPONSES
from dineros.runtime.journal import JournalRecorder, rebuild_at
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.ports import ClientPort, Message
from dineros.transformations.flattening.split import split
from tests.runtime.channels.test_services import Asked, Wire, place_counts, server_model
from tests.runtime.tiny import events, token_type
from tests.support.systems.ovens import oven


class Forgetful(Wire):
    """A transport that is told what is given up."""

    def __init__(self) -> None:
        super().__init__()
        self.forgotten: list[str] = []

    def forget(self, port: ClientPort, message_id: str) -> None:
        self.forgotten.append(message_id)


def asking_model(tells: str = "late", **features: Any) -> rtm.RuntimeModel:
    """Return a node that asks five times: todo -> ask -> request ~ response; it gives up to `late`."""
    node = sym.NodeNet(id="client", name="client")
    model = rtm.RuntimeModel(
        id="m.client", systemModel="m", middleware="ros2", pages=[node], node=node, tokenType=token_type()
    )
    todo, request, response, late, told = (
        rtm.Place(id=id, page=node) for id in ("todo", "request", "response", "late", "told")
    )
    todo.tokens = 5
    flow(todo, sym.Transition(id="ask", page=node), request)
    flow(late, sym.Transition(id="hear", page=node), told)
    port = rtm.ClientPort(channel="s", service="/s", client="c", response=response, **features)
    port.timedOut = {"late": late, "request": request, "response": response}.get(tells)
    request.ports.append(port)
    return model


class Asking:
    """A node that asks, by a clock of the test."""

    def __init__(self, model: rtm.RuntimeModel, now: float = 0.0, **options: Any) -> None:
        self.now = now
        self.net, self.wire = Net(model, clock=lambda: self.now), Forgetful()
        self.recorder = options.pop("recorder", None) or ListRecorder()
        self.node = Node(self.net, self.wire, self.recorder, **options)
        self.node.open()
        self.node.run_until_idle()

    def wait(self, seconds: float) -> None:
        self.now += seconds
        self.node.run_until_idle()

    def answer(self, *numbers: int, **data: Any) -> None:
        for number in numbers:
            message = Message(f"client/request/{number}", data)
            self.wire.receiver.response_arrived(self.wire.ports.clients[0], message)
            self.node.run_until_idle()

    def ids(self) -> list[int]:
        return [int(id.rpartition("/")[2]) for id in self.wire.ids()]


def test_as_many_requests_are_under_way_as_the_model_says() -> None:
    """Responses come in any order, each to its own request."""
    client = Asking(asking_model(outstanding=3))
    assert client.ids() == [1, 2, 3]
    client.answer(2, 2, count=7)
    assert client.ids() == [1, 2, 3, 4]
    client.answer(9)  # nobody waits for it
    client.answer(4, 1)
    assert client.ids() == [1, 2, 3, 4, 5]
    responses = events(client.recorder, "response")
    assert [record["message"][-1] for record in responses] == ["2", "4", "1"]  # type: ignore[index]
    assert place_counts(client.net) == {"response": 3}
    client.node.close()


def test_a_request_is_given_up_when_its_own_time_is_over() -> None:
    client = Asking(asking_model(outstanding=2, timeout=5.0))
    client.wait(3.0)
    client.answer(1)
    assert client.ids() == [1, 2, 3]  # the third was asked 3 s later
    client.wait(2.5)
    assert client.wire.forgotten == ["client/request/2"]
    assert client.ids() == [1, 2, 3, 4]
    client.answer(2)  # too late
    assert place_counts(client.net) == {"response": 1, "told": 1, "request": 1}
    client.wait(2.6)
    (first, second) = events(client.recorder, "giveUp")
    assert (first["message"], first["place"], first["change"]) == ("client/request/2", "late", {"late": 1})
    assert (second["message"], second["client"]) == ("client/request/3", "c")
    client.wait(100.0)
    assert len(events(client.recorder, "giveUp")) == 4
    assert place_counts(client.net) == {"response": 1, "told": 4}
    client.node.close()


@pytest.mark.parametrize(
    ("tells", "counts"),
    [("", {}), ("response", {"response": 5}), ("request", {"request": 4})],
)
def test_what_is_given_up_goes_where_the_model_says(tells: str, counts: dict[str, int]) -> None:
    """To no place, to that of the responses, or it is asked again: with what was asked."""
    client = Asking(asking_model(tells, timeout=1.0))
    for _ in range(5):
        client.wait(1.1)
    assert place_counts(client.net) == counts
    assert client.ids() == [1, 2, 3, 4, 5] + [6] * (tells == "request")
    assert len(events(client.recorder, "giveUp")) == 5
    client.node.close()


def test_the_token_carries_what_was_asked() -> None:
    model = asking_model("request", timeout=1.0)
    net = Net(model, clock=lambda: now[0])
    now, wire = [0.0], Wire()

    @net.handler("ask")
    def ask(firing: Any) -> dict[str, object]:
        return {"count": 42}

    node = Node(net, wire)
    node.open()
    node.run_until_idle()
    now[0] = 1.5
    node.run_until_idle()
    assert [message.data["count"] for _, message in wire.sent] == [42, 42]
    node.close()


def test_it_asks_again_until_it_gives_up() -> None:
    client = Asking(asking_model(timeout=5.0), request_timeout=1.0)
    for _ in range(49):
        client.wait(0.1)
    assert client.ids()[:4] == [1, 1, 1, 1]
    client.wait(0.2)
    asked = client.ids().count(1)
    client.wait(0.5)
    assert client.ids().count(1) == asked
    assert 2 in client.ids()
    client.node.close()


def test_a_time_out_waits_for_room() -> None:
    """While its place is full, the response may still come."""
    model = asking_model("late", outstanding=2, timeout=1.0)
    late = next(place for place in model.node.objects if place.id == "late")
    hear = next(each for each in model.node.objects if each.id == "hear")
    assert isinstance(late, rtm.Place)
    assert isinstance(hear, sym.Transition)
    late.capacity = 1
    gate = sym.Place(id="gate", page=model.node)
    flow(gate, hear)
    client = Asking(model)
    client.wait(1.5)
    assert place_counts(client.net)["late"] == 1
    assert len(events(client.recorder, "giveUp")) == 1
    client.answer(2)
    assert place_counts(client.net)["response"] == 1
    assert [record["message"][-1] for record in events(client.recorder, "response")] == ["2"]  # type: ignore[index]
    client.node.close()


def test_requests_keep_their_ages_over_a_restart(tmp_path: Path) -> None:
    """A checkpoint has them by the node's clock, a rebuilt state by the times of the records."""
    model = asking_model(outstanding=3, timeout=5.0)
    client = Asking(model, recorder=JournalRecorder(tmp_path, "client"))
    client.wait(2.0)
    client.answer(1)
    client.wait(1.0)
    checkpoint = client.node.checkpoint()
    ages = {each["message"][-1]: each["age"] for each in checkpoint["requests"]["s/c"]}
    assert ages == {"2": 3.0, "3": 3.0, "4": 1.0}
    rebuilt = rebuild_at(tmp_path, "client").checkpoint()
    assert [each["message"] for each in rebuilt["requests"]["s/c"]] == [
        each["message"] for each in checkpoint["requests"]["s/c"]
    ]
    client.node.close()

    again = Asking(model, now=1000.0, resume=checkpoint)
    assert again.ids() == [2, 3, 4]  # asked again
    again.wait(1.9)
    assert again.wire.forgotten == []
    again.wait(0.2)
    assert again.wire.forgotten == ["client/request/2", "client/request/3"]
    assert again.ids() == [2, 3, 4, 5]
    again.wait(2.0)
    assert again.wire.forgotten[2:] == ["client/request/4"]
    again.node.close()


def test_the_times_of_records_tell_how_old_a_request_is(tmp_path: Path) -> None:
    client = Asking(asking_model(outstanding=2, timeout=5.0), recorder=JournalRecorder(tmp_path, "client"))
    client.node.close()
    path = tmp_path / "client.jsonl"
    lines = [json.loads(line) for line in path.read_text().splitlines()]
    for line in lines:
        line.pop("crc", None)
        if "time" in line:
            line["time"] = {"request": 100.0, "stop": 103.5}.get(line["event"], 99.0)
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    requests = rebuild_at(tmp_path, "client").checkpoint()["requests"]["s/c"]
    assert [each["age"] for each in requests] == [3.5, 3.5]


def test_checkpoints_of_earlier_versions_have_one_request(tmp_path: Path) -> None:
    client = Asking(asking_model(timeout=5.0))
    checkpoint = client.node.checkpoint()
    client.node.close()
    (request,) = checkpoint["requests"]["s/c"]
    del request["age"]  # type: ignore[misc]
    checkpoint["requests"] = {"s/c": request}  # type: ignore[dict-item]
    again = Asking(asking_model(timeout=5.0), resume=checkpoint)
    assert again.ids() == [1]
    again.node.close()
    checkpoint["requests"] = {"s/c": [7]}  # type: ignore[list-item]
    with pytest.raises(DinerosError, match="a malformed request"):
        Asking(asking_model(timeout=5.0), resume=checkpoint)


def test_a_server_keeps_responses_to_all_requests_of_a_client() -> None:
    """One that comes again is answered again, whatever came in between."""
    model = server_model()
    model.middleware = "ros2"
    entry = next(element for element in model.eAllContents() if isinstance(element, rtm.ServerPort))
    entry.outstanding = 3
    net, wire, recorder = Net(model), Wire(), ListRecorder()
    node = Node(net, wire, recorder)
    net.signal("go").set(True)
    asked = Asked(node, wire)
    node.open()
    for number in range(1, KEPT_RESPONSES + 1):
        asked.ask(f"a/p/{number}", count=number)
    asked.answers.clear()
    asked.ask("a/p/1", count=1)
    assert [(answer.id, answer.data["count"]) for answer in asked.answers] == [("a/p/1", 1)]
    assert len(events(recorder, "serve")) == KEPT_RESPONSES
    saved = node.checkpoint()
    assert len(saved["responses"]["s"]) == KEPT_RESPONSES
    assert saved["kept_responses"] == {"s": KEPT_RESPONSES + 3}
    node.close()


def test_a_full_history_forgets_the_oldest_request() -> None:
    model = server_model(1)
    model.middleware = "ros2"
    port = next(element for element in model.eAllContents() if isinstance(element, rtm.ServerPort))
    port.depth = 2
    net, wire, recorder = Net(model), Wire(), ListRecorder()
    net.selection(lambda enabled: None)  # the instance works forever
    node = Node(net, wire, recorder)
    asked = Asked(node, wire)
    node.open()
    for sender in "abcd":
        asked.ask(f"{sender}/p/1")
    (drop,) = events(recorder, "drop")
    assert (drop["queue"], drop["message"], drop["count"]) == ("request", "b/p/1", 1)
    assert net.inspect().waiting_requests == 2
    assert net.inspect().drops == {("s", "request"): 1}
    node.close()


def test_the_runtime_model_says_how_a_service_is_asked() -> None:
    model = oven(2, 3, outstanding=2, timeout=0.5, tells=True)
    ports = {part.node.id: Net(part).structure.ports for part in split(model)}
    (client,), (server,) = ports["baker1"].clients, ports["oven"].servers
    assert (client.outstanding, client.timeout, client.timed_out) == (2, 0.5, "Late1")
    assert (server.depth, server.outstanding) == (3, 2)
    model.middleware = "ros1"
    ports = {part.node.id: Net(part).structure.ports for part in split(model)}
    (client,), (server,) = ports["baker1"].clients, ports["oven"].servers
    assert (client.outstanding, client.timeout, client.timed_out) == (1, None, None)
    assert server.outstanding == 1
