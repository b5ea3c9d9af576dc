"""Answers without times say that they assume messages to be taken within their lifespans."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from dineros.analysis.model.lifespans import unexpired
from dineros.cli.main import main
from dineros.metamodel import sym
from dineros.metamodel.files import save
from tests.support.systems.talker import talker


def model(lifespan: float | None, middleware: sym.Middleware = sym.Middleware.ros2) -> sym.SystemModel:
    made = talker()
    made.middleware = middleware
    (channel,) = (each for each in made.channels if isinstance(each, sym.TopicChannel))
    if lifespan is not None:
        channel.qos = sym.QualityOfService(lifespan=lifespan)
    return made


def test_each_topic_with_a_lifespan_is_named() -> None:
    (text,) = unexpired(model(0.5))
    assert text.endswith("is older than its lifespan when it is taken")
    assert unexpired(model(None)) == unexpired(model(0.5, sym.Middleware.ros1)) == []


@pytest.mark.parametrize("lifespan", [None, 0.5])
def test_check_states_it_without_times_only(lifespan: float | None, tmp_path: Path) -> None:
    file = tmp_path / "talker.sym.xmi"
    save(model(lifespan), file)

    def output(*options: str) -> str:
        return CliRunner().invoke(main, ["check", "-q", str(file), *options]).output

    assert ("older than its lifespan when" in output()) is (lifespan is not None)
    assert "older than its lifespan when" not in output("--time", "--timeout", "20")
