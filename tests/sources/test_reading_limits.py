"""The limits of Python while code is read."""

import gc
import sys

import pytest

from dineros.sources.reading_limits import COLLECT_AFTER, LIMIT, limits_for_reading


def test_limits_are_restored_also_after_an_error() -> None:
    before = sys.getrecursionlimit(), gc.get_threshold()
    with pytest.raises(ValueError), limits_for_reading():
        assert sys.getrecursionlimit() >= LIMIT
        assert gc.get_threshold() == COLLECT_AFTER
        raise ValueError
    assert (sys.getrecursionlimit(), gc.get_threshold()) == before
