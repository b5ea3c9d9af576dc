"""Callbacks in Python that wait for goals of actions block in the model as they do when they run."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.cli.main import main

HEAD = """
import time
import rclpy
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from example_interfaces.action import Fibonacci
"""
SERVER = """
class Server(Node):
    def __init__(self):
        super().__init__("server")
        self.server = ActionServer(self, Fibonacci, "/fib", self.execute)
    def execute(self, goal_handle):
        goal_handle.succeed()
        return Fibonacci.Result()
rclpy.init()
rclpy.spin(Server())
"""
CLIENT = """
class Client(Node):
    def __init__(self):
        super().__init__("client")
        self.action = ActionClient(self, Fibonacci, "/fib"GROUP)
        self.create_timer(1.0, self.tick)
    TICK
rclpy.init()
executor = MultiThreadedExecutor(num_threads=THREADS)
executor.add_node(Client())
executor.spin()
"""
SEND = "self.action.send_goal_async(Fibonacci.Goal())"
TICKS = {
    "blocking": "def tick(self):\n        self.action.send_goal(Fibonacci.Goal())",
    "awaiting": f"async def tick(self):\n        goal = await {SEND}\n        if not goal.accepted:\n"
    "            return\n        await goal.get_result_async()",
    "polling": f"def tick(self):\n        future = {SEND}\n        while not future.done():\n"
    "            time.sleep(0.1)\n        result = future.result().get_result_async()\n"
    "        while not result.done():\n            time.sleep(0.1)",
    "only for the acceptance": f"async def tick(self):\n        goal = await {SEND}",
    "only for the result": f"def tick(self):\n        {SEND}.add_done_callback(self.accepted)\n"
    "    def accepted(self, future):\n        future.result().get_result()",
    "not at all": f"def tick(self):\n        {SEND}",
}


def _found(folder: Path, tick: str, group: str, threads: int) -> list[str]:
    """Return the rules of the findings of `check`, without those of queues."""
    source = folder / "src"
    source.mkdir()
    (source / "server.py").write_text(HEAD + SERVER)
    text = CLIENT.replace("TICK", TICKS[tick]).replace("GROUP", group).replace("THREADS", str(threads))
    (source / "client.py").write_text(HEAD + text)
    shown = CliRunner().invoke(main, ["check", "-q", "--source", str(source)]).stdout
    lines = [line for line in shown.splitlines() if line.startswith(("error", "warning"))]
    return [line.rpartition("[")[2].rstrip("]") for line in lines]


@pytest.mark.long
@pytest.mark.parametrize("tick", TICKS)
def test_one_group_and_one_thread(tmp_path: Path, tick: str) -> None:
    waits = {"not at all": [], "only for the result": ["code-waits-for-itself"]}
    assert _found(tmp_path, tick, "", 1) == waits.get(tick, ["callback-deadlock"])


@pytest.mark.long
@pytest.mark.parametrize("tick", [each for each in TICKS if each != "only for the result"])
def test_the_group_is_enough_to_block(tmp_path: Path, tick: str) -> None:
    assert _found(tmp_path, tick, "", 3) == ([] if tick == "not at all" else ["callback-deadlock"])


@pytest.mark.long
@pytest.mark.parametrize("tick", TICKS)
def test_a_group_and_a_thread_for_the_client(tmp_path: Path, tick: str) -> None:
    assert _found(tmp_path, tick, ", callback_group=ReentrantCallbackGroup()", 3) == []


CPP = """
#include <rclcpp/rclcpp.hpp>
#include <rclcpp_action/rclcpp_action.hpp>
using namespace std::chrono_literals;
using Fibonacci = example_interfaces::action::Fibonacci;
class Client : public rclcpp::Node {
 public:
  Client() : Node("client") {
    action_ = rclcpp_action::create_client<Fibonacci>(this, "/fib");
    timer_ = create_wall_timer(1s, std::bind(&Client::tick, this));
  }
  void tick() {
    auto goal = action_->async_send_goal(Fibonacci::Goal()).get();
    if (!goal) { return; }
    auto result = action_->async_get_result(goal).get();
  }
  rclcpp_action::Client<Fibonacci>::SharedPtr action_;
  rclcpp::TimerBase::SharedPtr timer_;
};
int main(int argc, char ** argv) {
  rclcpp::init(argc, argv);
  rclcpp::spin(std::make_shared<Client>());
}
"""


@pytest.mark.long
def test_futures_of_cpp_and_all_that_follows_from_their_wait(tmp_path: Path) -> None:
    """Two changes together fix it: a group of its own for the client, and a second thread."""
    pytest.importorskip("tree_sitter_cpp")
    source = tmp_path / "src"
    source.mkdir()
    (source / "server.py").write_text(HEAD + SERVER)
    (source / "client.cpp").write_text(CPP)
    shown = CliRunner().invoke(main, ["check", "-q", "--source", str(source)]).stdout
    lines = [line for line in shown.splitlines() if line.startswith(("error", "warning"))]
    assert [line.rpartition("[")[2] for line in lines] == ["callback-deadlock]"], shown
