"""A topic that falls silent although the model must continue is a finding; one that may rest is none."""

from __future__ import annotations

import pytest

from dineros.metamodel import sym
from dineros.observation.explaining import RecordingVerdict, explain
from dineros.observation.explaining.silences import Silence
from dineros.observation.importing.building import to_model
from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.systems import ObservedNode, ObservedSystem, TopicEndpoint
from tests.observation.explaining.reference import Message
from tests.observation.explaining.test_explain import recorded, sensor
from tests.observation.explaining.test_midway import CALL, asking

SECOND = 1_000_000_000


def robot(does: Step, mapper: Step | None = None) -> sym.SystemModel:
    """Return a lidar with a timer that does something twice a second, a clock, and perhaps a mapper."""
    kind = "std_msgs/msg/String"
    scan, map_, ticks = (TopicEndpoint(name, kind) for name in ("/scan", "/map", "/ticks"))
    nodes = [ObservedNode("/lidar", publishers=(scan,)), ObservedNode("/clock", publishers=(ticks,))]
    given = {
        "/lidar": GivenNode(timers={"tick": 0.5}, callbacks={"tick": GivenCallback(does=(does,))}),
        "/clock": GivenNode(
            timers={"tick": 1.0}, callbacks={"tick": GivenCallback(does=(Step("publish", "/ticks"),))}
        ),
    }
    if mapper is not None:
        nodes.append(ObservedNode("/mapper", publishers=(map_,), subscribers=(scan,)))
        given["/mapper"] = GivenNode(timers={}, callbacks={"/scan": GivenCallback(does=(mapper,))})
    return to_model(ObservedSystem("", nodes=tuple(nodes)), Given(given)).model


def until(**ends: float) -> list[Message]:
    """Return messages of each topic until it ends: twice a second, a little later for each topic."""
    found = [
        (f"/{topic}", int((0.5 * n + 0.1 * at) * SECOND))
        for at, (topic, end) in enumerate(ends.items())
        for n in range(int(end / 0.5) + 1)
    ]
    return sorted(found, key=lambda message: message[1])


def found(model: sym.SystemModel, messages: list[Message], midway: bool = False) -> RecordingVerdict:
    topics = recorded(*{topic for topic, _ in messages})
    return explain(model, topics, messages, midway=midway)


ONCE, MAYBE = Step("publish", "/scan"), Step("publish", "/scan", "?")
MAPS, MAYBE_MAPS = Step("publish", "/map"), Step("publish", "/map", "?")


@pytest.mark.parametrize("midway", [False, True])
def test_a_timer_that_stops_is_found(midway: bool) -> None:
    verdict = found(robot(ONCE), until(scan=10.0, ticks=29.0), midway)
    assert verdict.status == "violated" and verdict.unexplained is None
    assert verdict.silences == (Silence("/scan", 19.1, 0.5),)
    assert str(verdict.silences[0]) == (
        "nothing on /scan for 19.1 s; until then every 0.5 s; the model must continue"
    )
    assert verdict.to_dict("")["silences"] == [{"topic": "/scan", "seconds": 19.1, "every": 0.5}]


@pytest.mark.parametrize(
    ("model", "messages"),
    [
        (robot(MAYBE), until(scan=10.0, ticks=29.0)),
        (robot(ONCE), until(scan=27.5, ticks=29.0)),
        (robot(ONCE), until(scan=1.0, ticks=29.0)),
        (robot(ONCE), [*[("/scan", t * SECOND) for t in (0, 1, 2, 3, 4, 19, 20)],
                       *[("/ticks", t * SECOND) for t in range(21, 200)]]),
        (robot(ONCE), until(scan=10.0, ticks=10.0)),
        (robot(ONCE, MAPS), until(scan=10.0, map=10.0)),
        (robot(ONCE, MAYBE_MAPS), until(scan=29.0, map=10.0, ticks=29.0)),
    ],
    ids=["may rest", "not long", "few", "uneven", "all end", "all of it ends", "may leave it"],
)  # fmt: skip
def test_what_may_rest_is_not_found(model: sym.SystemModel, messages: list[Message]) -> None:
    verdict = found(model, messages)
    assert (verdict.status, verdict.silences) == ("conforms", ())


def test_a_node_that_stops_to_answer_is_found() -> None:
    verdict = found(robot(ONCE, MAPS), until(scan=29.0, map=10.0, ticks=29.0))
    assert [each.topic for each in verdict.silences] == ["/map"]


def test_of_a_chain_the_first_that_stops_is_found() -> None:
    """The mapper has nothing to map: that is not a fault of its own."""
    verdict = found(robot(ONCE, MAPS), until(scan=10.0, map=10.0, ticks=29.0))
    assert [each.topic for each in verdict.silences] == ["/scan"]


def test_a_model_that_can_be_stuck_explains_the_silence() -> None:
    """The client waits forever in the model as well, so that nothing has to come."""
    messages = [*[(CALL[at], at * SECOND) for at in range(3)]]
    assert found(asking(None), messages).silences == ()


def test_a_model_that_waits_for_another_explains_the_silence() -> None:
    model, messages = sensor()
    ends = max(time for _, time in messages)
    more = [("/dones", ends + n * SECOND) for n in range(1, 100)]
    assert explain(model, recorded("/scans", "/dones"), [*messages, *more]).silences == ()
