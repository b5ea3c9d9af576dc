"""Grids of models."""

from __future__ import annotations

import pytest

from case_study.build import build
from dineros.analysis.sweeps import Axis, Grid, SweepError
from dineros.analysis.sweeps.grid import model_of, parse_model
from dineros.metamodel import pn
from dineros.metamodel.elements import find
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.metamodel.sym import Place


@pytest.mark.parametrize(
    ("text", "features", "values"),
    [
        ("A.tokens=0..3", ("A.tokens",), ("0", "1", "2", "3")),
        ("A.tokens=0..7..3", ("A.tokens",), ("0", "3", "6")),
        ("A.tokens=-1..1, 5", ("A.tokens",), ("-1", "0", "1", "5")),
        ("A.publisher.B.limit=1,2,5", ("A.publisher.B.limit",), ("1", "2", "5")),
        ("A.tokens,B.tokens=4..4", ("A.tokens", "B.tokens"), ("4",)),
        ("T.clause=Danger & !Sensor,Danger", ("T.clause",), ("Danger & !Sensor", "Danger")),
        ("C.qos.reliability=reliable,bestEffort", ("C.qos.reliability",), ("reliable", "bestEffort")),
    ],
)
def test_an_axis_is_read(text: str, features: tuple[str, ...], values: tuple[str, ...]) -> None:
    assert Axis.parse(text) == Axis(features, values)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("A.tokens", "not of the form"),
        ("A tokens=1", "not of the form"),
        ("A.tokens,=1", "not of the form"),
        ("A.tokens=", "empty value"),
        ("A.tokens=1,,2", "empty value"),
        ("A.tokens=2..1", "empty range"),
        ("A.tokens=0..4..0", "empty range"),
        ("A.tokens=0..1,1", "the value '1' twice"),
        ("A.tokens,A.tokens=1", "the feature 'A.tokens' twice"),
        ("A.tokens=0..1000000", "1000001 values .*--limit points=1000001"),
        ("A.tokens=0..1000000000", "1000000001 values"),
        ("A.tokens=0..99999,100000..199999", "'100000..199999' has 100000 values"),
        ("A.tokens=0..90000,90000", "the value '90000' twice"),
    ],
)
def test_a_wrong_axis_is_refused(text: str, says: str) -> None:
    with pytest.raises(SweepError, match=says):
        Axis.parse(text)


def test_points_come_in_the_order_of_the_axes_the_last_one_fastest() -> None:
    axes = (Axis.parse("A.tokens=0..1"), Axis.parse("B.tokens,C.tokens=7,5"))
    grid = Grid(axes, ("none", "io-enabled"), ("weighted",), (False, True))
    points = list(grid)
    assert len(points) == len(grid) == 16
    assert len({point.key for point in points}) == 16
    assert points[0].columns() == {
        "A.tokens": "0",
        "B.tokens": "7",
        "C.tokens": "7",
        "signals": "none",
        "overflow": "weighted",
        "reduced": False,
    }
    assert [point.reduced for point in points[:3]] == [False, True, False]
    assert [point.signals for point in points[:3]] == ["none", "none", "io-enabled"]
    assert [dict(point.settings)["B.tokens"] for point in points[::4]] == ["7", "5", "7", "5"]


def test_a_feature_cannot_stand_in_two_axes() -> None:
    with pytest.raises(SweepError, match=r"B\.tokens is varied twice"):
        Grid((Axis.parse("A.tokens,B.tokens=0"), Axis.parse("B.tokens=1")))


def test_a_grid_without_end_is_refused() -> None:
    with pytest.raises(SweepError, match="the grid has 4000000 points"):
        Grid(tuple(Axis.parse(f"{name}.tokens=0..1999") for name in "AB"))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("RedObject.tokens=1", "no element has the id or name 'RedObject'"),
        ("RedObjects.token=1", "'token' is not a feature"),
        ("RedObjects.tokens=1,many", "takes a whole number, not 'many'"),
        ("RedObjects.tokens=-1..1", ", RedObjects.tokens=-1, place 'RedObjects' holds -1 tokens"),
        (
            "LeftCellObjects.publisher.SortRed.limit=1,0",
            r", LeftCellObjects\.publisher\.SortRed\.limit=0, ",
        ),
    ],
)
def test_values_that_do_not_fit_the_model_are_found_before_the_work(text: str, says: str) -> None:
    with pytest.raises(DinerosError, match=says):
        Grid((Axis.parse("BlueObjects.tokens=0..1"), Axis.parse(text))).check(xmi_bytes(build()).decode())


def test_the_model_of_a_point() -> None:
    text = xmi_bytes(build()).decode()
    point = list(Grid((Axis.parse("RedObjects.tokens,BlueObjects.tokens=3,0"),)))[1]
    model = model_of(point, text)
    tokens = {name: find(model, f"{name}Objects", Place).tokens for name in ("Red", "Blue", "Green")}
    assert tokens == {"Red": 0, "Blue": 0, "Green": 1}
    assert find(parse_model(text), "RedObjects", Place).tokens == 1


def test_a_grid_of_more_points_than_can_be_counted_is_refused() -> None:
    axes = tuple(Axis.parse(f"{name}.tokens=0..9999") for name in "ABCDE")
    with pytest.raises(SweepError, match="the grid has 100000000000000000000 points"):
        Grid(axes)


def test_all_values_that_may_be_wrong_are_tried(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not each of 90 001 numbers, which all fit where the ends do: that would take minutes."""
    tried = []
    monkeypatch.setattr("dineros.metamodel.settings.apply", lambda _, setting: tried.append(setting))
    model = xmi_bytes(pn.Net(id="empty", pages=[pn.Page(id="page")])).decode()
    Grid((Axis.parse("A.tokens=0..90000,many"),)).check(model)
    assert {"A.tokens=0", "A.tokens=many"} <= set(tried)
    assert len(tried) < 10
