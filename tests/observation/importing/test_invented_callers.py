"""Programs outside of the code call its services again and again, and several at a time."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.importing.whole.triggers import used_by_themselves
from dineros.observation.systems import Endpoint, ObservedNode
from tests.support.programs.coded import files, run

ONCE = """
class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.armed = False
        self.other = self.create_client(Trigger, 'other')
        self.create_service(Trigger, 'arm', self.arm)
        self.create_service(Trigger, 'other', self.answer)

    def answer(self, request, response):
        return response

    def arm(self, request, response):
        if self.armed:
            WAIT
        self.armed = True
        return response

def main():
    rclpy.init()
    rclpy.spin(Robot())
"""
AT_ONCE = """
class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        group = ReentrantCallbackGroup()
        self.other = self.create_client(Trigger, 'other', callback_group=group)
        self.create_service(Trigger, 'arm', self.arm, callback_group=group)
        self.create_service(Trigger, 'other', self.answer, callback_group=group)

    def answer(self, request, response):
        return response

    def arm(self, request, response):
        WAIT
        return response

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(THREADS)
    executor.add_node(Robot())
    executor.spin()
"""
LOCKS = """
import threading
from std_srvs.srv import SetBool

class Robot(Node):
    def __init__(self):
        super().__init__('robot')
        self.one, self.two = threading.Lock(), threading.Lock()
        group = GROUP()
        self.create_service(SetBool, 'arm', self.arm, callback_group=group)

    def arm(self, request, response):
        if request.data:
            with self.one:
                with self.two:
                    pass
        else:
            with self.two:
                with self.one:
                    pass
        return response

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(4)
    executor.add_node(Robot())
    executor.spin()
"""
CALL = "self.other.call(Trigger.Request())"
ASK = "self.other.call_async(Trigger.Request())"


@pytest.mark.parametrize(("wait", "has_deadlock"), [(CALL, True), (ASK, False)])
def test_the_second_call_of_a_service_may_hang(tmp_path: Path, wait: str, has_deadlock: bool) -> None:
    """An invented caller that waited for itself called once only: this was "0 found, 3 proved"."""
    _, text = run("check", "-q", "--source", files(tmp_path, robot=ONCE.replace("WAIT", wait)))
    assert ("[callback-deadlock]" in text) == has_deadlock, text


@pytest.mark.parametrize(
    ("wait", "threads", "has_deadlock"), [(CALL, "2", True), ("pass", "2", False), (CALL, "4", False)]
)
def test_callers_together_may_hold_all_threads(
    tmp_path: Path, wait: str, threads: str, has_deadlock: bool
) -> None:
    source = files(tmp_path, robot=AT_ONCE.replace("WAIT", wait).replace("THREADS", threads))
    _, text = run("check", "-q", "--source", source)
    assert ("[callback-deadlock]" in text) == has_deadlock, text
    is_limited = wait == CALL and threads == "4"  # it would take four callers
    assert ("callers of service /arm outside of this code: more than 3 at a time" in text) == is_limited


@pytest.mark.parametrize(
    ("group", "has_fault"), [("ReentrantCallbackGroup", True), ("MutuallyExclusiveCallbackGroup", False)]
)
def test_runs_of_one_callback_may_take_locks_in_opposite_orders(
    tmp_path: Path, group: str, has_fault: bool
) -> None:
    source = files(tmp_path, robot=LOCKS.replace("GROUP", group))
    _, text = run("check", "-q", "--source", source)
    assert ("[code-holds-lock]" in text) == has_fault, text


EACH_OTHER = """
class NAME(Node):
    def __init__(self):
        super().__init__('NAME')
        self.other = self.create_client(Trigger, 'OTHER'GROUP)
        self.create_service(Trigger, 'NAME', self.answer)
        MORE

    def answer(self, request, response):
        self.other.call(Trigger.Request())
        return response

def main():
    rclpy.init()
    executor = MultiThreadedExecutor(2)
    executor.add_node(NAME())
    executor.spin()
"""


@pytest.mark.parametrize("ends", [False, True])
def test_nodes_that_start_only_each_other_are_called_from_outside(tmp_path: Path, ends: bool) -> None:
    """Nothing in the code calls /one or /two first, so no deadlock was found."""
    group = ", callback_group=MutuallyExclusiveCallbackGroup()"
    one = EACH_OTHER.replace("NAME", "one").replace("OTHER", "two").replace("GROUP", group)
    two = EACH_OTHER.replace("NAME", "two").replace("GROUP", group)
    two = two.replace("OTHER", "three" if ends else "one")
    source = files(tmp_path, one=one.replace("MORE", ""), two=two.replace("MORE", ""))
    _, text = run("check", "-q", "--source", source)
    assert ("[callback-deadlock]" in text) != ends, text
    assert "service-never-called" not in text


def test_what_a_timer_starts_is_used_step_by_step() -> None:
    def node(name: str, **ports: object) -> ObservedNode:
        return ObservedNode(name, **ports)  # type: ignore[arg-type]

    def does(*steps: tuple[str, str]) -> GivenCallback:
        return GivenCallback(does=tuple(Step(verb, name) for verb, name in steps))

    service = {each: Endpoint(each, "std_srvs/srv/Trigger") for each in ("/a", "/b", "/c", "/d")}
    nodes = [
        node("/timer", clients=(service["/a"],)),
        node("/one", servers=(service["/a"],), clients=(service["/b"],)),
        node("/two", servers=(service["/b"], service["/c"]), clients=(service["/d"],)),
        node("/three", servers=(service["/d"],), clients=(service["/c"],)),
    ]
    given = Given(
        nodes={
            "/timer": GivenNode(timers={"tick": 1.0}, callbacks={"tick": does(("call", "/a"))}),
            "/one": GivenNode(timers={}, callbacks={"/a": does(("call", "/b"))}),
            "/two": GivenNode(timers={}, callbacks={"/b": does(), "/c": does(("call", "/d"))}),
            "/three": GivenNode(timers={}, callbacks={"/d": does(("call", "/c"))}),
        }
    )
    assert used_by_themselves(nodes, given) == {("clients", "/a"), ("clients", "/b")}
    given.nodes["/two"].callbacks.pop("/b")  # type: ignore[attr-defined]  # what it does is open
    assert {name for _, name in used_by_themselves(nodes, given)} == {"/a", "/b", "/c", "/d"}
