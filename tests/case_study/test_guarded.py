"""The case study where data decides: its requirements hold, and fail where a decision is missing."""

from __future__ import annotations

from pathlib import Path

import pytest

from case_study.build import HOME, build
from case_study.guarded import build_guarded
from dineros.analysis.checks.check import check
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find, places
from dineros.metamodel.files import save


def violated(model: sym.SystemModel) -> set[str]:
    """Return the ids of the properties that do not hold; all have an answer."""
    report = check(model)
    ids = {each.id for each in model.properties}
    about = [each for each in report.findings if each.rule in ("property-violated", "property-holds")]
    assert not any(id in str(each) for each in report.unknown for id in ids)
    return {id for id in ids for each in about if f"property {id} " in str(each)}


def test_the_committed_file_is_what_the_script_makes(tmp_path: Path) -> None:
    model = build_guarded()
    assert validate(model) == []
    save(model, tmp_path / "guarded.sym.xmi")
    assert (tmp_path / "guarded.sym.xmi").read_text() == (HOME / "guarded.sym.xmi").read_text()


def test_no_places_stand_for_what_the_sensor_saw() -> None:
    gone = {each.id for each in places(build())} - {each.id for each in places(build_guarded())}
    assert gone == {"Safe", "Unsafe"}


def test_all_requirements_are_proved() -> None:
    assert violated(build_guarded()) == set()


@pytest.mark.long
@pytest.mark.parametrize(
    ("transition", "expected"),
    [
        ("TPick", {"ArmsWaitForHumans"}),
        ("TStartPlaceL", {"PlacesWhatIsPicked", "AbortsPlaceNothing"}),
        ("TShowResult", {"ShowsWhatIsPlaced"}),
    ],
)
def test_a_missing_guard_is_found(transition: str, expected: set[str]) -> None:
    model = build_guarded()
    find(model, transition, sym.Transition).guard = None
    assert violated(model) == expected


@pytest.mark.long
def test_an_answer_that_is_not_handed_on_is_found() -> None:
    """The server that takes control back drops whether the object was placed: anything may be shown."""
    model = build_guarded()
    find(model, "TEnd", sym.Transition).assigns = None
    assert violated(model) == {"ShowsWhatIsPlaced"}
