"""Reading of properties that bound a latency or a response time.

==========================  ====================================================
``X to Y within 0.05``      data takes at most 0.05 seconds from X to Y
``X responds within 0.02``  each run of the callback X ends at most 0.02 seconds after its release
==========================  ====================================================

X and Y are callbacks or topics, as for `dineros latency`; a name with spaces is in quotes. An instance of
data that is lost on its way has no latency.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction

from dineros.analysis.logic.language.bounded import number
from dineros.analysis.logic.language.parser import MAX_LENGTH
from dineros.metamodel import sym

_NAME = r'(?:"([^"]+)"|([^\s"]+))'
_TEXT = re.compile(rf"\s*{_NAME}\s+(?:to\s+{_NAME}|responds)\s+within\s+(\d+(?:\.\d+)?(?:/\d+)?)\s*")


@dataclass(frozen=True)
class LatencyBound:
    """A bound, as a property states it."""

    first: str
    last: str
    """`first`, `last`: names of the ends; `last` is empty for a response time."""
    seconds: Fraction
    """The greatest time."""


def latency_bound(property: sym.Property) -> LatencyBound | None:
    """Return the bound that a property states; None if it asks something else.

    Raises
    ------
    FormulaError
        The time is not a number.
    """
    text = str(property.text)
    match = _TEXT.fullmatch(text) if str(property.language) == "words" and len(text) <= MAX_LENGTH else None
    if match is None:
        return None
    first, last = match[1] or match[2], match[3] or match[4] or ""
    return LatencyBound(first, last, number(match[5], match.start(5) + 1))
