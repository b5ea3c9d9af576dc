"""Nodes as processes on real ROS 2, through shared memory alone."""

from __future__ import annotations

import json
import os
import signal
import time

import pytest

from dineros.metamodel.files import save
from dineros.runtime.ros.process.environment import Reach
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import PATIENCE, Ros
from tests.runtime.ros.post import LETTER, post
from tests.runtime.ros.process.shared_memory import used_by

EXPECTED = {"expected_subscribers.Letters": 1, "signals.Open": True}
SLOW_READER = """
import time
def configure(net):
    @net.handler("TRead")
    def read(firing):
        time.sleep(0.15)
"""
SLOW_OFFICE = """
import time

def configure(net):
    @net.handler("TSend", thread=True)
    def send(firing):
        time.sleep(0.5)
"""

SLOW_SCALE = """
import asyncio
def configure(net):
    @net.handler("TWeigh")
    async def weigh(firing):
        await asyncio.sleep(0.7)
        return {"weight": 1.5, "number": firing.instance}
"""


@pytest.mark.parametrize("reach", ["memory", "machine"])
def test_two_processes_over_a_topic(ros: Ros, reach: Reach) -> None:
    """A token comes through with all it carries; nothing leaves the machine."""
    house = ros.node("house")
    office = ros.node("office", EXPECTED)
    ros.wait(lambda: len(ros.fired("house", "TRead")) == 3, "reading three letters")
    addresses = ros.addresses()
    segments = {name for name, _ in used_by(house.popen.pid) if name.startswith("fastrtps_")}
    assert [process.interrupt() for process in (office, house)] == [0, 0], office.output() + house.output()

    takes = ros.records("house", "take")
    assert [record["message"].rpartition("/")[2] for record in takes] == ["1", "2", "3"]
    assert takes[0]["data"] == LETTER
    assert takes[1]["data"]["subject"] == ""
    assert ros.records("house", "drop") == []
    published = [record["message"] for record in ros.records("office", "publish")]
    assert published == [record["message"] for record in takes]
    assert [ros.records(node)[-1]["event"] for node in ("house", "office")] == ["stop", "stop"]

    assert addresses <= (set() if reach == "memory" else {"127.0.0.1"})
    if reach == "machine":
        assert addresses
    assert segments, "the processes share memory"


@pytest.mark.long
def test_requests_are_served_in_parallel(ros: Ros) -> None:
    """Two clients, two server instances: the second request is served while the first one is."""
    desk = ros.node("desk")
    scale = ros.node("scale", handlers=SLOW_SCALE)
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    assert [process.interrupt() for process in (desk, scale)] == [0, 0]
    events = [record["event"] for record in ros.records("scale") if record["event"] in ("serve", "reply")]
    assert events == ["serve", "serve", "reply", "reply"]
    responses = ros.records("desk", "response")
    assert {record["data"]["weight"] for record in responses} == {1.5}
    assert {record["data"]["number"] for record in responses} == {1, 2}
    requests = {record["client"]: record["message"] for record in ros.records("desk", "request")}
    assert {record["client"]: record["message"] for record in responses} == requests
    # Each client got the response to its own request.
    served = {record["instance"]: record["message"] for record in ros.records("scale", "serve")}
    for record in responses:
        assert served[record["data"]["number"]] == record["message"]


def test_existing_interface(ros: Ros) -> None:
    """A token's field in a std_msgs/Float64 arrives in the other node, and in a program without DiNeROS."""
    ros.node("house")
    ros.node("scale", {"expected_subscribers.Readings": 2})
    heard = ros.script(
        "import rclpy\n"
        "from std_msgs.msg import Float64\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "got = []\n"
        "node.create_subscription(Float64, '/readings', got.append, 10)\n"
        "while not got:\n"
        "    rclpy.spin_once(node)\n"
        "print(got[0].data)\n"
        "rclpy.shutdown()\n"
    )
    assert heard == "7.5\n"
    ros.wait(lambda: ros.fired("house", "TLook"), "looking at the reading")
    (take,) = ros.records("house", "take")
    (publish,) = ros.records("scale", "publish")
    message = publish["message"]  # the interface has no field for it
    assert (take["channel"], take["message"], take["data"]["weight"]) == ("Readings", message, 7.5)


@pytest.mark.long
def test_full_queue_is_seen_by_the_subscriber(ros: Ros) -> None:
    """A burst of 40 letters for a reader with a queue of 5: each one is read or counted as lost."""
    set_letters(ros, 40)
    ros.node("house", handlers=SLOW_READER)
    ros.node("office", EXPECTED)
    ros.wait(lambda: len(ros.records("office", "publish")) == 40, "publishing")
    ros.wait(
        lambda: any(record["message"].endswith("/40") for record in ros.records("house", "take")),
        "the last letter",
    )
    takes, drops = ros.records("house", "take"), ros.records("house", "drop")
    lost = sum(record["count"] for record in drops)
    assert {(record["channel"], record["queue"], record["place"]) for record in drops} == {
        ("Letters", "subscriber", "Arrived")
    }
    assert lost > 0
    assert len(takes) + lost == 40


def set_letters(ros: Ros, number: int) -> None:
    file = ros.folder / "office.rtm.xmi"
    text = file.read_text()
    assert text.count('tokens="3"') == 1
    file.write_text(text.replace('tokens="3"', f'tokens="{number}"'))


@pytest.mark.long
def test_request_without_server_is_sent_again(ros: Ros) -> None:
    """Time-outs are recorded; the request keeps its id and gets its response once the server is there."""
    ros.node("desk", {"request_timeout": 0.3})
    ros.wait(lambda: len(ros.records("desk", "timeout")) >= 3, "time-outs")
    ros.node("scale")
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    requests = {record["message"] for record in ros.records("desk", "request")}
    assert {record["message"] for record in ros.records("desk", "timeout")} <= requests
    assert {record["message"] for record in ros.records("desk", "response")} == requests
    assert len(ros.records("scale", "serve")) == 2


@pytest.mark.long
def test_server_that_takes_longer_than_the_timeout_serves_once(ros: Ros) -> None:
    ros.node("desk", {"request_timeout": 0.2})
    ros.node("scale", handlers=SLOW_SCALE)
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    assert ros.records("desk", "timeout")
    assert len(ros.records("scale", "serve")) == 2


DESK_AND_SCALE = """
import threading, time
from dineros.runtime import Net
from dineros.runtime.channels import clients
from dineros.runtime.nodes.net import load_runtime_model
from dineros.runtime.ros.running import RosNode

def wait(condition):
    end = time.monotonic() + 50
    while not condition():
        assert time.monotonic() < end, desk.net.inspect()
        time.sleep(0.01)

weighed = threading.Event()
arguments = ["--ros-args", "-p", "request_timeout:={timeout}", "-p", "diagnostics_period:=0.0"]
desk = RosNode(Net(load_runtime_model("desk.rtm.xmi")), arguments=arguments)
scale = RosNode(Net(load_runtime_model("scale.rtm.xmi")))
scale.net.handler("TWeigh", thread=True, parallel=2)(lambda firing: weighed.wait(50) and None)
is_done = lambda: (desk.net.count("NotedA"), desk.net.count("NotedB")) == (1, 1)
"""


def test_a_response_counts_although_its_request_was_given_up(ros: Ros) -> None:
    """It is handed on when it comes, also where the clients would not ask again for an hour."""
    ros.script(
        DESK_AND_SCALE.replace("{timeout}", "0.5") + "with scale, desk:\n"
        "    wait(lambda: len(scale.net.inspect().in_flight) == 2)\n"
        "    clients.RESEND_DELAY = clients.LONGEST_RESEND_DELAY = 3600.0\n"
        "    wait(lambda: (desk.net.next_timer or 0) > time.monotonic() + 1000)\n"
        "    assert not is_done()\n"
        "    weighed.set()\n"
        "    wait(is_done)\n"
    )


@pytest.mark.long
def test_who_does_not_fit_is_warned_of(ros: Ros) -> None:
    """Nobody waits for that at each message, but it is said all the same."""
    house = ros.node("house")
    stranger = ros.folder / "stranger.py"
    stranger.write_text(
        "import rclpy\n"
        "from rclpy.qos import QoSProfile, ReliabilityPolicy\n"
        "from std_msgs.msg import Float64\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "quality = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)\n"
        "publisher = node.create_publisher(Float64, '/readings', quality)\n"
        "rclpy.spin(node)\n"
    )
    ros.start("stranger", stranger)
    ros.wait(lambda: "incompatible QoS" in house.output(), "the warning")


def test_a_message_costs_no_look_at_what_only_warns(ros: Ros) -> None:
    """What the developers have callbacks of their own for is waited for like everything else."""
    ros.script(
        DESK_AND_SCALE.replace("{timeout}", "0.5")
        + "from rclpy.event_handler import PublisherEventCallbacks\n"
        "from std_msgs.msg import Float64\n"
        "session = scale.session\n"
        "with scale:\n"
        "    def waited():\n"
        "        return [each for each in session.node.waitables if session._executor.can_execute(each)]\n"
        "    assert not waited(), waited()\n"
        "    own = PublisherEventCallbacks(matched=print, use_default_callbacks=False)\n"
        "    session.node.create_publisher(Float64, '/own', 1, event_callbacks=own)\n"
        "    assert len(waited()) == 1\n"
        "desk.session.close()\n"
    )


def test_a_node_does_not_wake_itself(ros: Ros) -> None:
    """After each callback rclpy does so, and waits once more for nothing."""
    ros.script(
        "from rclpy.guard_condition import GuardCondition\n"
        "from threading import current_thread\n"
        "wake, wakers = GuardCondition.trigger, set()\n"
        "def noted(self):\n"
        "    wakers.add(current_thread().name)\n"
        "    wake(self)\n"
        "GuardCondition.trigger = noted\n" + DESK_AND_SCALE.replace("{timeout}", "9.0") + "weighed.set()\n"
        "with scale, desk:\n"
        "    wait(is_done)\n"
        "    assert not {'ros desk', 'ros scale'} & wakers, wakers\n"
    )


def test_a_client_without_a_request_wakes_nobody(ros: Ros) -> None:
    """Its timer runs only while a request is under way."""
    ros.script(
        DESK_AND_SCALE.replace("{timeout}", "0.5") + "with scale, desk:\n"
        "    (timer,) = [each for each in desk.session.node.timers if each.callback.__name__ == '_look']\n"
        "    wait(lambda: not timer.is_canceled())\n"
        "    weighed.set()\n"
        "    wait(is_done)\n"
        "    wait(timer.is_canceled)\n"
    )


@pytest.mark.long
@pytest.mark.parametrize("records", [False, True])
def test_who_records_nothing_announces_nothing(ros: Ros, records: bool) -> None:
    """A message of an existing type is announced with an id for who sends it again after a restart."""
    text = ros.script(
        "from dineros.runtime.journal.recording import ListRecorder\n"
        "from dineros.runtime.nodes.net import Net\n"
        "from dineros.runtime.ros.running import RosNode\n"
        f"recorder = ListRecorder() if {records} else None\n"
        "with RosNode(Net.load('scale.rtm.xmi'), recorder) as scale:\n"
        "    print(*[name for name, _ in scale.session.node.get_topic_names_and_types()])\n"
    )
    assert "/readings" in text.split()
    assert ("/readings/_messages" in text.split()) == records


@pytest.mark.long
def test_killed_server_goes_on_from_its_journal(ros: Ros) -> None:
    """What it had begun to serve is served in its second life, and both clients get their response."""
    desk = ros.node("desk", {"request_timeout": 0.5})
    scale = ros.node("scale", handlers=SLOW_SCALE)
    ros.wait(lambda: len(ros.records("scale", "serve")) == 2, "serving")
    os.kill(scale.popen.pid, signal.SIGKILL)
    scale.popen.wait(PATIENCE)
    ros.processes.remove(scale)
    again = ros.node("scale", {"resume": True}, handlers=SLOW_SCALE)
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    assert again.interrupt() == 0, again.output()
    assert len(ros.records("scale", "serve")) == 2
    assert [record["resumed"] for record in ros.records("scale", "start")] == [False, True]
    assert desk.interrupt() == 0


@pytest.mark.long
def test_restarted_subscriber_gets_what_it_missed_once(ros: Ros) -> None:
    """A transient-local topic: letters sent while the house was dead come, those it had come no more."""
    for part in split(post(letters=4, durability="transientLocal")):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    house = ros.node("house")
    office = ros.node("office", EXPECTED, handlers=SLOW_OFFICE)
    ros.wait(lambda: ros.records("house", "take"), "the first letter")
    os.kill(house.popen.pid, signal.SIGKILL)
    house.popen.wait(PATIENCE)
    ros.processes.remove(house)
    before = len(ros.records("house", "take"))
    ros.wait(lambda: len(ros.records("office", "publish")) == 4, "four letters sent")
    assert before < 4, "the machine is too slow for this test"
    again = ros.node("house", {"resume": True})
    ros.wait(lambda: len(ros.fired("house", "TRead")) == 4, "four letters read")
    time.sleep(0.5)  # what comes twice would come now
    assert [process.interrupt() for process in (office, again)] == [0, 0]
    takes = [record["message"].rpartition("/")[2] for record in ros.records("house", "take")]
    assert takes == ["1", "2", "3", "4"]
    assert ros.records("house", "drop") == []


@pytest.mark.long
def test_forged_ids_from_a_stranger(ros: Ros) -> None:
    """A server that answers with other ids is asked again; letters with forged ids silence nobody."""
    ros.node("house")
    ros.node("desk")
    ros.wait(lambda: ros.records("house", "start"), "the start")
    ros.script(
        "import rclpy, time\n"
        "from post_interfaces.msg import Letter\n"
        "from post_interfaces.srv import Weigh\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "asked = []\n"
        "def answer(request, response):\n"
        "    asked.append(request.token.message_id)\n"
        "    response.token = request.token\n"
        "    if asked.count(asked[-1]) == 1:\n"
        "        response.token.message_id = 'forged/id/' + '9' * 5000\n"
        "    return response\n"
        "node.create_service(Weigh, '/weigh', answer)\n"
        "while len(asked) < 4:\n"
        "    rclpy.spin_once(node)\n"
        "publisher = node.create_publisher(Letter, '/letters', 10)\n"
        "while not publisher.get_subscription_count():\n"
        "    rclpy.spin_once(node, timeout_sec=0.05)\n"
        "for number in ('9' * 5000, '-1', '1000000', '1', '2', '2'):\n"
        "    letter = Letter(message_id=f'office/Sent/{number}', size=[0.0, 0.0, 0.0])\n"
        "    publisher.publish(letter)\n"
        "    time.sleep(0.05)\n"
        "publisher.wait_for_all_acked(rclpy.duration.Duration(seconds=30))\n"
        "rclpy.shutdown()\n"
    )
    ros.wait(lambda: len(ros.records("desk", "response")) == 2, "two responses")
    assert len(ros.records("desk", "timeout")) == 2
    ros.wait(lambda: len(ros.records("house", "take")) == 3, "three letters")
    numbers = [record["message"].rpartition("/")[2] for record in ros.records("house", "take")]
    assert numbers == ["1000000", "1", "2"]
    assert len(ros.records("house", "error")) == 1


def test_parameters_are_described(ros: Ros) -> None:
    ros.node("office")
    ros.wait(lambda: ros.records("office", "start"), "the start")
    said = ros.script(
        "import rclpy\n"
        "from rcl_interfaces.srv import DescribeParameters, ListParameters\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('stranger')\n"
        "def ask(type, name, request):\n"
        "    client = node.create_client(type, name)\n"
        "    assert client.wait_for_service(30)\n"
        "    future = client.call_async(request)\n"
        "    rclpy.spin_until_future_complete(node, future, timeout_sec=30)\n"
        "    return future.result()\n"
        "names = ask(ListParameters, '/office/list_parameters', ListParameters.Request()).result.names\n"
        "names = [name for name in names if name not in ('use_sim_time', 'start_type_description_service')]\n"
        "request = DescribeParameters.Request(names=names)\n"
        "found = ask(DescribeParameters, '/office/describe_parameters', request)\n"
        "bounds = lambda r: (r.from_value, r.to_value)\n"
        "for each in found.descriptors:\n"
        "    ranges = [*each.integer_range, *each.floating_point_range]\n"
        "    print(each.name, bool(each.description), *map(bounds, ranges), sep='|')\n"
        "rclpy.shutdown()\n"
    )
    lines = dict(line.split("|", 1) for line in said.splitlines())
    assert lines.keys() >= {"journal", "resume", "seed", "log_level", "signals.Open", "signals.too_late"}
    assert lines["request_timeout"] == "True|(0.01, 86400.0)"
    assert lines["expected_subscribers.Letters"] == "True|(0, 1000)"
    assert "qos_overrides./letters.publisher_Sent.depth" in lines
    assert all(line.startswith("True") for line in lines.values())


@pytest.mark.long
def test_managed_node(ros: Ros) -> None:
    """Its channels open when it is configured; its net fires while it is active."""
    house = ros.node("house")
    office = ros.node("office", {"signals.Open": True}, options=["--lifecycle"])
    change = (
        "import rclpy, time\n"
        "from lifecycle_msgs.srv import ChangeState\n"
        "from lifecycle_msgs.msg import Transition\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('manager')\n"
        "client = node.create_client(ChangeState, '/office/change_state')\n"
        "assert client.wait_for_service(30)\n"
        "def change(id):\n"
        "    request = ChangeState.Request(transition=Transition(id=id))\n"
        "    future = client.call_async(request)\n"
        "    rclpy.spin_until_future_complete(node, future, timeout_sec=30)\n"
        "    return future.result().success\n"
        "print({0})\n"
        "rclpy.shutdown()\n"
    )
    assert ros.script(change.format("change(1)")) == "True\n"
    assert ros.records("office", "start")
    time.sleep(0.3)
    assert ros.fired("office", "TSend") == []
    assert ros.script(change.format("change(3)")) == "True\n"
    ros.wait(lambda: len(ros.fired("office", "TSend")) == 3, "sending")
    assert ros.script(change.format("change(4), change(2)")) == "True True\n"
    assert ros.records("office")[-1]["event"] == "stop"
    assert ros.script(change.format("change(1), change(3)")) == "True True\n"  # and it continues
    assert [record["resumed"] for record in ros.records("office", "start")] == [False, True]
    assert [process.interrupt() for process in (office, house)] == [0, 0]


def test_a_node_asks_for_its_signals(ros: Ros) -> None:
    """Also whoever comes later hears it, and can tell all of them."""
    office = ros.node("office")
    listen = (
        "import rclpy\n"
        "from rclpy.qos import DurabilityPolicy, QoSProfile\n"
        "from std_msgs.msg import String\n"
        "rclpy.init()\n"
        "node = rclpy.create_node('feeder')\n"
        "heard = []\n"
        "latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)\n"
        "node.create_subscription(String, '/office/signals_wanted', heard.append, latched)\n"
        "while not heard:\n"
        "    rclpy.spin_once(node, timeout_sec=0.1)\n"
        "print(heard[0].data)\n"
        "rclpy.shutdown()\n"
    )
    assert "Open" in json.loads(ros.script(listen))
    assert office.interrupt() == 0


@pytest.mark.long
@pytest.mark.parametrize(
    ("arguments", "text"),
    [
        (["-p", "request_timeout:=-1.0"], "the parameter request_timeout"),
        (["-p", "log_level:=loud"], "no log level 'loud'"),
        (["-p", "when_stale.Open:=maybe"], "the parameter when_stale.Open"),
        (["-p", "when_stale.Open:=3"], "the parameter when_stale.Open"),
        (["-p", "stale_after.Open:=-1.0"], "the parameter stale_after.Open"),
        (["-r", "__node:=two words"], "ROS 2 does not start"),
    ],
)
def test_wrong_arguments_are_one_line(ros: Ros, arguments: list[str], text: str) -> None:
    office = ros.node("office", arguments=arguments)
    assert office.popen.wait(PATIENCE) == 2
    assert text in office.output()
    assert "Traceback" not in office.output()


def test_a_node_that_waits_for_subscribers_ends_at_once(ros: Ros) -> None:
    office = ros.node("office", {**EXPECTED, "discovery_timeout": 3600.0})
    ros.wait(lambda: ros.records("office", "start"), "the start")
    time.sleep(0.3)
    assert office.interrupt() == 0
    assert ros.records("office")[-1]["reason"] == "signal"


def test_interfaces_that_are_not_built(ros: Ros) -> None:
    ros.environment = {**ros.environment, "PYTHONPATH": ""}
    office = ros.node("office")
    assert office.popen.wait(PATIENCE) == 2
    assert "post_interfaces/msg/Letter is not installed (build the workspace" in office.output()
    assert [(record["event"], record.get("reason")) for record in ros.records("office")[-2:]] == [
        ("start", None),
        ("stop", "failure"),
    ]


def test_failing_recorder_ends_the_node(ros: Ros) -> None:
    (ros.folder / "journal").mkdir()
    (ros.folder / "journal" / "office.jsonl").write_text("")
    office = ros.node("office", {"resume": False})
    assert office.popen.wait(PATIENCE) == 2
    assert "has a trace of node 'office' already" in office.output()
