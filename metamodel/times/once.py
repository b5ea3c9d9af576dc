"""Answers about a model that are kept while it does not change.

Rules ask for each pair of ports what can be on its way between them, and each answer asks for most of the
model again. While matches of a rule are looked for, nothing changes: then each question is answered once.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from functools import wraps
from typing import Any, ParamSpec, TypeVar

_P = ParamSpec("_P")
_T = TypeVar("_T")

_KEPT: ContextVar[dict[tuple[object, ...], Any] | None] = ContextVar("kept answers", default=None)


@contextmanager
def unchanged() -> Iterator[None]:
    """Keep the answers of functions that are asked `once`: no model changes meanwhile."""
    if _KEPT.get() is not None:
        yield
        return
    token = _KEPT.set({})
    try:
        yield
    finally:
        _KEPT.reset(token)


def once(function: Callable[_P, _T]) -> Callable[_P, _T]:
    """Keep what a function returns for the same arguments, within `unchanged`; do not change what it returns.

    Examples
    --------
    >>> @once
    ... def asked(number: int) -> int:
    ...     print("asked")
    ...     return number
    >>> with unchanged():
    ...     asked(1) + asked(1)
    asked
    2
    """

    @wraps(function)
    def kept(*args: _P.args, **kwargs: _P.kwargs) -> _T:
        known = _KEPT.get()
        if known is None:
            return function(*args, **kwargs)
        key = (function, args, tuple(sorted(kwargs.items())))
        if key not in known:
            known[key] = function(*args, **kwargs)
        found: _T = known[key]
        return found

    return kept
