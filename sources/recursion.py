"""The recursion limit while code is read: nested code needs a deep stack."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager

LIMIT = 12_000
"""Recursion limit of the readers: enough for the deepest code that is parsed."""


@contextmanager
def deep_recursion() -> Iterator[None]:
    """Allow deep recursion, and restore the limit afterwards."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(max(before, LIMIT))
    try:
        yield
    finally:
        sys.setrecursionlimit(before)
