"""Actions on real ROS 2: all paths of goals, plain programs of rclpy at the other end, kills."""

from __future__ import annotations

import fcntl
import json
import os
import random
import signal
import time
from collections.abc import Iterator
from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.generators import Options, generate
from dineros.generators.workspace.building import build_interfaces, environment
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import Reach, ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from dineros.transformations.flattening.split import split
from tests.runtime.ros.conftest import PATIENCE, ROOT, Process, Ros
from tests.runtime.ros.errands import errands
from tests.support.programs.on_ros import require_tools

WORKSPACE = ROOT / "build/tests/errands_workspace"

OBEDIENT = """
def configure(net):
    def choose(enabled):
        for each in enabled:
            word, name = each.transition[1:-6], each.transition[-6:]
            if each.transition.endswith("Chore"):
                word, name = each.transition[1:-5], each.transition[-5:]
            (place, tokens), *_ = each.inputs.items()
            wanted = tokens[0].data["place"]
            is_asked = net.count(f"{name}[{each.instance}].Stop{name}") > 0
            if word in {
                "fine": ("Begin", "End"), "break": ("Begin", "Fail"), "long": ("Begin", "Stop"),
                "stubborn": ("Begin", "End") if is_asked else ("Begin",),
            }.get(wanted, ("Begin",)):
                return each
    net.selection(choose)
"""

RECALLS = """
def configure(net):
    def choose(enabled):
        for each in enabled:
            if each.transition.startswith("TSend"):
                return each
            ((token,),) = each.inputs.values()
            if each.transition.startswith("TRecall" if token.data["number"] % 5 == 1 else "TNote"):
                return each
    net.selection(choose)
"""

SLOW = """
import asyncio

def configure(net):
    def choose(enabled):
        best = [each for each in enabled if each.transition[1:5] in ("Begi", "Stop")]
        done = [each for each in enabled if each.transition[1:4] == "End"]
        return (best or done or [None])[0]
    net.selection(choose)
    for name in ("Errand", "Chore"):
        @net.handler(f"TEnd{name}")
        async def end(firing):
            await asyncio.sleep(0.15)
"""

NEVER_RECALLS = """
def configure(net):
    net.selection(lambda enabled: next((e for e in enabled if not e.transition.startswith("TRecall")), None))
"""

DEADLY = """
import os, signal, time
from pathlib import Path
from dineros.runtime.ros.channels.actions import GoalCarrier

def deadly(method):
    send = getattr(GoalCarrier, method)

    def sends(self, *arguments):
        send(self, *arguments)
        if not Path(f"died at {method}").exists():
            Path(f"died at {method}").touch()
            time.sleep(0.3)  # so that it is on its way
            os.kill(os.getpid(), signal.SIGKILL)

    setattr(GoalCarrier, method, sends)

for method in METHODS:
    deadly(method)
"""

PLAIN_CLIENT = """
import json, time
import rclpy
from action_msgs.srv import CancelGoal
from errands_interfaces.action import Errand
from rclpy.action import ActionClient

rclpy.init()
node = rclpy.create_node("plain")
errand, chore = (ActionClient(node, Errand, name) for name in ("/errand", "/chore"))
assert errand.wait_for_server(30) and chore.wait_for_server(30)
told = {}
ENDS = {4: "succeeded", 5: "canceled", 6: "aborted", 0: "unknown"}

def goal(place, number=0):
    made = Errand.Goal()
    made.token.place, made.token.number = place, number
    return made

def spin(future, seconds=20.0):
    rclpy.spin_until_future_complete(node, future, timeout_sec=seconds)
    return future.result() if future.done() else None

def send(client, place, number=0):
    heard = []
    handle = spin(client.send_goal_async(goal(place, number), heard.append))
    return handle, heard

def end(handle):
    result = spin(handle.get_result_async())
    return ENDS[result.status], result.result.token.number

def cancel(handle):
    return len(spin(handle.cancel_goal_async()).goals_canceling)

for client, name in ((errand, "errand"), (chore, "chore")):
    handle, _ = send(client, "fine", 7)
    told[name, "fine"] = handle.accepted, *end(handle)
    told[name, "too late"] = cancel(handle)
    told[name, "kept"] = end(handle)
    told[name, "break"] = end(send(client, "break", 8)[0])
    handle, heard = send(client, "long", 9)
    for _ in range(100):
        if not heard:
            rclpy.spin_once(node, timeout_sec=0.1)
    told[name, "cancel"] = len(heard), cancel(handle), *end(handle)
    handle, _ = send(client, "stubborn", 10)
    told[name, "unheeded"] = cancel(handle), *end(handle)

first, _ = send(chore, "long")
told["refused"] = first.accepted, send(chore, "fine")[0].accepted
told["refused", "end"] = cancel(first), *end(first)

several = [errand.send_goal_async(goal("long", number)) for number in (1, 2, 3)]
handles = [spin(future) for future in several[:2]]
told["waits"] = [spin(several[2], 0.5) is None, cancel(handles[0])]
third = spin(several[2])
told["accepted later"] = third.accepted
everything = node.create_client(CancelGoal, "/errand/_action/cancel_goal")
assert everything.wait_for_service(30)
told["all"] = len(spin(everything.call_async(CancelGoal.Request())).goals_canceling)
told["ends"] = [end(handle) for handle in (*handles, third)]
print(json.dumps({" ".join(key) if isinstance(key, tuple) else key: value for key, value in told.items()}))
rclpy.shutdown()
"""

PLAIN_SERVER = """
import rclpy, time
from errands_interfaces.action import Errand
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor

rclpy.init()
node = rclpy.create_node("plain")

def accept(goal):
    return GoalResponse.REJECT if goal.token.number % 5 == 4 else GoalResponse.ACCEPT

def work(handle):
    number, result = handle.request.token.number, Errand.Result()
    result.token.number = 100 + number
    feedback = Errand.Feedback()
    feedback.token.number, feedback.number = number, 1
    handle.publish_feedback(feedback)
    for _ in range(100):
        if number % 5 in (0, 3) or handle.is_cancel_requested:
            break
        time.sleep(0.1 if number % 5 == 1 else 0.03)
        if number % 5 == 2:
            break
    if handle.is_cancel_requested:
        handle.canceled()
    elif number % 5 == 3:
        handle.abort()
    else:
        handle.succeed()
    return result

for name in ("/errand", "/chore"):
    ActionServer(node, Errand, name, work, goal_callback=accept, callback_group=ReentrantCallbackGroup(),
                 cancel_callback=lambda goal: CancelResponse.ACCEPT)
print("serves", flush=True)
executor = MultiThreadedExecutor(8)
executor.add_node(node)
try:
    executor.spin()
except (KeyboardInterrupt, rclpy.executors.ExternalShutdownException):
    pass
"""


@pytest.fixture(scope="session")
def errand_workspace() -> Path:
    """A workspace with the interfaces of the model `errands`, built by the first run that needs it."""
    require_tools()
    WORKSPACE.mkdir(parents=True, exist_ok=True)
    with (WORKSPACE.parent / "errands_workspace.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # several test processes build one workspace
        generate(errands(), WORKSPACE, Options(source="errands.sym.xmi"))
        build_interfaces(WORKSPACE)
    return WORKSPACE


@pytest.fixture
def ros(errand_workspace: Path, tmp_path: Path, reach: Reach) -> Iterator[Ros]:
    """Processes on a domain of their own, ended at the end."""
    base = environment(errand_workspace)
    with claimed_domain(46) as domain:
        made = Ros(tmp_path, ros_environment(tmp_path / "ros", domain, reach, base))
        yield made
        for process in made.processes:
            if process.popen.poll() is None:
                process.popen.send_signal(signal.SIGINT)
        for process in made.processes:
            process.popen.wait(10)
    remove_abandoned()


def lay_out(ros: Ros, model: sym.SystemModel) -> None:
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")


def kill(ros: Ros, process: Process) -> None:
    os.kill(process.popen.pid, signal.SIGKILL)
    process.popen.wait(PATIENCE)
    ros.processes.remove(process)


def assert_conforms(ros: Ros, model: sym.SystemModel) -> None:
    found = traces_of_runs([ros.folder / "journal"])
    traces = {node: partial(read_trace, files) for node, files in found.items()}
    verdict = conform(model, traces)
    assert verdict.status == "conforms", (verdict.violations, verdict.unknown)


@pytest.mark.long
def test_all_paths_of_goals_of_a_plain_client(ros: Ros) -> None:
    lay_out(ros, errands())
    runner = ros.node("runner", handlers=OBEDIENT)
    told = json.loads(ros.script(PLAIN_CLIENT).splitlines()[-1])
    for name in ("errand", "chore"):
        assert told[f"{name} fine"] == [True, "succeeded", 7]
        assert told[f"{name} too late"] == 0
        assert told[f"{name} kept"] == ["succeeded", 7]
        assert told[f"{name} break"] == ["aborted", 8]
        assert told[f"{name} cancel"] == [1, 1, "canceled", 9]
        assert told[f"{name} unheeded"] == [1, "succeeded", 10]
    assert told["refused"] == [True, False]
    assert told["refused end"] == [1, "canceled", 0]
    assert told["waits"] == [True, 1]
    assert told["accepted later"] is True
    assert told["all"] == 2
    assert sorted(told["ends"]) == [["canceled", 1], ["canceled", 2], ["canceled", 3]]
    assert runner.interrupt() == 0, runner.output()
    ends = [(record["channel"], record["outcome"]) for record in ros.records("runner", "finish")]
    assert len(ends) == len(ros.records("runner", "accept")) == 12
    assert len(ros.records("runner", "canceling")) == 2 * 2 + 1 + 3
    assert [record["unheeded"] is not None for record in ros.records("runner", "finish")].count(True) == 2


def outcomes(ros: Ros, channel: str) -> dict[int, str]:
    """Return how the boss's goals ended, by their number; each has ended once."""
    found: dict[int, str] = {}
    for event in ("outcome", "reject"):
        for record in ros.records("boss", event):
            if record["channel"] == channel:
                number = record["data"]["number"] % 100
                assert number not in found
                found[number] = record.get("outcome", "rejected")
    return found


@pytest.mark.long
def test_all_paths_of_goals_of_a_plain_server(ros: Ros) -> None:
    lay_out(ros, errands(goals=5))
    server = ros.folder / "server.py"
    server.write_text(PLAIN_SERVER)
    boss = ros.node("boss", {"request_timeout": 2.0}, handlers=RECALLS)
    time.sleep(0.5)  # its first goals wait for a server
    ros.start("plain", server)
    for channel in ("Errand", "Chore"):
        ros.wait(lambda: len(outcomes(ros, channel)) == 5, f"the end of all goals of {channel}")  # noqa: B023
        assert outcomes(ros, channel) == {
            1: "canceled", 2: "succeeded", 3: "aborted", 4: "rejected", 5: "succeeded"
        }  # fmt: skip
    assert boss.interrupt() == 0, boss.output()
    assert len(ros.records("boss", "hear")) == 2 * 4
    canceled = [record["message"] for record in ros.records("boss", "cancel")]
    ends = {record["message"]: record["outcome"] for record in ros.records("boss", "outcome")}
    assert [ends[goal] for goal in canceled] == ["canceled"] * 2


@pytest.mark.long
def test_killed_nodes_lose_and_repeat_no_goal(ros: Ros) -> None:
    """Client and server are killed in turn; each goal ends once, as it was worked on, at both ends."""
    lay_out(ros, errands(goals=12, outstanding=2))
    draw = random.Random(7)
    running = {
        node: ros.node(node, {"request_timeout": 0.5}, handlers=handlers)
        for node, handlers in (("runner", SLOW), ("boss", RECALLS))
    }
    for _ in range(8):
        time.sleep(draw.uniform(0.3, 0.9))
        node = draw.choice(("runner", "boss"))
        kill(ros, running[node])
        handlers = SLOW if node == "runner" else RECALLS
        running[node] = ros.node(node, {"request_timeout": 0.5}, handlers=handlers)
    for channel in ("Errand", "Chore"):
        ros.wait(lambda: len(outcomes(ros, channel)) == 12, f"the end of all goals of {channel}")  # noqa: B023
    assert [process.interrupt() for process in running.values()] == [0, 0]
    accepted = [record["message"] for record in ros.records("runner", "accept")]
    finished = {record["message"]: record["outcome"] for record in ros.records("runner", "finish")}
    assert sorted(finished) == sorted(accepted) == sorted(set(accepted))
    heard = {record["message"]: record["outcome"] for record in ros.records("boss", "outcome")}
    assert heard == finished
    assert_conforms(ros, errands(goals=12, outstanding=2))
    begun = ros.fired("runner", "Errand[1].TBeginErrand") + ros.fired("runner", "Errand[2].TBeginErrand")
    assert len(begun) == 12


@pytest.mark.long
@pytest.mark.parametrize(
    ("node", "methods"),
    [("boss", ("send_goal", "cancel_goal")), ("runner", ("give_feedback", "finish_goal"))],
)
def test_a_node_that_dies_before_it_records(ros: Ros, node: str, methods: tuple[str, ...]) -> None:
    """What it had sent, it sends again as the same: nothing is worked on, heard or ended twice."""
    lay_out(ros, errands(goals=2))
    handlers = {"boss": RECALLS, "runner": SLOW}
    deadly = DEADLY.replace("METHODS", repr(methods)) + handlers[node]
    other = "runner" if node == "boss" else "boss"
    running = {other: ros.node(other, {"request_timeout": 0.5}, handlers=handlers[other])}
    for _ in methods:
        dying = ros.node(node, {"request_timeout": 0.5}, handlers=deadly)
        dying.popen.wait(PATIENCE)
        ros.processes.remove(dying)
    running[node] = ros.node(node, {"request_timeout": 0.5}, handlers=deadly)
    for channel in ("Errand", "Chore"):
        ros.wait(lambda: len(outcomes(ros, channel)) == 2, f"the end of all goals of {channel}")  # noqa: B023
    assert [process.interrupt() for process in running.values()] == [0, 0]
    assert_conforms(ros, errands(goals=2))
    assert len(ros.records("runner", "feedback")) == len(ros.records("runner", "accept"))


CHANGE = """
import sys
import rclpy
from lifecycle_msgs.srv import ChangeState
from lifecycle_msgs.msg import Transition
rclpy.init()
node = rclpy.create_node("somebody")
for name, id in zip(sys.argv[1::2], map(int, sys.argv[2::2])):
    client = node.create_client(ChangeState, f"/{name}/change_state")
    assert client.wait_for_service(30)
    future = client.call_async(ChangeState.Request(transition=Transition(id=id)))
    rclpy.spin_until_future_complete(node, future, timeout_sec=30)
    print(future.result().success)
"""
CONFIGURE, CLEAN_UP, ACTIVATE, DEACTIVATE = range(1, 5)


def change(ros: Ros, *changes: str | int) -> None:
    """Change the state of nodes, one after the other."""
    said = ros.script(CHANGE.replace("sys.argv[", f"{['', *map(str, changes)]}["))
    assert said == "True\n" * (len(changes) // 2)


def managed_errands() -> sym.SystemModel:
    model = errands(goals=4, outstanding=2)
    for name in ("runner", "boss"):
        find(model, name, sym.NodeNet).lifecycle = sym.Lifecycle(deactivates=True, cleansUp=True)
    return model


@pytest.mark.long
def test_goals_of_managed_nodes(ros: Ros) -> None:
    """They wait for a server that is not there, and continue while it is inactive, or when it comes again."""
    lay_out(ros, managed_errands())
    running = [
        ros.node(node, {"request_timeout": 0.5}, handlers=handlers)
        for node, handlers in (("runner", SLOW), ("boss", NEVER_RECALLS))
    ]
    change(ros, "boss", CONFIGURE)
    ros.wait(lambda: ros.records("boss", "goal"), "goals that are sent")
    assert ros.records("runner", "accept") == []
    change(ros, "runner", CONFIGURE)
    ros.wait(lambda: ros.records("runner", "finish"), "a goal that an inactive node works on")
    change(ros, "runner", ACTIVATE, "runner", DEACTIVATE, "runner", CLEAN_UP)
    change(ros, "boss", CLEAN_UP, "runner", CONFIGURE, "boss", CONFIGURE)
    for channel in ("Errand", "Chore"):
        ros.wait(lambda: len(outcomes(ros, channel)) == 4, f"the end of all goals of {channel}")  # noqa: B023
    assert [process.interrupt() for process in running] == [0, 0]
    accepted = [record["message"] for record in ros.records("runner", "accept")]
    finished = [record["message"] for record in ros.records("runner", "finish")]
    assert sorted(finished) == sorted(accepted) == sorted(set(accepted))
    assert_conforms(ros, managed_errands())


@pytest.mark.long
def test_a_goal_that_its_server_has_lost_counts_as_aborted(ros: Ros) -> None:
    lay_out(ros, errands(goals=1))
    server = ros.folder / "server.py"
    server.write_text(PLAIN_SERVER)
    plain = ros.start("plain", server)
    boss = ros.node("boss", {"request_timeout": 0.5}, handlers=NEVER_RECALLS)
    ros.wait(lambda: len(ros.records("boss", "accepted")) == 2, "two goals")
    kill(ros, plain)
    ros.start("plain", server)
    for channel in ("Errand", "Chore"):
        ros.wait(lambda: outcomes(ros, channel), f"the end of the goal of {channel}")  # noqa: B023
    assert [record["outcome"] for record in ros.records("boss", "outcome")] == ["aborted"] * 2
    assert ["has lost the goal" in record["error"] for record in ros.records("boss", "error")] == [True] * 2
    assert boss.interrupt() == 0
