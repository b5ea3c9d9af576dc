"""The state of Python while code is read: nested code needs a deep stack, and its trees are long-lived."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LIMIT = 12_000
"""Recursion limit of the readers: enough for the deepest code that is parsed."""
COLLECT_AFTER = (100_000, 50, 100)
"""Thresholds of the garbage collector: it passes over all syntax trees each time, and they stay."""


@contextmanager
def deep_recursion() -> Iterator[None]:
    """Allow deep recursion, and collect garbage rarely; restore both limits afterwards."""
    before, collected = sys.getrecursionlimit(), gc.get_threshold()
    sys.setrecursionlimit(max(before, LIMIT))
    gc.set_threshold(*COLLECT_AFTER)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
        gc.set_threshold(*collected)
