"""The robot of `examples/foreign`, recorded: its model explains that, and narrowed by it shows the fault."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.explaining import explain
from dineros.observation.importing.building import to_model
from dineros.observation.importing.given import Given
from dineros.observation.narrowing import Narrowed, narrowed, proposals, verbs_of
from dineros.observation.systems import RecordedTopic
from dineros.runtime.ros.process.domains import claimed_domain
from dineros.runtime.ros.process.environment import ros_environment
from dineros.runtime.ros.process.memory import remove_abandoned
from tests.support.systems.foreign import NESTED, SECOND, given, record, robot, running, search

pytest.importorskip("rclpy")

TOPICS = {port.topic for node in robot().nodes for port in node.publishers}
SILENT = {"/obstacles", "/path", "/mission", "/speed", "/odometry"}
"""What the robot does not say before it is fixed: no picture comes, and the first path is waited for."""

Messages = list[tuple[str, int]]


def recorded(path: Path, topics: set[str], *arguments: str) -> Messages:
    """Run the robot, and record it until these topics are heard."""
    messages: Messages = []
    with claimed_domain() as domain:
        environment = ros_environment(path / "ros", domain)
        with running(environment, *arguments):
            for attempt in range(6):  # a busy machine starts slowly
                messages = record(path / f"bag{attempt}", environment, 7.0)
                if {topic for topic, _ in messages} >= topics and len(messages) > 100:
                    break
    remove_abandoned()
    assert {topic for topic, _ in messages} >= topics
    assert len(messages) > 100
    return messages


def narrow(messages: Messages, fixed: bool) -> Narrowed:
    """Narrow the model of the robot by what it said; of nodes that call services, people say what they do."""
    known, system = given(fixed), robot(fixed)
    callers = [node.name for node in system.nodes if node.clients]
    said = Given({name: known.node(name) for name in [*callers, "/battery"]})
    topics = [RecordedTopic(topic, "") for topic in sorted({topic for topic, _ in messages})]
    found = proposals(system, messages, verbs=verbs_of(system, topics, said))
    accepted = [proposal for proposal in found if proposal.confidence >= 0.9]
    return narrowed(system, topics, lambda: messages, accepted, given=said, midway=True)


@pytest.mark.long
def test_the_fixed_robot_conforms_and_every_callback_ends(tmp_path: Path) -> None:
    """Some seconds of it; `benchmarks/running/foreign_robot.py` has over 10,000 messages."""
    messages = recorded(tmp_path, TOPICS, "--mended")
    model = to_model(robot(fixed=True), given(fixed=True)).model
    topics = [RecordedTopic(topic, "") for topic in sorted(TOPICS)]
    verdict = explain(model, topics, messages, midway=True)
    assert (verdict.status, verdict.messages) == ("conforms", len(messages))

    # More missions than there can be responses of the planner, which says a path before each. Paths without
    # missions are possible: the commander does not wait, and its history of responses can be full.
    late = messages[-1][1] + SECOND
    verdict = explain(model, topics, [*messages, *[("/mission", late)] * 30], midway=True)
    assert verdict.status == "violated" and verdict.unexplained is not None
    assert verdict.unexplained.number > len(messages)
    assert verdict.unexplained.topic == "/mission"
    assert "/mission" not in verdict.unexplained.possible and "/path" in verdict.unexplained.possible

    made = narrow(messages, fixed=True)
    assert made.verdict.status == "conforms" and made.accepted
    found = search(made.imported.model)
    assert (found.blocked, found.is_complete) == ((), True)


@pytest.mark.long
def test_narrowed_by_what_it_says_the_robot_is_found_to_wait_for_ever(tmp_path: Path) -> None:
    messages = recorded(tmp_path, TOPICS - SILENT)
    made = narrow(messages, fixed=False)
    assert made.verdict.status == "conforms" and made.accepted
    found = search(made.imported.model)
    assert [str(each.circle) for each in found.blocked] == [NESTED]
    assert found.is_complete
