"""Messages of existing ROS types on real ROS 2: each comes once, whoever is stopped or killed."""

from __future__ import annotations

import os
import signal
import time
from functools import partial

import pytest

from dineros.analysis.conformance import Verdict, conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import PATIENCE, Process, Ros

WORDS = 6

SLOW_TALKER = """
import time

def configure(net):
    @net.handler("TSay", thread=True)
    def say(firing):
        time.sleep(0.3)
"""

SLOW_LISTENER = """
import time

def configure(net):
    @net.handler("TNote")
    def note(firing):
        time.sleep(0.2)
"""

DEADLY = """
import os, signal, time
from pathlib import Path
from dineros.runtime.ros.channels.{module} import {owner}

send = {owner}.{method}

def deadly(self, *arguments):
    sent = send(self, *arguments)
    if {condition} and not Path("died").exists():
        Path("died").touch()
        time.sleep(0.5)  # so that it is on its way
        os.kill(os.getpid(), signal.SIGKILL)
    return sent

{owner}.{method} = deadly

def configure(net):
    pass
"""

DIES_AT_THIRD_WORD = DEADLY.format(
    module="transport", owner="RclpyTransport", method="publish", condition='arguments[1].id.endswith("/3")'
)
DIES_AT_REQUEST = DEADLY.format(module="clients", owner="Clients", method="_send", condition="True")

SLOW_SWITCH = """
import asyncio

def configure(net):
    @net.handler("TSwitch")
    async def switch(firing):
        await asyncio.sleep(0.5)
        return {"done": True, "number": 7}
"""

STRANGER = """
import rclpy, time
from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, QoSProfile
from std_msgs.msg import Int64, String
from std_srvs.srv import SetBool
rclpy.init()
node = rclpy.create_node("stranger")

def publisher(type, topic, quality=10):
    made = node.create_publisher(type, topic, quality)
    while not made.get_subscription_count():
        time.sleep(0.02)
    return made

def ask(data):
    client = node.create_client(SetBool, "/switch")
    assert client.wait_for_service(30)
    future = client.call_async(SetBool.Request(data=data))
    rclpy.spin_until_future_complete(node, future, timeout_sec=30)
    return future.result().success

def say(publisher, *messages):
    for message in messages:
        publisher.publish(message)
        time.sleep(0.02)
    assert publisher.wait_for_all_acked(Duration(seconds=30))
"""

PLAIN_LISTENER = """
import rclpy, sys, time
from std_msgs.msg import Int64
rclpy.init()
node = rclpy.create_node("plain")
node.create_subscription(Int64, "/words", lambda word: print(word.data, flush=True), 10)
print("listens", flush=True)
while rclpy.ok():
    rclpy.spin_once(node, timeout_sec=0.1)
"""


def system(word_count: int = WORDS, limit: int = 10) -> sym.SystemModel:
    """Return a talker and a listener on a topic, a caller and a switch on a service; all words are equal."""
    words, say, said = (
        sym.Place(id="Words", tokens=word_count),
        sym.Transition(id="TSay"),
        sym.Place(id="Said"),
    )
    talker = sym.NodeNet(id="talker", objects=[words, say, said])
    flow(words, say, said)
    heard, note, noted = sym.Place(id="Heard"), sym.Transition(id="TNote"), sym.Place(id="Noted")
    listener = sym.NodeNet(
        id="listener", objects=[sym.CallbackPage(id="OnWord", objects=[heard, note, noted])]
    )
    flow(heard, note, noted)
    wish, ask, asked = sym.Place(id="Wish", tokens=2), sym.Transition(id="TAsk"), sym.Place(id="Asked")
    told, end, done = sym.Place(id="Told"), sym.Transition(id="TEnd"), sym.Place(id="Done")
    caller = sym.NodeNet(id="caller", objects=[wish, ask, asked, told, end, done])
    flow(wish, ask, asked)
    flow(told, end, done)
    entry, work, exit_ = sym.Place(id="Entry"), sym.Transition(id="TSwitch"), sym.Place(id="Exit")
    serving = sym.CallbackPage(id="Switching", kind="server", objects=[entry, work, exit_])
    switch = sym.NodeNet(id="switch", objects=[serving])
    flow(entry, work, exit_)
    return sym.SystemModel(
        id="plain",
        tokenType=sym.TokenType(
            id="Item",
            fields=[
                sym.TokenField(name="number", kind="integer"),
                sym.TokenField(name="done", kind="boolean"),
            ],
        ),
        pages=[talker, listener, caller, switch],
        channels=[
            sym.TopicChannel(
                id="Spoken",
                topic="/words",
                type="std_msgs/msg/Int64",
                mappings=[sym.FieldMapping(part="message", messageField="data", tokenField="number")],
                publishers=[sym.PublisherPort(place=said, limit=limit)],
                subscribers=[sym.SubscriberPort(place=heard, limit=limit)],
            ),
            sym.ServiceChannel(
                id="Switched",
                service="/switch",
                type="std_srvs/srv/SetBool",
                mappings=[
                    sym.FieldMapping(part="request", messageField="data", tokenField="done"),
                    sym.FieldMapping(part="response", messageField="success", tokenField="done"),
                ],
                server=sym.ServerPort(entry=entry, exit=exit_, page=serving),
                clients=[sym.ClientPort(client="caller", request=asked, response=told)],
            ),
        ],
    )


def lay_out(model: sym.SystemModel, ros: Ros) -> None:
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")


@pytest.fixture
def plain(ros: Ros) -> Ros:
    """The nodes of `system`, to be started."""
    lay_out(system(), ros)
    return ros


def wait_for_death(ros: Ros, process: Process) -> None:
    process.popen.wait(PATIENCE)
    ros.processes.remove(process)


def kill(ros: Ros, process: Process) -> None:
    os.kill(process.popen.pid, signal.SIGKILL)
    wait_for_death(ros, process)


def numbers(ros: Ros, node: str, event: str) -> list[str]:
    """Return the numbers of the messages of a kind of record, as strings; empty: no id."""
    return [record["message"].rpartition("/")[2] for record in ros.records(node, event)]


def judged(ros: Ros, *processes: Process) -> Verdict:
    """Stop nodes, and compare their journals with the model."""
    assert [process.interrupt() for process in processes] == [0] * len(processes)
    found = traces_of_runs([ros.folder / "journal"])
    return conform(system(), {node: partial(read_trace, files) for node, files in found.items()})


ALL = [str(number) for number in range(1, WORDS + 1)]


@pytest.mark.long
def test_publisher_killed_before_it_records(plain: Ros) -> None:
    """What it had sent, it sends again with the same id: the listener has it once."""
    listener = plain.node("listener")
    expected = {"expected_subscribers.Spoken": 1}
    wait_for_death(plain, plain.node("talker", expected, handlers=DIES_AT_THIRD_WORD))
    plain.wait(lambda: len(plain.records("listener", "take")) == 3, "three words")
    assert numbers(plain, "talker", "publish") == ["1", "2"]
    talker = plain.node("talker", expected)
    plain.wait(lambda: len(plain.records("listener", "take")) == WORDS, "all words")
    time.sleep(1.0)  # what comes twice would come now
    assert numbers(plain, "listener", "take") == ALL
    assert plain.records("listener", "drop") == []
    assert judged(plain, listener, talker).status == "conforms"


@pytest.mark.long
def test_killed_subscriber_gets_what_it_missed_once(plain: Ros) -> None:
    """All words are equal, and most of them come while it is down."""
    listener = plain.node("listener")
    talker = plain.node("talker", {"expected_subscribers.Spoken": 1}, handlers=SLOW_TALKER)
    plain.wait(lambda: plain.records("listener", "take"), "the first word")
    kill(plain, listener)
    before = len(plain.records("listener", "take"))
    plain.wait(lambda: len(plain.records("talker", "publish")) == WORDS, "all words said")
    assert before < WORDS, "the machine is too slow for this test"
    listener = plain.node("listener")
    plain.wait(lambda: len(plain.records("listener", "take")) == WORDS, "all words")
    time.sleep(1.0)
    assert numbers(plain, "listener", "take") == ALL
    assert judged(plain, listener, talker).status == "conforms"


@pytest.mark.long
def test_both_killed(plain: Ros) -> None:
    """What was on its way when both died is published again."""
    listener = plain.node("listener")
    talker = plain.node("talker", {"expected_subscribers.Spoken": 1}, handlers=SLOW_TALKER)
    plain.wait(lambda: plain.records("listener", "take"), "the first word")
    kill(plain, listener)
    plain.wait(lambda: len(plain.records("talker", "publish")) >= 4, "four words said")
    kill(plain, talker)
    talker, listener = plain.node("talker"), plain.node("listener")
    plain.wait(lambda: len(plain.records("listener", "take")) == WORDS, "all words")
    time.sleep(1.0)
    assert numbers(plain, "listener", "take") == ALL
    assert judged(plain, listener, talker).status == "conforms"


@pytest.mark.long
def test_a_full_queue_loses_what_it_says(plain: Ros) -> None:
    """A burst for a slow listener with a queue of 5: each word is taken once, or counted as lost."""
    lay_out(system(word_count=60, limit=5), plain)
    plain.node("listener", handlers=SLOW_LISTENER)
    plain.node("talker", {"expected_subscribers.Spoken": 1})

    def lost() -> int:
        return sum(record["count"] for record in plain.records("listener", "drop"))

    plain.wait(lambda: len(plain.records("listener", "take")) + lost() >= 60, "all words")
    time.sleep(1.0)
    takes = numbers(plain, "listener", "take")
    assert {record["queue"] for record in plain.records("listener", "drop")} == {"subscriber"}
    assert len(takes) == len(set(takes)) == 60 - lost()


@pytest.mark.long
def test_strangers_see_no_difference(plain: Ros) -> None:
    """A plain subscriber hears every word once, although the talker is stopped and continues."""
    script = plain.folder / "plain.py"
    script.write_text(PLAIN_LISTENER)
    stranger = plain.start("plain", script)
    plain.wait(lambda: "listens" in stranger.output(), "the plain listener")
    talker = plain.node("talker", {"expected_subscribers.Spoken": 1}, handlers=SLOW_TALKER)
    plain.wait(lambda: len(plain.records("talker", "publish")) >= 3, "three words said")
    assert talker.interrupt() == 0
    assert len(plain.records("talker", "publish")) < WORDS, "the machine is too slow for this test"
    plain.node("talker", {"expected_subscribers.Spoken": 1}, handlers=SLOW_TALKER)
    plain.wait(lambda: len(plain.records("talker", "publish")) == WORDS, "all words said")
    time.sleep(1.0)
    assert stranger.output().split() == ["listens", *["0"] * WORDS]


@pytest.mark.long
@pytest.mark.parametrize("with_talker", [False, True])
def test_a_plain_publisher_is_heard(plain: Ros, with_talker: bool) -> None:
    """Its words equal those of the talker, which have come just before."""
    plain.node("listener")
    if with_talker:
        plain.node("talker", {"expected_subscribers.Spoken": 1})
        plain.wait(lambda: len(plain.records("listener", "take")) == WORDS, "all words of the talker")
    plain.script(STRANGER + "say(publisher(Int64, '/words'), *(Int64(data=n) for n in (0, 5, 0)))\n")
    own = WORDS if with_talker else 0
    plain.wait(lambda: len(plain.records("listener", "take")) == own + 3, "three more words")
    time.sleep(0.5)
    takes = plain.records("listener", "take")[own:]
    assert [(take["message"], take["data"]["number"]) for take in takes] == [("", 0), ("", 5), ("", 0)]
    assert numbers(plain, "listener", "take")[:own] == ALL[:own]


@pytest.mark.long
def test_client_killed_as_it_sends(plain: Ros) -> None:
    """Its request is served once, and answered again when it continues; mostly it is not recorded by then."""
    switch = plain.node("switch", handlers=SLOW_SWITCH)
    wait_for_death(plain, plain.node("caller", handlers=DIES_AT_REQUEST))
    plain.wait(lambda: plain.records("switch", "reply"), "an answer to nobody")
    caller = plain.node("caller")
    plain.wait(lambda: len(plain.records("caller", "response")) == 2, "two responses")
    assert numbers(plain, "switch", "serve") == ["1", "2"]
    assert [record["data"]["done"] for record in plain.records("caller", "response")] == [True, True]
    assert judged(plain, switch, caller).status == "conforms"


@pytest.mark.long
def test_server_killed_while_it_serves(plain: Ros) -> None:
    """It continues with what it had begun, and answers the request that comes again."""
    switch = plain.node("switch", handlers=SLOW_SWITCH)
    caller = plain.node("caller", {"request_timeout": 0.5})
    plain.wait(lambda: plain.records("switch", "serve"), "serving")
    kill(plain, switch)
    switch = plain.node("switch", handlers=SLOW_SWITCH)
    plain.wait(lambda: len(plain.records("caller", "response")) == 2, "two responses")
    assert numbers(plain, "switch", "serve") == ["1", "2"]
    assert judged(plain, switch, caller).status == "conforms"


@pytest.mark.long
def test_a_slow_server_serves_once(plain: Ros) -> None:
    """It takes longer than the time-out: it recognises the request that comes again."""
    switch = plain.node("switch", handlers=SLOW_SWITCH)
    caller = plain.node("caller", {"request_timeout": 0.1})
    plain.wait(lambda: len(plain.records("caller", "response")) == 2, "two responses")
    assert plain.records("caller", "timeout")
    assert numbers(plain, "switch", "serve") == ["1", "2"]
    assert judged(plain, switch, caller).status == "conforms"


@pytest.mark.long
@pytest.mark.parametrize("with_caller", [False, True])
def test_a_plain_client_is_served(plain: Ros, with_caller: bool) -> None:
    plain.node("switch", handlers=SLOW_SWITCH)
    if with_caller:
        plain.node("caller")
        plain.wait(lambda: len(plain.records("caller", "response")) == 2, "two responses")
    assert plain.script(STRANGER + "print(ask(False), ask(False))") == "True True\n"
    assert numbers(plain, "switch", "serve") == (["1", "2"] if with_caller else []) + ["", ""]


@pytest.mark.long
def test_forged_announcements_do_no_harm(plain: Ros) -> None:
    """They are counted, said once, and silence nobody."""
    plain.node("listener")
    plain.node("switch", handlers=SLOW_SWITCH)
    plain.script(
        STRANGER + "import base64, json\n"
        "from rclpy.serialization import serialize_message\n"
        "def told(id, message):\n"
        "    content = base64.b64encode(serialize_message(message)).decode()\n"
        "    return String(data=json.dumps({'id': id, 'content': content, 'number': 1}))\n"
        'garbage = [\'\', \'{}\', \'[\' * 10000, \'{"id": "a/b/1", "content": "AAEAAP8=", "number": 0}\']\n'
        "garbage = [String(data=text) for text in garbage]\n"
        "kept = QoSProfile(depth=99, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "words, word = publisher(String, '/words/_messages', kept), Int64(data=3)\n"
        "say(words, *garbage, told('talker/Said/' + '9' * 5000, word), told('talker/Said/-1', word))\n"
        "say(words, told('talker/Said/1000000', word))\n"
        "requests = publisher(String, '/switch/_requests', kept)\n"
        "say(requests, *garbage, *(told('x/y/1', SetBool.Request()) for _ in range(3)))\n"
        "say(requests, *(told('caller/Asked/' + '9' * 5000, SetBool.Request(data=True)) for _ in range(2)))\n"
        "time.sleep(2.1)\n"
        "assert ask(False)\n"
    )
    plain.wait(lambda: len(plain.records("listener", "take")) == 1, "the forged word")
    plain.node("talker", {"expected_subscribers.Spoken": 1})
    plain.node("caller")
    plain.wait(lambda: len(plain.records("listener", "take")) == 1 + WORDS, "all words")
    plain.wait(lambda: len(plain.records("caller", "response")) == 2, "two responses")
    assert numbers(plain, "listener", "take") == ["1000000", *ALL]
    assert numbers(plain, "switch", "serve") == ["", "1", "2"]
    assert [len(plain.records(node, "error")) for node in ("listener", "switch")] == [1, 1]
