"""Properties in words that bound times."""

from __future__ import annotations

import pytest

from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.requirements.patterns import read_pattern


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("never A >= 1 within 5", "G[<=5] (!(A >= 1))"),
        ("always A >= 1 within 0.5", "G[<=1/2] (A >= 1)"),
        ("fired(T) happens within 1/3", "F[<=1/3] (fired(T))"),
        ("A >= 1 leads to B >= 1 within 2", "G ((A >= 1) -> F[<=2] (B >= 1))"),
        ("fired(T) leads to B >= 1 within 2", "G ((fired(T)) -> X F[<=2] (B >= 1))"),
    ],
)
def test_patterns(text: str, formula: str) -> None:
    reading = read_pattern(text)
    assert (reading.logic, str(reading.formula)) == ("ltl", formula)
    assert read_bounded(formula) == reading.formula


@pytest.mark.parametrize(
    "text",
    [
        "after fired(T): never A >= 1 within 5",
        "A >= 1 until B >= 1 within 5",
        "A >= 1 is possible within 5",
        "never within 5",
        "never A >= 1 within 1/0",
    ],
)
def test_what_cannot_be_bounded(text: str) -> None:
    with pytest.raises(FormulaError):
        read_pattern(text)


def test_a_name_may_be_within() -> None:
    assert str(read_pattern('never "within 5" >= 1').formula) == 'G !("within 5" >= 1)'
