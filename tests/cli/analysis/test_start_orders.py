"""``dineros check --suggest-start-order``, and what a check says of managed nodes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.ros2_systems.managed_systems import camera, talk


@pytest.fixture
def model(tmp_path: Path) -> Path:
    save(camera(), tmp_path / "camera.sym.xmi")
    return tmp_path / "camera.sym.xmi"


def test_the_order_that_is_printed_is_safe(run: Run, model: Path) -> None:
    said = run("check", model, "--suggest-start-order").stdout
    lines = [line for line in said.splitlines() if "--set" in line]
    assert [line.split(":")[0] for line in lines[:2]] == ["configure display", "configure detector"]
    assert "proved: in this order, no message is lost while the nodes come up" in said
    settings = [part for line in lines for part in ("--set", line.split("--set ")[1])]
    more = ("--set", "display.lifecycle.cleansUp=false", "--set", "camera.lifecycle.deactivates=false")
    rules = json.loads(run("check", model, *settings, *more, "--json").stdout)["findings"]
    assert {each["rule"] for each in rules} <= {
        *("queue-overflow", "not-live", "not-reversible", "no-home-marking"),
    }
    report = json.loads(run("check", model, "--suggest-start-order", "--json").stdout)
    assert [each["setting"] for each in report["order"]] == settings[1::2]


def test_wrong_use(run: Run, model: Path, tmp_path: Path) -> None:
    save(talk(), tmp_path / "talk.sym.xmi")
    said = run("check", tmp_path / "talk.sym.xmi", "--suggest-start-order").stderr
    assert "no node net has a lifecycle" in said
    said = run("check", model, "--suggest-start-order", "--suggest-capacities").stderr
    assert "--suggest-capacities cannot be combined with --suggest-start-order" in said
