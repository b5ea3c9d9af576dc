"""A hint names what is likely meant, and is absent where nothing is."""

from __future__ import annotations

import pytest

from dineros.metamodel.errors import near_matches


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("tokns", "tokens"),
        ("Shwon", "Shown"),
        ("initialmarking", "initialMarking"),
        ("ready_to_go", "ReadyToGo"),
        ("Entry", "SensorEntry"),
        ("validat", "validate"),
        ("p1", "p10"),
        ("okay", "ok"),
        ("LeftCelObject", "LeftCellObjects"),
    ],
)
def test_what_is_near(name: str, known: str) -> None:
    assert near_matches(name, ["far away", known]) == f"did you mean {known!r}?"


@pytest.mark.parametrize(
    ("name", "known"),
    [
        ("kind", "id"),
        ("distribution", "description"),
        ("x", "y"),
        ("places", "planes are here"),
        ("", "x"),
    ],
)
def test_what_is_only_similar(name: str, known: str) -> None:
    assert near_matches(name, [known]) is None
