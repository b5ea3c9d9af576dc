"""Nodes of one process under the rules of ROS 2: histories, places with capacities, what waits for room."""

from __future__ import annotations

from functools import partial
from itertools import pairwise
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.constraints import validate
from dineros.metamodel.records import Drop, read_trace, traces_of_runs
from dineros.runtime import Net, Node
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.channels.local_topics import HistoryTopic
from dineros.runtime.journal import JournalRecorder
from dineros.runtime.journal.recording import ListRecorder
from dineros.transformations.flattening.split import split
from tests.histories.test_figures import periodic
from tests.runtime.channels.test_local import Recorders, talk
from tests.runtime.tiny import events
from tests.support.ros2_systems.history_models import history_models
from tests.support.systems.small_systems import small_system_models


def histories(tokens: int, writer: int = 10, reader: int = 10, **port: object) -> sym.SystemModel:
    """Return a talker and a listener on one topic of ROS 2."""
    model = talk(tokens, publisher=writer, subscriber=reader)
    model.middleware = "ros2"
    for name, value in port.items():
        setattr(model.channels[0].subscribers[0], name, value)  # type: ignore[attr-defined]
    return model


def pair(model: sym.SystemModel) -> tuple[LocalNetwork, Node, Node, Recorders]:
    network, recorders = LocalNetwork(seed=1), Recorders()
    talker, listener = (
        Node(Net(part, seed=1), network.transport(), recorders(part.node.id)) for part in split(model)
    )
    listener.open()
    talker.open()
    return network, talker, listener, recorders


def taken(recorder: ListRecorder) -> list[int]:
    return [int(str(record["message"]).rpartition("/")[2]) for record in events(recorder, "take")]


def test_a_full_place_pauses_its_subscription_and_the_history_keeps_the_last() -> None:
    network, talker, listener, recorders = pair(histories(10, writer=4, reader=3))
    listener.net.halt("it works on nothing")
    for _ in range(40):  # everything goes as far as it can, message by message
        talker.step()
        while network.step():
            listener.step()
    assert taken(recorders["listener"]) == [1]
    listener.net.proceed()
    while any([listener.run_until_idle(), network.step()]):
        pass
    assert taken(recorders["listener"]) == [1, 8, 9, 10]
    (drop,) = events(recorders["listener"], "drop")
    assert (drop["queue"], drop["place"], drop["count"]) == ("subscriber", "heard", 6)
    kinds = [record["event"] for record in recorders["listener"].records]
    assert kinds[kinds.index("drop") + 1] == "take"  # just before the message that shows it


def test_a_writer_history_keeps_the_last() -> None:
    network, talker, listener, recorders = pair(histories(10, writer=2))
    talker.run_until_idle()  # nothing moves in between
    while any([listener.run_until_idle(), network.step()]):
        pass
    assert taken(recorders["listener"]) == [9, 10]
    assert listener.net.inspect().drops == {("topic", "subscriber"): 8}
    assert not events(recorders["talker"], "drop")


def test_ports_that_do_not_match_exchange_nothing() -> None:
    model = histories(3, qos=sym.QualityOfService(deadline=1.0))
    network, talker, listener, recorders = pair(model)
    talker.run_until_idle()
    while any([listener.run_until_idle(), network.step()]):
        pass
    assert (len(events(recorders["talker"], "publish")), taken(recorders["listener"])) == (3, [])


def test_any_number_in_hand_is_taken_at_once() -> None:
    network, talker, listener, recorders = pair(histories(9, inHand=-1))
    listener.net.halt("it works on nothing")
    for _ in range(20):
        talker.step()
        while network.step():
            listener.step()
    assert taken(recorders["listener"]) == list(range(1, 10))
    assert listener.net.count("heard") == 9


def test_a_response_waits_for_room() -> None:
    """What has no room waits where it is, and nothing is lost, under the paper's rules too."""
    model = sym.SystemModel(id="shop")
    asker, server = (sym.NodeNet(id=id, net=model) for id in ("asker", "server"))
    page = sym.CallbackPage(id="Serve", kind="server", page=server)
    wanted, other = sym.Place(id="wanted", tokens=5, page=asker), sym.Place(id="other", tokens=5, page=asker)
    asked, got = sym.Place(id="asked", page=asker), sym.Place(id="got", capacity=1, page=asker)
    used = sym.Place(id="used", page=asker)
    entry, out = sym.Place(id="entry", capacity=1, page=page), sym.Place(id="exit", page=page)
    flow(wanted, sym.Transition(id="ask", page=asker), asked)
    flow(other, sym.Transition(id="fill", page=asker), got)
    flow(got, sym.Transition(id="use", page=asker), used)
    flow(entry, sym.Transition(id="serve", page=page), out)
    sym.ServiceChannel(
        id="service",
        service="/service",
        server=sym.ServerPort(entry=entry, exit=out, page=page),
        clients=[sym.ClientPort(client="c", request=asked, response=got)],
        model=model,
    )
    assert validate(model) == []
    recorders = Recorders()
    application = LocalApplication(split(model), seed=5, recorder=recorders)
    with application:
        assert application.run(lambda app: not _check(app)) == "idle"
        assert application.count("asker", "used") == 10
    kinds = [record.get("transition", record["event"]) for record in recorders["asker"].records]
    assert any(pair == ("use", "response") for pair in pairwise(kinds))  # it had waited for that


def _check(application: LocalApplication) -> bool:
    for net in application.nets.values():
        for place, capacity in enumerate(net.structure.capacities):
            assert capacity is None or net.core.engine.count(place) <= capacity, net.structure.places[place]
    return True


@given(history_models(small_system_models()), st.integers(0, 2**20))
@settings(max_examples=25, deadline=None)
def test_no_place_ever_holds_more_than_its_capacity(model: sym.SystemModel, seed: int) -> None:
    application = LocalApplication(split(model), seed=seed)
    with application:
        for _ in range(150):
            application.step()
            _check(application)


def test_a_periodic_publisher_stays_flat() -> None:
    """Its timer is always ready; without capacities its place, and the histories, grew forever."""
    application = LocalApplication(split(periodic(2)), seed=1)
    with application:
        sizes = set()
        for _ in range(3000):
            application.step()
            _check(application)
            nets = application.nets.values()
            sizes.add(sum(net.count(place) for net in nets for place in net.structure.places))
    assert max(sizes) <= 4


def test_losses_that_are_told_later_than_they_happen_conform(tmp_path: Path) -> None:
    """A gap is told with the next message of the same publisher; others may have been taken before it."""
    model = talk(3, publisher=3, subscriber=2)
    model.middleware = "ros2"
    (topic,) = model.channels
    other = sym.NodeNet(id="other", net=model)
    words, said = sym.Place(id="OtherWords", tokens=3, page=other), sym.Place(id="OtherSaid", page=other)
    flow(words, sym.Transition(id="OtherSay", page=other), said)
    assert isinstance(topic, sym.TopicChannel)
    topic.publishers.append(sym.PublisherPort(place=said, limit=2))
    network = LocalNetwork(seed=1)
    nodes = {
        part.node.id: Node(Net(part, seed=1), network.transport(), JournalRecorder(tmp_path, part.node.id))
        for part in split(model)
    }
    for id in ("listener", "talker", "other"):
        nodes[id].open()
    (histories,) = network.topics.values()
    assert isinstance(histories, HistoryTopic)
    (reader,), writers = histories._readers, histories._writers
    (talkers,) = next(writer for key, writer in writers.items() if key.startswith("talker/")).pairs
    (others,) = next(writer for key, writer in writers.items() if key.startswith("other/")).pairs
    nodes["talker"].run_until_idle()
    talkers.pass_on()
    reader.deliver()
    nodes["listener"].run_until_idle()
    talkers.pass_on()
    for _ in range(2):
        nodes["other"].step()
        others.pass_on()
    talkers.pass_on()
    nodes["other"].run_until_idle()
    others.pass_on()
    while reader.history:
        reader.deliver()
        nodes["listener"].run_until_idle()
    for node in nodes.values():
        node.close()
    traces = {n: list(read_trace(files)) for n, files in traces_of_runs([tmp_path]).items()}
    drops = [record.count for record in traces["listener"] if isinstance(record, Drop)]
    assert drops == [1, 2]
    assert conform(model, {n: partial(iter, trace) for n, trace in traces.items()}).status == "conforms"
