"""Histories of the real middleware: a slow reader pauses; what arrives is an outcome of the net."""

from __future__ import annotations

from functools import partial

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import node_nets
from dineros.metamodel.files import save
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import Ros
from tests.runtime.ros.post import post

LETTERS, WRITER, READER = 120, 2, 3
WAITS = """
import time
from pathlib import Path
def configure(net):
    @net.handler("TRead", thread=True)
    def read(firing):
        while not Path("open").exists():
            time.sleep(0.01)
"""
LATER = """
import time
def configure(net):
    first = [3.0]
    @net.handler("TSend")
    def send(firing):
        time.sleep(first.pop() if first else 0.0)
"""
SLEEPS = """
import time
def configure(net):
    @net.handler("TRead")
    def read(firing):
        time.sleep(0.5)
"""


def flooded(reliability: str, executor: str) -> sym.SystemModel:
    """Return the post office under the rules of ROS 2, with many letters and shallow histories."""
    model = post(LETTERS)
    model.middleware = "ros2"
    letters = model.channels[0]
    model.channels.remove(model.channels[2])
    assert isinstance(letters, sym.TopicChannel)
    letters.publishers[0].limit = WRITER
    letters.subscribers[0].limit = READER
    letters.qos = sym.QualityOfService(reliability=reliability, lifespan=60.0, deadline=100.0)
    (house,) = (page for page in model.pages if page.id == "house")
    assert isinstance(house, sym.NodeNet)
    house.executor, house.threads = executor, 3
    return model


@pytest.mark.long
@pytest.mark.parametrize(
    ("reliability", "executor", "type"),
    [
        ("reliable", "single", None),
        ("bestEffort", "multi", None),
        ("reliable", "single", "std_msgs/msg/Float64"),  # its messages' ids come beside them
    ],
)
def test_a_flooded_reader_that_pauses(ros: Ros, reliability: str, executor: str, type: str | None) -> None:
    model = flooded(reliability, executor)
    if type is not None:
        model.channels[0].type = type
        mapping = sym.FieldMapping(part="message", messageField="data", tokenField="weight")
        model.channels[0].mappings.append(mapping)
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    house = ros.node("house", handlers=WAITS)
    # A writer may know of a reader that does not know of it yet: that one misses what is not reliable.
    parameters = {"expected_subscribers.Letters": 1, "signals.Open": True}
    office = ros.node("office", parameters, handlers=LATER if reliability == "bestEffort" else None)
    ros.wait(lambda: len(ros.records("office", "publish")) == LETTERS, "sending all letters")
    ros.wait(lambda: taken(ros), "taking a letter")
    before = taken(ros)
    assert len(before) == 1  # one in hand; all others stay in the middleware
    (ros.folder / "open").touch()
    ros.wait(lambda: taken(ros)[-1] == LETTERS, "taking the last letter")
    assert house.interrupt() == 0
    assert office.interrupt() == 0

    after = taken(ros)
    assert after[0] == before[0]
    assert len(after) <= 1 + READER + WRITER  # in hand, and in the histories of both; which ones is a race
    assert after == sorted(set(after))
    lost = sum(record["count"] for record in ros.records("house", "drop"))
    assert lost == LETTERS - len(after) > 0
    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([ros.folder / "journal"]).items()}
    verdict = conform(model, traces)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


def taken(ros: Ros) -> list[int]:
    return [int(record["message"].rpartition("/")[2]) for record in ros.records("house", "take")]


def two_offices() -> sym.SystemModel:
    """Return two offices that write to one house: two letters each at once, and two later."""
    model = post(letters=0, durability="transientLocal")
    model.middleware = "ros2"
    letters = model.channels[0]
    for channel in list(model.channels)[1:]:
        model.channels.remove(channel)
    for page in [page for page in model.pages if page.id in ("desk", "scale")]:
        model.pages.remove(page)
    (office,) = (page for page in node_nets(model) if page.id == "office")
    assert isinstance(letters, sym.TopicChannel)
    branch = sym.NodeNet(id="branch", net=model)
    for name, node in (("", office), ("2", branch)):
        node.signals.append(sym.InputSignal(id=f"Later{name}"))
        sent = sym.Place(id="Sent2", page=branch) if name else letters.publishers[0].place
        for pile, clause in ((f"Early{name}", None), (f"Late{name}", f"Later{name}")):
            send = sym.Transition(id=f"Send{pile}", page=node)
            flow(sym.Place(id=pile, tokens=2, page=node), send, sent)
            if clause:
                set_clause(send, clause)
        if name:
            letters.publishers.append(sym.PublisherPort(place=sent))
    for port in (*letters.publishers, *letters.subscribers):
        port.limit = 4
    return model


@pytest.mark.long
def test_what_comes_again_takes_no_room_of_what_is_new(ros: Ros) -> None:
    """Both offices send four letters again at once, and the house keeps four: two of each are known to it."""
    model = two_offices()
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    house = ros.node("house")
    offices = [ros.node(name, {"expected_subscribers.Letters": 1}) for name in ("office", "branch")]
    ros.wait(lambda: len(taken(ros)) == 4, "taking the early letters")
    house.popen.kill()
    house.popen.wait()
    ros.processes.remove(house)
    for office in offices:
        assert office.interrupt() == 0
    for name, signal in (("office", "Later"), ("branch", "Later2")):
        ros.node(name, {"resume": True, f"signals.{signal}": True})
    for name in ("office", "branch"):
        ros.wait(partial(has_sent, ros, name, 4), "sending the late letters")
    ros.node("house", {"resume": True}, handlers=SLEEPS)
    ros.wait(lambda: len(ros.records("house", "take")) + lost(ros) == 8, "taking the late letters")
    assert lost(ros) == 0
    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([ros.folder / "journal"]).items()}
    assert conform(model, traces).status == "conforms"


def has_sent(ros: Ros, office: str, letters: int) -> bool:
    return len(ros.records(office, "publish")) == letters


def lost(ros: Ros) -> int:
    return sum(record["count"] for record in ros.records("house", "drop"))
