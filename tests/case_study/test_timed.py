"""The case study with times: the file is what the script makes, and the bound of its stop is least."""

from __future__ import annotations

from pathlib import Path

import pytest

from case_study.build import HOME
from case_study.timed import STOP, build_timed
from dineros.analysis.answers.budget import Budget
from dineros.analysis.questions.engines import IN_PART
from dineros.analysis.requirements.asking import question_of
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.files import save

pytestmark = pytest.mark.usefixtures("own_time")

SECONDS = Budget(seconds=120)


def test_the_committed_file_is_what_the_script_makes(tmp_path: Path) -> None:
    model = build_timed()
    assert validate(model) == []
    save(model, tmp_path / "timed.sym.xmi")
    assert (tmp_path / "timed.sym.xmi").read_text() == (HOME / "timed.sym.xmi").read_text()


def one_object(bound: float) -> sym.SystemModel:
    """Return the model with one object, and a bound of the stop."""
    model = build_timed()
    for color in ("Blue", "Green"):
        pool = find(model, f"{color}Objects", sym.Place)
        pool.balloons.clear()
        pool.tokens = 0
    (stop,) = model.properties
    stop.text = stop.text.replace(str(STOP), str(bound))
    return model


@pytest.mark.long
@pytest.mark.parametrize(("bound", "expected"), [(STOP, "holds"), (STOP - 0.001, "violated")])
def test_the_bound_of_the_stop_is_the_least(bound: float, expected: str) -> None:
    """Latency, reaction, sensor, latency, reaction, reaction: 5 + 20 + 40 + 5 + 20 + 20 ms."""
    model = one_object(bound)
    (stop,) = model.properties
    assert question_of(stop, timed_base_subject(model)).answer(SECONDS, None).status == expected


@pytest.mark.long
def test_a_part_proves_the_bound_with_all_objects() -> None:
    model = build_timed()
    (stop,) = model.properties
    answer = question_of(stop, timed_base_subject(model)).answer(SECONDS, None)
    assert answer.status == "holds"
    assert answer.by.endswith(IN_PART)


@pytest.mark.long
def test_a_check_finds_nothing_and_leaves_nothing_open() -> None:
    report = check_timed(build_timed(), SECONDS)
    assert [each for each in report.findings if each.severity != "note"] == []
    assert report.unknown == []


def test_a_slow_sensor_breaks_the_bound() -> None:
    model = one_object(STOP)
    find(model, "TSense", sym.Transition).interval = pn.TimeInterval(earliest=0.02, latest=0.06)
    (stop,) = model.properties
    assert question_of(stop, timed_base_subject(model)).answer(SECONDS, None).status == "violated"
