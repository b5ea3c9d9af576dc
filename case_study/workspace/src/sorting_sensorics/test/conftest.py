# Written once by DiNeROS, from sorting.sym.xmi. This file is yours: it is never changed.
"""What the tests of `sorting_sensorics` give to its handlers."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest
from sorting_cell.cell import use_local
from sorting_cell.world import World

from sorting_sensorics import tokens


@pytest.fixture(autouse=True)
def cell() -> Iterator[World]:
    """Have the handlers use a simulated cell in this process: the tests run without ROS."""
    world = World(lambda node, signal, value: None)
    use_local(world)
    yield world
    use_local(None)


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
