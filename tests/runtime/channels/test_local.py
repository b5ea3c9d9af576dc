"""Nodes of one process: queues with the model's limits, late subscribers, restarts, runs by a seed."""

from __future__ import annotations

import asyncio
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError
from dineros.runtime import Firing, Net, Node
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.channels.local import LocalNetwork, LocalTransport
from dineros.runtime.channels.local_topics import QueueTopic
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.ports import ClientPort, Message, ServerPort
from dineros.transformations.flattening.split import split
from tests.runtime.nets.reference_rule import references
from tests.runtime.tiny import case_study, events
from tests.support.systems.ovens import oven
from tests.support.systems.small_systems import small_system_models


def talk(
    tokens: int, publisher: int = 10, dispatcher: int = 16, subscriber: int = 10, durability: str = "volatile"
) -> sym.SystemModel:
    """Return a talker (pool -> say -> said) and a listener (heard -> note -> noted) on one topic."""
    model = sym.SystemModel(id="talk")
    talker, listener = (sym.NodeNet(id=id, name=id, net=model) for id in ("talker", "listener"))
    pool, said = sym.Place(id="pool", tokens=tokens, page=talker), sym.Place(id="said", page=talker)
    heard, noted = sym.Place(id="heard", page=listener), sym.Place(id="noted", page=listener)
    flow(pool, sym.Transition(id="say", page=talker), said)
    flow(heard, sym.Transition(id="note", page=listener), noted)
    sym.TopicChannel(
        id="topic",
        topic="/topic",
        publishers=[sym.PublisherPort(place=said, limit=publisher)],
        subscribers=[sym.SubscriberPort(place=heard, limit=subscriber)],
        dispatchers=[sym.Dispatcher(node=listener, limit=dispatcher)],
        qos=sym.QualityOfService(durability=durability),
        model=model,
    )
    return model


class Recorders(dict[str, ListRecorder]):
    """A recorder for each node."""

    def __call__(self, node: str) -> ListRecorder:
        return self.setdefault(node, ListRecorder())


def pair(model: sym.SystemModel) -> tuple[LocalNetwork, Node, Node, Recorders]:
    network, recorders = LocalNetwork(seed=1), Recorders()
    talker, listener = (
        Node(Net(part, seed=1), network.transport(), recorders(part.node.id)) for part in split(model)
    )
    listener.open()
    talker.open()
    return network, talker, listener, recorders


def queue_topic(network: LocalNetwork) -> QueueTopic:
    topic = network.topics["topic"]
    assert isinstance(topic, QueueTopic)
    return topic


def test_the_publishers_queue_drops_the_newest() -> None:
    _, talker, _, recorders = pair(talk(5, publisher=3))
    talker.run_until_idle()  # nothing moves in between
    assert len(events(recorders["talker"], "publish")) == 3
    drops = events(recorders["talker"], "drop")
    assert [(d["queue"], d["place"], d["count"], d["change"]) for d in drops] == [
        ("publisher", "said", 1, {"said": -1})
    ] * 2
    assert dict(talker.net.inspect().drops) == {("topic", "publisher"): 2}


def test_the_dispatchers_queue_drops_the_newest() -> None:
    network, talker, listener, recorders = pair(talk(5, dispatcher=2))
    talker.run_until_idle()
    topic = queue_topic(network)
    queue = topic._queues["talker/said"]
    while queue.waiting:
        topic._spread(queue)
    while network.step():
        pass
    listener.run_until_idle()
    assert listener.net.count("noted") == 2
    assert dict(listener.net.inspect().drops) == {("topic", "dispatcher"): 3}
    assert [r["message"] for r in events(recorders["listener"], "take")] == ["talker/said/1", "talker/said/2"]


def test_the_subscribers_queue_drops_the_newest() -> None:
    network, talker, listener, recorders = pair(talk(5, subscriber=2))
    talker.run_until_idle()
    while network.step():  # the listener does not come round to it
        pass
    listener.run_until_idle()
    assert listener.net.count("noted") == 2
    (drop,) = events(recorders["listener"], "drop")
    assert (drop["queue"], drop["place"], drop["count"]) == ("subscriber", "heard", 3)
    assert dict(listener.net.inspect().drops) == {("topic", "subscriber"): 3}


def test_losses_are_recorded_in_their_order_and_before_what_makes_room() -> None:
    """Otherwise the queues would not have been full when they dropped something."""
    network, talker, listener, recorders = pair(talk(3, dispatcher=1, subscriber=1))
    talker.run_until_idle()
    topic = queue_topic(network)
    queue, dispatcher = topic._queues["talker/said"], topic._dispatchers["listener"]
    topic._spread(queue)
    dispatcher.dispatch()  # the first waits for the listener
    topic._spread(queue)  # the second in the dispatcher's queue
    topic._spread(queue)
    dispatcher.dispatch()
    listener.run_until_idle()
    records = [record for record in recorders["listener"].records if record["event"] in ("drop", "take")]
    assert [record.get("queue", record["event"]) for record in records] == [
        "dispatcher",
        "subscriber",
        "take",
    ]


def test_losses_on_the_way_are_recorded() -> None:
    _, _, listener, recorders = pair(talk(0))
    port = listener.net.structure.ports.subscribers[0]
    listener.receiver.message_arrived(port, Message("talker/said/4", {}), 3)
    listener.run_until_idle()
    (drop,) = events(recorders["listener"], "drop")
    assert (drop["queue"], drop["count"]) == ("subscriber", 3)


def test_a_message_that_comes_again_is_ignored() -> None:
    _, _, listener, recorders = pair(talk(0))
    port = listener.net.structure.ports.subscribers[0]
    for id in ("a/said/1", "a/said/2", "a/said/1", "a/said/2", "b/said/1", "", ""):
        listener.receiver.message_arrived(port, Message(id, {}), 0)
    listener.run_until_idle()
    taken = [record["message"] for record in events(recorders["listener"], "take")]
    assert taken == ["a/said/1", "a/said/2", "b/said/1", "", ""]  # who gives no ids is not recognised


@pytest.mark.parametrize("type", [None, "std_msgs/msg/Empty"])
def test_a_restarted_subscriber_gets_what_it_missed_once(type: str | None) -> None:
    model = talk(6, durability="volatile" if type else "transientLocal")
    model.channels[0].type = type
    network, talker, listener, _ = pair(model)
    for _ in range(3):
        talker.step()
        while network.step():
            pass
    listener.run_until_idle()
    assert listener.net.count("noted") == 3
    saved = listener.checkpoint()
    listener.close()
    talker.run_until_idle()
    while network.step():
        pass
    recorder = ListRecorder()
    part = next(part for part in split(model) if part.node.id == "listener")
    again = Node(Net(part, seed=1), network.transport(), recorder, resume=saved)
    again.open()
    while again.step() or network.step():
        pass
    assert again.net.count("noted") == 6
    taken = [record["message"] for record in events(recorder, "take")]
    assert taken == [f"talker/said/{n}" for n in (4, 5, 6)]


def test_a_volatile_topic_keeps_nothing_for_late_subscribers() -> None:
    network, talker, listener, _ = pair(talk(3))
    listener.close()
    talker.run_until_idle()
    while network.step():
        pass
    late = Node(Net(split(talk(3))[1]), network.transport())
    late.open()
    while late.step() or network.step():
        pass
    assert late.net.count("noted") == 0


def ask_model() -> sym.SystemModel:
    """Return a client with three things to ask and a server with two instances."""
    model = sym.SystemModel(id="asking")
    client, server = (sym.NodeNet(id=id, name=id, net=model) for id in ("client", "server"))
    todo, request, response, done = (
        sym.Place(id=id, page=client) for id in ("todo", "request", "response", "done")
    )
    todo.tokens = 3
    flow(todo, sym.Transition(id="ask", page=client), request)
    flow(response, sym.Transition(id="take", page=client), done)
    page = sym.CallbackPage(id="page", kind="server", page=server)
    entry, exit_ = sym.Place(id="entry", page=page), sym.Place(id="exit", page=page)
    flow(entry, sym.Transition(id="serve", page=page), exit_)
    sym.ServiceChannel(
        id="service",
        service="/service",
        server=sym.ServerPort(entry=entry, exit=exit_, page=page),
        clients=[sym.ClientPort(client="c", request=request, response=response)],
        instances=2,
        model=model,
    )
    return model


def test_a_server_that_comes_back_serves_what_was_asked() -> None:
    client_part, server_part = split(ask_model())
    network = LocalNetwork(seed=3)
    client = Node(Net(client_part), network.transport())
    server = Node(Net(server_part), network.transport())
    server.open()
    client.open()
    client.run_until_idle()
    while network.step():
        pass
    server.close()  # the request has reached it and is lost with it
    while network.step():
        pass
    again = Node(Net(split(ask_model())[1]), network.transport())
    again.open()
    while client.step() or again.step() or network.step():
        pass
    assert client.net.count("done") == 3


def test_a_service_has_one_server() -> None:
    """A second one is closed again, and takes nothing from the first one."""
    client_part, server_part = split(ask_model())
    network = LocalNetwork()
    server = Node(Net(server_part), network.transport())
    server.open()
    recorder = ListRecorder()
    second = Node(Net(split(ask_model())[1]), network.transport(), recorder)
    with pytest.raises(DinerosError, match="two nodes serve"):
        second.open()
    assert [record["event"] for record in recorder.records] == ["start", "stop"]
    assert recorder.records[-1]["reason"] == "failure"
    client = Node(Net(client_part), network.transport())
    client.open()
    while client.step() or server.step() or network.step():
        pass
    assert client.net.count("done") == 3


def trace(seed: int) -> list[tuple[str, Any, Any]]:
    recorders = Recorders()
    application = LocalApplication(split(case_study()), seed=seed, recorder=recorders)
    application.nets["sensorics"].signal("Sensor").set(True)
    application.nets["selector"].signal("Red").set(True)
    with application:
        application.run(lambda each: False, timeout=0.2)
    return [
        (node, record["event"], record.get("transition", record.get("message")))
        for node, recorder in recorders.items()
        for record in recorder.records
    ]


def test_the_same_seed_gives_the_same_run() -> None:
    assert trace(4) == trace(4)
    assert trace(4) != trace(5)
    assert len(trace(4)) > 20


def test_a_run_ends_when_nothing_can_happen_or_time_is_over() -> None:
    application = LocalApplication(split(talk(3)), seed=1)
    with application:
        assert application.run(lambda each: each.count("listener", "noted") == 3, timeout=60) == "reached"
        assert application.run(lambda each: False) == "idle"
        application.every(0.5, lambda seconds: None)
    ticks: list[float] = []
    application = LocalApplication(split(talk(3)), seed=1)
    application.every(0.5, ticks.append)
    with application:
        assert application.run(lambda each: False, timeout=10.2) == "timeout"
    assert ticks == [0.5] * 20


@pytest.mark.long
@given(small_system_models(), st.integers(0, 2**32))
@settings(max_examples=15)
def test_every_node_of_a_local_run_follows_the_plain_rule(model: sym.SystemModel, seed: int) -> None:
    parts = references(model)
    recorders = Recorders()
    application = LocalApplication([part for part, _ in parts], seed=seed, recorder=recorders)
    with application:
        for _ in range(200):
            if not application.step():
                break
    for part, reference in parts:
        for record in recorders[part.node.id].records:
            change = record.get("change")
            if record["event"] == "fire":
                reference.fire(str(record["transition"]))
            elif isinstance(change, dict):
                for place, difference in change.items():
                    reference.marking[place] += difference
                    assert reference.marking[place] >= 0
        net = application.nets[part.node.id]
        assert {place: net.count(place) for place in net.structure.places} == dict(reference.marking)


def test_on_threads_with_asynchronous_handlers() -> None:
    application = LocalApplication(split(ask_model()), seed=1, simulated_time=False)
    together, most = [0], [0]

    @application.nets["server"].handler("serve")
    async def serve(firing: Firing) -> dict[str, object]:
        together[0] += 1
        most[0] = max(most[0], together[0])
        await asyncio.sleep(0.01)
        together[0] -= 1
        return {}

    with application:
        application.nets["client"].wait_for(lambda state: state.count("done") == 3, timeout=30)
    assert most[0] == 1  # the client has one request under way


def test_stepped_with_asynchronous_handlers() -> None:
    application = LocalApplication(split(ask_model()), seed=1)

    @application.nets["server"].handler("serve")
    async def serve(firing: Firing) -> None:
        await asyncio.sleep(0.01)

    with application:
        assert application.run(lambda each: each.count("client", "done") == 3, timeout=60) == "reached"


class Taken:
    """A server, as the network sees it, that has taken some requests before."""

    def __init__(self, known: set[str]) -> None:
        self.known, self.came = known, list[str]()

    def messages_skipped(self, port: object, message: object) -> int:
        return 0

    def knows_request(self, port: object, message_id: str) -> bool:
        return message_id in self.known

    def request_arrived(self, port: object, message: Message, answer: object) -> None:
        self.came.append(message.id)

    def requests_wait(self, port: object) -> None: ...


@pytest.mark.parametrize("is_late", [False, True], ids=["server first", "clients first"])
def test_a_request_that_the_server_has_takes_no_room_when_it_comes_again(is_late: bool) -> None:
    """After a restart, all clients ask again: one of them what is being baked, in a history of one."""
    nodes = {str(part.node.id): Net(part).structure.ports for part in split(oven(2, depth=1))}
    network, server = LocalNetwork(seed=1), Taken({"baker0/Ask0/1"})
    transport = network.transport()
    ports = nodes.pop("oven")
    if not is_late:
        network.join(ports, server)  # type: ignore[arg-type]
    for name, each in reversed(nodes.items()):
        transport.request(each.clients[0], Message(f"{name}/Ask{name[-1]}/1", {}))
    if is_late:
        network.join(ports, server)  # type: ignore[arg-type]
    for _ in range(9):
        network.step()
    assert server.came == ["baker0/Ask0/1"]
    assert transport.lost_requests(ports.servers[0]) == []
    lost, taken = transport.take_request(ports.servers[0])
    assert lost == [] and taken is not None and taken[0].id == "baker1/Ask1/1"


class Hasty(LocalTransport):
    """Requests of two clients arrive in the moment in which the server has just looked what was lost."""

    asking: tuple[ClientPort, ...] = ()

    def lost_requests(self, port: ServerPort) -> list[str]:
        """Look, and have the requests arrive."""
        lost = super().lost_requests(port)
        asking, self.asking = self.asking, ()
        for client in asking:
            self.request(client, Message(f"{client.client}/1", {}))
        return lost


def test_a_request_is_lost_before_the_one_is_served_that_pushed_it_out() -> None:
    parts = list(split(oven(2, depth=1)))
    network, recorder = LocalNetwork(seed=1), ListRecorder()
    transport = Hasty(network)
    clients = [port for part in parts for port in Net(part).structure.ports.clients]
    part = next(part for part in parts if part.node.id == "oven")
    server = Node(Net(part, seed=1), transport, recorder)
    transport.asking = tuple(clients)
    server.open()
    server.run_until_idle()
    network.step()
    server.run_until_idle()
    said = [(e["event"], e["message"]) for e in recorder.records if e["event"] in ("drop", "serve")]
    assert said == [("drop", f"{clients[0].client}/1"), ("serve", f"{clients[1].client}/1")]
    server.close()
