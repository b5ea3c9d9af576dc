"""Assumptions of answers about all runs: shared services and actions, and lifespans without times."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from dineros.analysis.model.assumptions import assumptions
from dineros.cli.main import main
from dineros.metamodel import sym
from dineros.metamodel.files import save
from tests.support.ros2_systems.shared_services import shared_model
from tests.support.systems.talker import talker


def model(lifespan: float | None, middleware: sym.Middleware = sym.Middleware.ros2) -> sym.SystemModel:
    made = talker()
    made.middleware = middleware
    (channel,) = (each for each in made.channels if isinstance(each, sym.TopicChannel))
    if lifespan is not None:
        channel.qos = sym.QualityOfService(lifespan=lifespan)
    return made


def test_each_topic_with_a_lifespan_is_named_without_times() -> None:
    (text,) = assumptions(model(0.5), with_times=False)
    assert text == "no message of topic chatter is older than its lifespan when it is taken"
    assert assumptions(model(0.5), with_times=True) == assumptions(model(None), with_times=False) == []
    assert assumptions(model(0.5, sym.Middleware.ros1), with_times=False) == []


@pytest.mark.parametrize("middleware", ["ros1", "ros2"])
def test_shared_services_are_named_by_the_rules_of_ros2(middleware: str) -> None:
    shared = shared_model(2, middleware)
    assert len(assumptions(shared, with_times=True)) == (middleware == "ros2")


@pytest.mark.parametrize("lifespan", [None, 0.5])
def test_check_states_it_without_times_and_follows_it_with_times(
    lifespan: float | None, tmp_path: Path
) -> None:
    """A lifespan alone, without any other time of the model, is followed, too."""
    file = tmp_path / "talker.sym.xmi"
    save(model(lifespan), file)

    def report(*options: str) -> dict[str, Any]:
        result = CliRunner().invoke(main, ["check", "--json", str(file), *options])
        found: dict[str, Any] = json.loads(result.stdout)
        return found

    def expires(found: dict[str, Any]) -> bool:
        return any(each["rule"] == "message-expires" for each in found["findings"])

    without, with_times = report(), report("--time", "--timeout", "20")
    assert bool(without.get("assumes")) is (lifespan is not None)
    assert not with_times.get("assumes")
    assert (expires(without), expires(with_times)) == (False, lifespan is not None)
