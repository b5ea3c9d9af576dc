"""Nodes that continue after their process has died, with all that was on its way in it."""

from __future__ import annotations

import random
import threading
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Literal

import pytest

from dineros.analysis.conformance import Verdict, conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.records import Drop, Take, read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.channels.transport import Transport
from dineros.runtime.firing.handlers import Firing
from dineros.runtime.journal import resume_journal
from dineros.runtime.journal.kept import KeepError, Memory
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.ports import Message, PublisherPort
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from dineros.transformations.flattening.split import split
from tests.runtime.channels.test_local import talk
from tests.support.systems.talker import talker


def part(id: str, model: sym.SystemModel | None = None) -> Net:
    return Net(next(each for each in split(model or talker()) if each.node.id == id), seed=1)


def node(folder: Path, id: str, network: LocalNetwork, **options: Any) -> Node:
    """Return a node that continues from its journal, where it has one."""
    recorder, checkpoint = resume_journal(folder, id)
    made = Node(part(id), network.transport(), recorder, resume=checkpoint, **options)
    made.open()
    return made


def test_what_was_on_its_way_when_everything_died_comes_once(tmp_path: Path) -> None:
    """The queue dies with the process of its node; what is published again comes to those who lack it."""
    network = LocalNetwork(seed=1)
    talks = node(tmp_path, "talker", network)
    talks.net.signal("Button").set(True)
    talks.run_until_idle()  # all is said, nothing has been moved by the network
    talks.close()
    for _ in range(2):  # the second time, the listener has all of it
        network = LocalNetwork(seed=1)
        listens, talks = node(tmp_path, "listener", network), node(tmp_path, "talker", network)
        while listens.step() or talks.step() or network.step():
            pass
        assert listens.net.count("Noted") == 3
        listens.close()
        talks.close()


def test_only_what_the_queue_holds_is_sent_again(tmp_path: Path) -> None:
    sent: list[str] = []

    class Wire(Transport):
        def open(self, ports: object, receiver: object) -> None: ...
        def close(self) -> None: ...
        def request(self, port: object, message: Message) -> None: ...

        def publish(self, port: PublisherPort, message: Message) -> bool:
            sent.append(message.id)
            return True

    model = talker()
    (channel,) = (each for each in model.channels if isinstance(each, sym.TopicChannel))
    channel.publishers[0].limit = 2
    for _ in range(2):
        recorder, checkpoint = resume_journal(tmp_path, "talker")
        made = Node(part("talker", model), Wire(), recorder, resume=checkpoint)
        made.open()
        made.net.signal("Button").set(True)
        made.run_until_idle()
        made.close()
    numbers = [id.rpartition("/")[2] for id in sent]
    assert numbers == ["1", "2", "3", "2", "3"]


def test_a_handler_keeps_a_value_over_a_restart(tmp_path: Path) -> None:
    """It changes with the firing or not at all."""
    network = LocalNetwork()

    def count(firing: Firing) -> None:
        firing.memory["said"] = firing.memory.value("said", 0) + 1
        firing.memory["last"] = {"id": firing.id}
        if firing.memory["said"] == 3:
            raise RuntimeError("not the third time")

    for expected in (2, 2):
        recorder, checkpoint = resume_journal(tmp_path, "talker")
        net = part("talker")
        net.handler("Say")(count)
        made = Node(net, network.transport(), recorder, resume=checkpoint)
        made.open()
        net.signal("Button").set(True)
        made.run_until_idle()
        assert made.checkpoint()["kept"] == {"said": expected, "last": {"id": "Say"}}
        made.close()


@pytest.mark.parametrize("value", [object(), float("nan"), {1, 2}])
def test_only_json_is_kept(value: Any, tmp_path: Path) -> None:
    net = part("talker")

    @net.handler("Say")
    def keep(firing: Firing) -> None:
        firing.memory["it"] = value

    made = Node(net, LocalNetwork().transport())
    made.open()
    net.signal("Button").set(True)
    made.run_until_idle()
    assert "'it' cannot be stored" in net.inspect().errors[0].error
    made.close()


def test_a_node_that_settles_ends_what_it_has_begun(tmp_path: Path) -> None:
    """No firing begins any more, a handler elsewhere ends, and what it puts is published."""
    begun, may_end = threading.Event(), threading.Event()
    network = LocalNetwork()
    net = part("talker")

    @net.handler("Say", thread=True)
    def say(firing: Firing) -> None:
        begun.set()
        may_end.wait(10)

    recorder = ListRecorder()
    made = Node(net, network.transport(), recorder)
    made.start()
    net.signal("Button").set(True)
    assert begun.wait(10)
    threading.Timer(0.2, may_end.set).start()
    assert made.settle(10)
    made.stop()
    events = [record["event"] for record in recorder.records]
    assert events == ["start", "signal", "fire", "publish", "stop"]


def test_what_is_kept_has_the_type_that_is_asked_for() -> None:
    memory = Memory({"times": 3, "name": "cup", "list": [1]})
    assert (memory.value("times", 0), memory.value("times", 0.5), memory.value("no", "x")) == (3, 3.0, "x")
    with pytest.raises(KeepError, match="'name' is stored as 'cup', not as int"):
        memory.value("name", 0)
    memory["list"].append(2)  # a copy
    del memory["name"]
    assert dict(memory) == {"times": 3, "list": [1]}
    assert memory.changes == {"name": None}


@pytest.mark.parametrize("steps", range(8, 38, 3))
def test_what_is_sent_again_is_lost_and_told_as_ever(steps: int, tmp_path: Path) -> None:
    """A small reader history loses what two publishers send again: told once, and conforming."""
    model = two_talkers()
    for life in range(2):
        found = {name: resume_journal(tmp_path, name) for name in ("a", "b", "listener")}
        application = LocalApplication(
            split(model),
            seed=steps + life,
            recorder=lambda name, found=found: found[name][0],  # type: ignore[misc]
            resume={name: state for name, (_, state) in found.items() if state is not None},
        )
        application.open()
        for _ in range(1000 if life else steps):
            if not application.step():
                break
        application.close()
    parts = traces_of_runs([tmp_path])
    records = [record for each in parts.values() for record in read_trace(each)]
    heard = [record.message for record in records if isinstance(record, Take)]
    dropped = sum(record.count for record in records if isinstance(record, Drop))
    assert len(heard) == len(set(heard))
    assert len(heard) + dropped <= 8
    assert dropped
    verdict = conform(model, {name: partial(read_trace, each) for name, each in parts.items()})
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


def two_talkers() -> sym.SystemModel:
    """Return two nodes that say four words each, and a third that keeps one."""
    model = sym.SystemModel(id="talkers", middleware="ros2")
    words = sym.TopicChannel(id="Words", topic="/words", model=model)
    for name in "ab":
        net = sym.NodeNet(id=name, net=model)
        said = sym.Place(id=f"Said.{name}", page=net)
        flow(
            sym.Place(id=f"Know.{name}", tokens=4, page=net), sym.Transition(id=f"Say.{name}", page=net), said
        )
        words.publishers.append(sym.PublisherPort(place=said, limit=5))
    page = sym.CallbackPage(id="OnWord", page=sym.NodeNet(id="listener", net=model))
    heard = sym.Place(id="Heard", page=page)
    flow(heard, sym.Transition(id="Note", page=page), sym.Place(id="Noted", page=page))
    words.subscribers.append(sym.SubscriberPort(place=heard, limit=1))
    return model


@pytest.mark.parametrize("seed", range(6))
def test_what_was_under_way_and_is_not_sent_again_is_told_as_lost(tmp_path: Path, seed: int) -> None:
    """Both ends die with more under way than the publisher keeps, which histories of ROS 2 may lose."""
    model = talk(30, publisher=1, subscriber=1)
    model.middleware = "ros2"
    draw = random.Random(seed)
    for _ in range(3):
        network, ends = LocalNetwork(seed=seed), []
        for id in ("listener", "talker"):
            recorder, checkpoint = resume_journal(tmp_path, id)
            made = Node(part(id, model), network.transport(), recorder, resume=checkpoint)
            made.open()
            ends.append(made)
        for _ in range(40):
            draw.choice([ends[0].step, ends[1].step, ends[1].step, network.step])()
        for made in ends:
            made.close()
    traces = {n: list(read_trace(files)) for n, files in traces_of_runs([tmp_path]).items()}

    def verdict_on(queue: Literal["subscriber", "restart"], more: int = 0) -> Verdict:
        """Replay the losses as they are told where only the publisher ended, or by some more at the last."""
        told = list(traces["listener"])
        drops = {number: each for number, each in enumerate(told) if isinstance(each, Drop)}
        for number, each in drops.items():
            extra = more if number == max(drops) else 0
            told[number] = replace(each, queue=queue, count=each.count + extra)
        return conform(model, {"talker": partial(iter, traces["talker"]), "listener": partial(iter, told)})

    assert (verdict_on("subscriber").status, verdict_on("restart").status) == ("conforms", "conforms")
    (deviation, *_) = verdict_on("restart", 20).violations
    assert deviation.reason.startswith("the publisher was restarted, and had sent more messages")
