"""Grids: the settings and variants of a model in a sweep, and their order.

A feature without a dot is a parameter of a program that builds the model, see
`dineros.metamodel.files.programs`.
"""

from __future__ import annotations

import json
import re
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product
from math import prod
from pathlib import Path
from tempfile import TemporaryDirectory

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.limits import most

_FEATURE = re.compile(r".+\.[^.]+")
_WHOLE = re.compile("[+-]?[0-9]{1,18}")
_RANGE = re.compile(r"([+-]?[0-9]{1,18})\.\.([+-]?[0-9]{1,18})(?:\.\.([0-9]{1,18}))?")


class SweepError(DinerosError):
    """A sweep cannot be run: an invalid grid, the journal of another sweep, an unavailable cluster."""


@dataclass(frozen=True)
class Axis:
    """Features that have the same values at the same time.

    Attributes
    ----------
    features : tuple of str
        For example ``RedObjects.tokens``, see `dineros.metamodel.settings`; or a parameter, such as
        ``robots``.
    """

    features: tuple[str, ...]
    values: tuple[str, ...]

    @classmethod
    def parse(cls, text: str) -> Axis:
        """Read ``FEATURE[,FEATURE...]=VALUES``; values are ``a..b``, ``a..b..step`` or texts, by commas.

        Raises
        ------
        SweepError
            The text has another form, or values are missing, too many, or occur twice.
        """
        left, equals, right = text.partition("=")
        features = tuple(feature.strip() for feature in left.split(","))
        if not equals or not all(is_parameter(each) or _FEATURE.fullmatch(each) for each in features):
            raise SweepError(
                f"{text!r} is not of the form ELEMENT.FEATURE=VALUES",
                hint="for example RedObjects.tokens=0..10",
            )
        values: list[str] = []
        for part in right.split(","):
            found = _values(part.strip(), text)
            _require_few(len(values) + len(found), f"{part!r} has {len(found)} values")
            values += map(str, found)
        for what, given in (("feature", features), ("value", values)):
            twice = next((one for one, times in Counter(given).items() if times > 1), None)
            if twice is not None:
                raise SweepError(f"{text!r} has the {what} {twice!r} twice", hint="leave one out")
        return cls(features, tuple(values))


def is_parameter(feature: str) -> bool:
    """Return whether it is a parameter of a program that builds a model, not a feature of an element."""
    return feature.isidentifier()


def _require_few(points: int, message: str) -> None:
    if points > most("points"):
        raise SweepError(
            message,
            hint=f"at most {most('points')}: vary fewer values, or raise the limit: --limit points={points}",
        )


def _values(part: str, text: str) -> range | list[str]:
    found = _RANGE.fullmatch(part)
    if found is None:
        if not part:
            raise SweepError(f"{text!r} has an empty value", hint="for example RedObjects.tokens=0..10")
        return [part]
    first, last, step = int(found[1]), int(found[2]), int(found[3] or 1)
    if step == 0 or last < first:
        raise SweepError(
            f"{part!r} is an empty range",
            hint="write FIRST..LAST or FIRST..LAST..STEP, ascending, step 1 or more",
        )
    return range(first, last + 1, step)


@dataclass(frozen=True)
class Point:
    """One model of a grid.

    Attributes
    ----------
    settings : tuple of (str, str)
        Feature and value, in the order of the axes.
    signals, overflow : str or None
        Options of the flattening; None for a plain net.
    reduced : bool
        Whether the net is reduced before it is explored.
    """

    settings: tuple[tuple[str, str], ...]
    signals: str | None
    overflow: str | None
    reduced: bool

    @property
    def key(self) -> str:
        """Unique key of the point in its grid."""
        return json.dumps([self.settings, self.signals, self.overflow, self.reduced], ensure_ascii=False)

    @property
    def parameters(self) -> tuple[str, ...]:
        """Values of the parameters of a program that builds the model, as settings."""
        return tuple(f"{name}={value}" for name, value in self.settings if is_parameter(name))

    def columns(self) -> dict[str, str | bool | None]:
        """Return the columns of the table for this point."""
        return {
            **dict(self.settings),
            "signals": self.signals,
            "overflow": self.overflow,
            "reduced": self.reduced,
        }


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of axes and of variants.

    Attributes
    ----------
    axes : tuple of Axis
        The axes, outermost first.
    signals, overflow : tuple
        Variants of the flattening; ``(None,)`` for a plain net.
    reduced : tuple of bool
        Whether nets are reduced; the innermost axis.

    Raises
    ------
    SweepError
        A feature is in two axes, or there are too many points.
    """

    axes: tuple[Axis, ...]
    signals: tuple[str | None, ...] = ("input-enabled",)
    overflow: tuple[str | None, ...] = ("weighted",)
    reduced: tuple[bool, ...] = (False,)

    def __post_init__(self) -> None:
        for number, feature in enumerate(self.features):
            if feature in self.features[:number]:
                raise SweepError(f"{feature} is varied twice", hint="give it once, with all its values")
        _require_few(self._count, f"the grid has {self._count} points")

    @property
    def _count(self) -> int:
        """Number of points, which may exceed the limit of `len`."""
        variants = (self.signals, self.overflow, self.reduced)
        return prod([*(len(axis.values) for axis in self.axes), *map(len, variants)])

    def __len__(self) -> int:
        return self._count

    @cached_property
    def features(self) -> tuple[str, ...]:
        """All features of the axes."""
        return tuple(feature for axis in self.axes for feature in axis.features)

    def __iter__(self) -> Iterator[Point]:
        values = product(*(axis.values for axis in self.axes))
        for chosen, signals, overflow, reduced in product(values, self.signals, self.overflow, self.reduced):
            pairs = zip(self.axes, chosen, strict=True)
            settings = tuple((feature, value) for axis, value in pairs for feature in axis.features)
            yield Point(settings, signals, overflow, reduced)

    def check(self, model: str) -> None:
        """Apply all values (of integers only the ends), and validate the model at the ends of each axis.

        Parameters
        ----------
        model : str
            The model, as XMI; for a program, the one with the first values of its parameters.

        Raises
        ------
        DinerosError
            A feature does not exist, or a value is invalid or violates a constraint.
        """
        from dineros.metamodel.settings import apply

        for number, axis in enumerate(self.axes):
            changed = parse_model(model)
            ends = (axis.values[0], axis.values[-1])
            # The time to find the element of a setting grows with the size of the model.
            for value in [*ends, *(value for value in axis.values if not _WHOLE.fullmatch(value))]:
                for feature in axis.features:
                    if not is_parameter(feature):  # each of its values has built a model
                        apply(changed, f"{feature}={value}")
            for value in set(ends):
                axes = (*self.axes[:number], Axis(axis.features, (value,)), *self.axes[number + 1 :])
                model_of(next(iter(Grid(axes))), model)


def parse_model(text: str) -> pn.Net:
    """Return the model in an XMI text."""
    from dineros.metamodel.files import load

    with TemporaryDirectory() as folder:
        path = Path(folder) / "model.xmi"
        path.write_text(text, encoding="utf-8")
        return load(path)


def model_of(point: Point, text: str) -> pn.Net:
    """Return the model of a point.

    Raises
    ------
    DinerosError
        A setting does not fit the model, or violates a constraint.
    """
    from dineros.metamodel.constraints import validate
    from dineros.metamodel.settings import apply

    model = parse_model(text)
    for feature, value in point.settings:
        if not is_parameter(feature):  # applied when the text was created
            apply(model, f"{feature}={value}")
    errors = [violation for violation in validate(model) if violation.severity == "error"]
    if errors:
        settings = ", ".join(f"{feature}={value}" for feature, value in point.settings)
        raise SweepError(f"with {settings}, {errors[0].message}", hint=errors[0].fix or None)
    return model
