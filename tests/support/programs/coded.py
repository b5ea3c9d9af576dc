"""Programs of Python as text, and the models of their code."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

from click.testing import CliRunner

from dineros.cli.main import main
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.observation.importing.building import to_model
from dineros.observation.importing.coded import Coded, coded
from dineros.sources.reading import Launch, read_source

HEAD = """
import rclpy, time
from rclpy.action import ActionClient, ActionServer
from rclpy.callback_groups import MutuallyExclusiveCallbackGroup, ReentrantCallbackGroup
from rclpy.executors import MultiThreadedExecutor, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.qos import qos_profile_sensor_data
from example_interfaces.action import Fibonacci
from std_msgs.msg import String
from std_srvs.srv import Trigger
"""
BATTERY = """
class Battery(Node):
    def __init__(self):
        super().__init__("battery")
        self.create_service(Trigger, "level", self.on_level)
    def on_level(self, request, response):
        return response
def main():
    rclpy.init()
    rclpy.spin(Battery())
if __name__ == "__main__":
    main()
"""
MONITOR = """
class Monitor(Node):
    def __init__(self):
        super().__init__("monitor")
        self.level = self.create_client(Trigger, "level"GROUP)
        self.create_timer(0.1, self.tick)
    def tick(self):
        self.ask()
    def ask(self):
        self.level.call(Trigger.Request())  # here
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Monitor())
    executor.spin()
if __name__ == "__main__":
    main()
"""


def files(folder: Path, **texts: str) -> Path:
    """Write programs."""
    for name, text in texts.items():
        (folder / f"{name}.py").write_text(HEAD + dedent(text))
    return folder


def read(folder: Path, launch: Launch | None = None) -> Coded:
    """Return what the code of a folder says."""
    return coded([("src", read_source(folder, launch=launch))], "src")


def model_of(folder: Path) -> sym.SystemModel:
    """Return the model of a folder, which is valid."""
    found = read(folder)
    model = to_model(found.system, found.given).model
    assert [each.message for each in validate(model) if each.severity == "error"] == []
    return model


def run(*words: object) -> tuple[int, str]:
    """Run a command; return its status and what it printed."""
    result = CliRunner().invoke(main, [str(word) for word in words])
    return result.exit_code, result.stdout


def steps(found: Coded, node: str) -> dict[str, list[str] | None]:
    """Return what the callbacks of a node do."""
    said = found.given.nodes[node].callbacks
    return {
        name: None if each.does is None else [str(step) for step in each.does] for name, each in said.items()
    }
