"""Which values an integer field of a token may have: an interval, or some values with names.

>>> states = named_values("IDLE=0, BUSY=1")
>>> states.value_of("BUSY")
1
>>> states.fault(2)
'IDLE, BUSY'
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from dineros.metamodel.errors import FeatureValueError

_NAMED = re.compile(r"\s*([A-Z](?:_?[A-Z0-9])*)\s*=\s*([+-]?[0-9]{1,20})\s*", re.ASCII)  # constants of ROS


@dataclass(frozen=True, slots=True)
class ValueRange:
    """The values of an integer field.

    Attributes
    ----------
    minimum, maximum : int or None
        Least and greatest value; None: no bound but that of the field's ROS type.
    names : tuple of (str, int)
        Named values. If there are any, the field has no others, unless it is open.
    is_open : bool
        Whether the field may have other values than the named ones, as constants of ROS messages allow.
    """

    minimum: int | None = None
    maximum: int | None = None
    names: tuple[tuple[str, int], ...] = ()
    is_open: bool = False

    @property
    def listed(self) -> tuple[tuple[str, int], ...]:
        """Named values, if the field has no others."""
        return () if self.is_open else self.names

    def value_of(self, name: str) -> int | None:
        """Return the value with a name; None: no value has it."""
        return dict(self.names).get(name)

    def fault(self, value: int) -> str | None:
        """Return which values are allowed, in words, if a value is not allowed; None if it is."""
        if self.listed and value not in dict(self.listed).values():
            return ", ".join(name for name, _ in self.listed)
        is_low = self.minimum is not None and value < self.minimum
        is_high = self.maximum is not None and value > self.maximum
        return self.bounds if is_low or is_high else None

    @property
    def bounds(self) -> str:
        """Least and greatest value in words, such as ``0 to 100``; empty: there are none."""
        if self.maximum is None:
            return "" if self.minimum is None else f"at least {self.minimum}"
        return f"at most {self.maximum}" if self.minimum is None else f"{self.minimum} to {self.maximum}"

    def require(self, name: str, value: int) -> int:
        """Return a value of the range.

        Parameters
        ----------
        name : str
            What has the value.
        value : int
            The value.

        Raises
        ------
        FeatureValueError
            It is outside of the range.
        """
        allowed = self.fault(value)
        if allowed is not None:
            raise FeatureValueError(f"{name} takes {allowed}, not {value}")
        return value


UNLIMITED = ValueRange()
"""Every value of the field's kind and ROS type."""


def named_values(text: str) -> ValueRange:
    """Read named values such as ``IDLE=0, BUSY=1``.

    Raises
    ------
    FeatureValueError
        The text has another form, or gives a name or a value twice.
    """
    names: dict[str, int] = {}
    for part in text.split(","):
        match = _NAMED.fullmatch(part)
        if match is None:
            raise FeatureValueError(
                f"{part.strip()!r:.60} is not a named value", hint="write names and numbers: IDLE=0, BUSY=1"
            )
        name, value = match[1], int(match[2])
        if name in names or value in names.values():
            twice = f"the name {name}" if name in names else f"the value {value}"
            raise FeatureValueError(f"{twice} is given twice", hint="give each value one name")
        names[name] = value
    return ValueRange(names=tuple(names.items()))
