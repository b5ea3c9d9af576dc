"""Loops of callbacks that poll variables: the model has the wait, or else the code's finding stands."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.observation.importing.coded import coded
from dineros.observation.importing.flows.deciding import MOST_EDGES
from dineros.sources.reading import read_source
from tests.support.programs.coded import files

ROBOT = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.ready = False
        self.out = self.create_publisher(String, "out", 10)
        self.create_subscription(String, "in", self.heard, 10)
        self.create_service(Trigger, "go", self.go)
    def heard(self, message):
        self.ready = True
    def go(self, request, response):
        BEFORE
        while not self.ready:
            time.sleep(0.1)
        return response
def main():
    rclpy.init()
    executor = MultiThreadedExecutor(num_threads=2)
    executor.add_node(Robot())
    executor.spin()
if __name__ == "__main__":
    main()
"""
LARGE = "\n        ".join(
    f"if request.x{number}: self.out.publish(String(data='{number}'))" for number in range(MOST_EDGES // 2)
)


@pytest.mark.parametrize(
    ("before", "is_modelled"),
    [("pass", True), (LARGE, False)],
    ids=["small", "more edges than the limit"],
)
def test_a_polled_wait_is_in_the_model_or_is_reported(tmp_path: Path, before: str, is_modelled: bool) -> None:
    """The wait of a callback that was too large was lost: neither the model nor the findings had it."""
    text = ROBOT.replace("BEFORE", before)
    read = [("src", read_source(files(tmp_path, robot=text)))]
    model = coded(read, "src")
    rules = [each.rule for each in code_findings(read, model.modelled)]
    assert ("ready" in model.given.nodes["/robot"].variables) is is_modelled
    assert any("waits for ready (polled" in line for line in model.lacks) is not is_modelled
    assert rules == ([] if is_modelled else ["code-waits-for-itself"])
    assert len(model.modelled) == is_modelled


MANY = """
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.poses = [None, None]
        self.limits = [0, 1]
        self.create_subscription(String, "in", self.heard, 10)
        self.create_service(Trigger, "go", self.go)
    def heard(self, message):
        self.poses[0] = message
    def go(self, request, response):
        while TEST:
            time.sleep(0.1)
        return response
def main():
    rclpy.init()
    rclpy.spin(Robot())
if __name__ == "__main__":
    main()
"""


@pytest.mark.parametrize(
    "test",
    [
        "any(each is None for each in self.poses)",
        "not all([each is not None for each in self.poses])",
        "len([each for each in self.poses if each]) < 2",
        "any(p is None for p in self.poses) and rclpy.ok()",
        "sum(1 for each in self.poses if each) < len(self.limits)",
    ],
)
def test_a_test_of_many_elements_is_polled(tmp_path: Path, test: str) -> None:
    """What ends it was not known, so that proofs were under an assumption."""
    found = code_findings([("src", read_source(files(tmp_path, robot=MANY.replace("TEST", test))))])
    assert [each.rule for each in found] == ["code-waits-for-itself"]
