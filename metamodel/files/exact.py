"""Numbers that keep their decimal or rational text where a float would round them.

A bound of a firing interval is a float for every caller. A float stands for its shortest decimal text: 0.1 is
one tenth. A text with more digits, or a rational one such as ``1/3``, becomes an `ExactNumber`, a float whose
`repr` is that text. So bounds stay exact from file to file and in the analysis.
"""

from __future__ import annotations

import math
import re
from fractions import Fraction

DECIMAL = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?0*([0-9]+))?")
_RATIONAL = re.compile(r"[+-]?[0-9]+/0*[1-9][0-9]*")
_LONGEST = 400
_OUT_OF_RANGE = "takes a number within the range of a double"
_ROUNDS_BACK = 15
"""A decimal text with at most this many characters is the shortest text of a float, or equals it."""


class ExactNumber(float):
    """The float nearest to a number that no float's shortest text stands for; `repr` gives the number.

    Attributes
    ----------
    fraction : Fraction
        The number itself.
    """

    __slots__ = ("fraction",)
    fraction: Fraction

    def __new__(cls, fraction: Fraction) -> ExactNumber:
        """Return the float for a number.

        Raises
        ------
        OverflowError
            The number is outside the range of floats.
        """
        made = super().__new__(cls, fraction.numerator / fraction.denominator)
        made.fraction = fraction
        return made

    def __repr__(self) -> str:
        return exact_text(self.fraction)

    __str__ = __repr__

    def __eq__(self, other: object) -> bool:
        if isinstance(other, ExactNumber):
            return self.fraction == other.fraction
        return float(self) == other

    def __ne__(self, other: object) -> bool:
        return not self == other

    def __hash__(self) -> int:
        return float.__hash__(self)

    def __reduce__(self) -> tuple[type[ExactNumber], tuple[Fraction]]:
        return ExactNumber, (self.fraction,)


def exact_number(text: str) -> float:
    """Return the number that a decimal or rational text stands for, exactly.

    Raises
    ------
    ValueError
        The text is not such a number, or the number is outside the range of floats.

    Examples
    --------
    >>> exact_number("0.1"), exact_number("1/4"), exact_number("1/3")
    (0.1, 0.25, 1/3)
    """
    text = text.strip()
    decimal = DECIMAL.fullmatch(text) if len(text) <= _LONGEST else None
    if decimal is None and not (len(text) <= _LONGEST and _RATIONAL.fullmatch(text)):
        raise ValueError("takes a number")
    if decimal is not None and len(decimal[3] or "") > 3:  # such a power alone would fill the memory
        raise ValueError(_OUT_OF_RANGE)
    if len(text) <= _ROUNDS_BACK and "/" not in text and "e" not in text.lower():
        return float(text)
    return nearest(Fraction(text))


def nearest(number: Fraction) -> float:
    """Return a float for a number: a plain one if its shortest text is the number.

    Raises
    ------
    ValueError
        The number is outside the range of floats.
    """
    try:
        rounded = number.numerator / number.denominator
    except OverflowError:
        raise ValueError(_OUT_OF_RANGE) from None
    if not math.isfinite(rounded) or (number and not rounded):
        raise ValueError(_OUT_OF_RANGE)
    return rounded if Fraction(repr(rounded)) == number else ExactNumber(number)


def fraction_of(number: float) -> Fraction:
    """Return what a finite number stands for: by its decimal text, or exactly.

    Raises
    ------
    ValueError
        The number is infinite or not a number.
    """
    return number.fraction if isinstance(number, ExactNumber) else Fraction(repr(float(number)))


def exact_text(number: Fraction) -> str:
    """Return a number as a decimal, if it has an end, or as a quotient such as ``1/3``."""
    decimal = decimal_text(number)
    return f"{number.numerator}/{number.denominator}" if decimal is None else decimal


def decimal_text(number: Fraction) -> str | None:
    """Return a number as a decimal without an exponent, or None if the decimal has no end."""
    rest, twos, fives = number.denominator, 0, 0
    while rest % 2 == 0:
        rest, twos = rest // 2, twos + 1
    while rest % 5 == 0:
        rest, fives = rest // 5, fives + 1
    if rest != 1:
        return None
    places = max(twos, fives)
    digits = str(abs(number.numerator) * 10**places // number.denominator).rjust(places + 1, "0")
    sign = "-" if number < 0 else ""
    return sign + (f"{digits[:-places]}.{digits[-places:]}" if places else digits)
