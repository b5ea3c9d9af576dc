"""Conditions on the marking of a running application."""

from __future__ import annotations

import pytest

from dineros.analysis.logic.language.conditions import Condition
from dineros.analysis.logic.language.errors import FormulaError

PLACES = ["Shown", "Pick[1].Run", "Pick[2].Run"]
MARKING = {"Shown": 2, "Pick[1].Run": 1, "Pick[2].Run": 1}


@pytest.mark.parametrize(
    ("text", "holds"),
    [
        ("Shown >= 2", True),
        ("Shown != 2 | Run == 2", True),
        ("Pick[2].Run - Shown > 0", False),
        ("signal(Danger) -> Shown = 0", True),
        ("!signal(Danger) <-> false", False),
        ("true & Shown < 3", True),
    ],
)
def test_value(text: str, holds: bool) -> None:
    assert Condition(text, PLACES, ["Danger"])(MARKING, {"Danger": False}) is holds


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("Show >= 1", "no place is named 'Show'"),
        ("signal(Dangr)", "no signal is named 'Dangr'"),
        ("deadlock", "deadlock cannot be observed"),
        ("enabled(T)", "cannot be observed"),
        ("F Shown >= 1", "column 1"),
    ],
)
def test_what_is_no_condition(text: str, said: str) -> None:
    with pytest.raises(FormulaError, match=said):
        Condition(text, PLACES, ["Danger"])
