"""The robot of `examples/foreign`, mended, is recorded, and conforms to the model that is imported of it."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.explaining import explain
from dineros.observation.importing.building import to_model
from dineros.observation.systems import RecordedTopic
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.foreign import SECOND, given, record, robot, running

pytest.importorskip("rclpy")

TOPICS = len({port.topic for node in robot().nodes for port in node.publishers})


def test_the_mended_robot_conforms(tmp_path: Path) -> None:
    """Some seconds of it; `benchmarks/foreign_robot.py` has over 10,000 messages."""
    with claimed_domain() as domain:
        environment = ros_environment(tmp_path / "ros", domain)
        with running(environment, "--mended"):
            for attempt in range(6):  # a busy machine starts slowly
                messages = record(tmp_path / f"bag{attempt}", environment, 7.0)
                topics = {topic for topic, _ in messages}
                if len(topics) == TOPICS and len(messages) > 100:
                    break
    remove_abandoned()
    assert len(topics) == TOPICS
    assert len(messages) > 100
    model = to_model(robot(mended=True), given(mended=True)).model
    recorded = [RecordedTopic(topic, "") for topic in sorted(topics)]
    verdict = explain(model, recorded, messages, midway=True)
    assert (verdict.status, verdict.messages) == ("conforms", len(messages))

    # More paths than there can be requests for: nobody asked for them.
    late = messages[-1][1] + SECOND
    verdict = explain(model, recorded, [*messages, *[("/path", late)] * 20], midway=True)
    assert verdict.status == "violated" and verdict.unexplained is not None
    assert verdict.unexplained.number > len(messages)
    assert "/path" not in verdict.unexplained.possible
