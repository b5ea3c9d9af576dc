"""Limits of Python while code is read: the depth of the stack, and how often garbage is collected."""

from __future__ import annotations

import gc
import sys
from collections.abc import Iterator
from contextlib import contextmanager

LIMIT = 12_000
"""Recursion limit of the readers: enough for the deepest code that is parsed."""
COLLECT_AFTER = (100_000, 50, 100)
"""Thresholds of the garbage collector. Each collection visits all syntax trees, which are not garbage."""


@contextmanager
def limits_for_reading() -> Iterator[None]:
    """Allow deep recursion, as nested code needs it, and collect garbage rarely; restore both limits."""
    before, collected = sys.getrecursionlimit(), gc.get_threshold()
    sys.setrecursionlimit(max(before, LIMIT))
    gc.set_threshold(*COLLECT_AFTER)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
        gc.set_threshold(*collected)
