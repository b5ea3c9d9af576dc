"""The traces that the guide shows: the kept witness is one still, and the toy run is complete."""

from __future__ import annotations

import importlib.util
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import pytest

from dineros.analysis.model.subject import subject_of
from dineros.analysis.witnesses.first_cause import first_cause
from dineros.analysis.witnesses.witness import witness_of
from dineros.cli.presentation.traces import loads_of
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.metamodel.records import Header, read_records
from dineros.metamodel.records.schema import Step
from dineros.metamodel.settings import apply
from dineros.views.traces.reading import build
from tests.views.samples import CASE_STUDY
from tests.views.traces.test_building import marks

EXAMPLES = Path(__file__).resolve().parents[3] / "examples"
WITNESS = EXAMPLES / "sort_red_then_green.jsonl"


def case_study(*settings: str) -> sym.SystemModel:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    for setting in settings:
        apply(model, setting)
    return model


def test_the_witness_of_the_guide_is_one_and_shows_fig_18() -> None:
    header, *steps = read_records(WITNESS)
    assert isinstance(header, Header)
    assert header.signals == "io-enabled"
    model = case_study(*header.settings)
    subject = subject_of(model, "io-enabled")
    fired = [subject.transition_index[str(step.transition)] for step in steps if isinstance(step, Step)]
    replayed = witness_of(subject, fired)  # refuses what is not enabled
    assert [step.change for step in replayed.steps] == [
        step.change for step in steps if isinstance(step, Step)
    ]

    cause = first_cause(replace(replayed, loop=(header.loop or 0) - 1), header.property, header.verdict)
    assert cause is not None
    assert (header.cause, header.causes) == (cause.first, list(cause.steps))
    assert "TPickSuccess" in str(steps[cause.first - 1].transition)  # type: ignore[attr-defined]

    builder = build([WITNESS], model, loads_of(model, header))
    (asked,) = [mark for mark in marks(builder, "client", "GetControl", "R") if mark[1] == "q"]
    (answered,) = [mark for mark in marks(builder, "client", "GetControl", "R") if mark[1] == "a"]
    ended = [mark[0] for mark in marks(builder, "client", "EndControl", "L") if mark[1] == "s"]
    assert asked[0] < ended[0] < answered[0]  # the second cell gets control when the first gives it back
    picked, placed = (marks(builder, "client", name, "L") for name in ("Pick", "Place"))
    assert [mark[1] for mark in picked] == [mark[1] for mark in placed] == ["q", "s", "r", "a"]
    assert picked[-1][0] < placed[0][0]
    assert len([mark for mark in marks(builder, "client", "SensorService", "safety") if mark[1] == "q"]) >= 3
    for signal in ("Red", "Green", "Sensor", "ObjectIsPicked", "ObjectIsPlaced"):
        assert [1, *marks(builder, "signal", signal)][-1] != 1, signal
    for channel, place in (
        ("LeftCellObjects", "ReqControlL"),
        ("RightCellObjects", "ReqControlR"),
        ("UITopic", "Feedback"),
    ):
        assert "k" in [mark[1] for mark in marks(builder, "queue", channel, "subscriber", place)], channel


@pytest.fixture
def recorder() -> ModuleType:
    specification = importlib.util.spec_from_file_location("record_sorting", EXAMPLES / "record_sorting.py")
    assert specification is not None
    assert specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(module)
    return module


def test_the_run_of_the_guide_shows_fig_19(recorder: ModuleType, tmp_path: Path) -> None:
    model = case_study()
    recorder.record(model, str(CASE_STUDY), tmp_path / "run")
    builder = build([tmp_path / "run"], model)
    red, green = (marks(builder, "signal", name)[0][0] for name in ("Red", "Green"))
    place = {mark[1]: mark[0] for mark in marks(builder, "client", "Place", "L")}
    assert red < place["s"] < green < place["r"]  # green is chosen while red is placed
    right = {mark[1]: mark[0] for mark in marks(builder, "client", "GetControl", "R")}
    given_back = {mark[1]: mark[0] for mark in marks(builder, "client", "EndControl", "L")}
    assert right["q"] < given_back["s"] < right["a"]
    times = [step.time for step in builder.steps]
    assert None not in times
    assert builder.marking["Shown"] == 2
    handled = [
        step.details["handlers"] for step in builder.steps if step.transition == "SensorService[1].TSense"
    ]
    assert handled == [["look"]] * len(handled)
