"""The committed case study is what its script makes, and what the description says."""

from collections import Counter
from pathlib import Path

from case_study.build import HOME, build, build_one_topic
from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import node_nets, places, transitions
from dineros.metamodel.files import load, save
from tests.support.equality import differences


def test_the_committed_files_are_what_the_script_makes(tmp_path: Path) -> None:
    model = build()
    for name, made in (
        ("sorting.sym.xmi", model),
        ("sorting.pnml", model),
        ("one_topic.sym.xmi", build_one_topic()),
    ):
        save(made, tmp_path / name)
        assert (tmp_path / name).read_bytes() == (HOME / name).read_bytes(), (
            f"run case_study/build.py: {name}"
        )


def test_both_files_hold_the_same_model() -> None:
    assert differences(load(HOME / "sorting.sym.xmi"), load(HOME / "sorting.pnml")) == []


def test_the_model_violates_no_constraint() -> None:
    assert validate(load(HOME / "sorting.sym.xmi")) == []


def test_its_parts() -> None:
    model = build()
    assert [net.id for net in node_nets(model)] == [
        "selector",
        "controller",
        "synchronizer",
        "executor",
        "sensorics",
        "feedback",
    ]
    assert Counter(type(channel) for channel in model.channels) == {
        sym.TopicChannel: 3,
        sym.ServiceChannel: 5,
    }
    clauses = {
        transition.id: transition.clause.text
        for transition in transitions(model)
        if isinstance(transition, sym.Transition) and transition.clause
    }
    assert clauses == {
        "SelectRed": "Red",
        "SelectBlue": "Blue",
        "SelectGreen": "Green",
        "TStop": "Danger",
        "TPickSuccess": "(RobotIsIdle | RobotHasFinished) & ObjectIsPicked",
        "TPickFail": "(RobotIsIdle | RobotHasFinished) & !ObjectIsPicked",
        "TPlaceSuccess": "(RobotIsIdle | RobotHasFinished) & ObjectIsPlaced",
        "TPlaceFail": "(RobotIsIdle | RobotHasFinished) & !ObjectIsPlaced",
        "TSense": "Sensor",
    }
    marked = {place.id for place in places(model) if place.tokens}
    assert marked == {"RedObjects", "BlueObjects", "GreenObjects", "StateGet", "Unsafe"}
    assert not any(signal.initial for net in node_nets(model) for signal in net.signals)
    assert isinstance(model.pages[0], pn.Page)
