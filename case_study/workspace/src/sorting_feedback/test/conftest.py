# Written once by DiNeROS, from sorting.sym.xmi. This file is yours: it is never changed.
"""What the tests of `sorting_feedback` give to its handlers."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from sorting_feedback import tokens


@pytest.fixture
def tokens_for() -> Callable[[str, str], tokens.SortingToken]:
    """Return what gives the data of a token that a transition takes from a place in its test."""

    def data(transition: str, place: str) -> tokens.SortingToken:
        return tokens.sorting_token()

    return data


@pytest.fixture
def skipped() -> dict[str, str]:
    """Return transitions whose handlers cannot run in a test, and why."""
    return {}  # such as {"TPick": "needs the arm"}
