"""Truth values that strangers write: read, or refused in a short line."""

from __future__ import annotations

import pytest

from dineros.runtime.bridges.values import SignalValueError, read_signals, read_truth
from tests.runtime.bridges.test_hostile_input import DEEP, DIGITS


@pytest.mark.parametrize(
    "text",
    [
        *(DEEP, DIGITS, '{"a":' * 5000, '{"value":[true]}', "١"),
        *("true".ljust(70_000), "x" * 60_000),
    ],
)
def test_no_truth_value(text: str) -> None:
    with pytest.raises(SignalValueError) as caught:
        read_truth(text)
    assert len(str(caught.value)) < 120


@pytest.mark.parametrize(
    "text",
    [
        *("true", "[]", "", "{", '{"A": 2}', '{"A": null}'),
        f'{{"{"a" * 300}": true}}',
        '{"A": true}'.ljust(70_000),
    ],
)
def test_no_signals(text: str) -> None:
    with pytest.raises(SignalValueError):
        read_signals(text)


def test_signals() -> None:
    assert read_signals(b' {"A": true, "B": "off", "C": 1}') == {"A": True, "B": False, "C": True}
    assert read_signals("{}") == {}
