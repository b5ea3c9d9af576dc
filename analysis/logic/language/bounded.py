"""Formulas with time bounds: ``G (a -> F[<=d] b)`` and formulas of similar form.

=========================  =========================================================
``F[<=5] b``               b comes within 5 from the start
``G[<=5] b``               b holds during 5 from the start
``G (a -> F[<=5] b)``      whenever a holds, b holds or comes within 5
``G (a -> G[<=5] b)``      whenever a holds, b holds for 5
``G (a -> X F[<=5] b)``    the same, not counting the step at which a holds
=========================  =========================================================

A window is ``[<=d]``, ``[<d]``, ``[a,b]``, or with a parenthesis for a bound that is left out: ``[a,b)``.
Bounds are decimal or rational numbers. ``a`` and ``b`` have no temporal operators.

References
----------
R. Koymans, *Specifying real-time properties with metric temporal logic*, Real-Time Systems 2(4), 1990.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from fractions import Fraction

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import TEMPORAL, Fired, Formula

_NUMBER = r"\d+(?:\.\d+)?(?:/\d+)?"
_WINDOW = re.compile(
    rf"\b(?P<operator>[FG])\s*(?:\[\s*(?P<less><=|<)\s*(?P<most>{_NUMBER})\s*\]"
    rf"|(?P<left>[\[(])\s*(?P<low>{_NUMBER})\s*,\s*(?P<high>{_NUMBER})\s*(?P<right>[\])]))"
)
_NO_WINDOW = re.compile(r"\b[FG]\s*(?P<window>\[[^\[\]()]*[<>=,][^\[\]()]*[\])[]?)")
"""An operator with what looks like a window. Numbers alone may be part of a name, such as ``F[1]``."""
_TRIGGER = re.compile(r"\s*(?:G|\[\])\s*\((?P<trigger>.*?)->\s*(?P<next>X\s*)?", re.DOTALL)
_OPAQUE = re.compile(r'"(?:[^"\\]|\\.)*"|\{(?:[^{}\\]|\\.)*\}')
_LONGEST = 40
"""Maximum number of digits of a bound."""


@dataclass(frozen=True)
class Window:
    """An interval of time, counted from a moment.

    Attributes
    ----------
    is_open_below, is_open_above : bool
        Whether the bound itself is excluded.
    """

    earliest: Fraction
    latest: Fraction
    is_open_below: bool = False
    is_open_above: bool = False

    @property
    def begins_at_once(self) -> bool:
        """Whether it contains the moment itself."""
        return not self.earliest and not self.is_open_below

    def __str__(self) -> str:
        if self.begins_at_once:
            return f"[{'<' if self.is_open_above else '<='}{self.latest}]"
        left, right = "(" if self.is_open_below else "[", ")" if self.is_open_above else "]"
        return f"{left}{self.earliest},{self.latest}{right}"


@dataclass(frozen=True)
class Bounded(Formula):
    """A formula with time bounds.

    Attributes
    ----------
    condition : Formula
        The condition required in the window.
    always : bool
        Whether it is required at every moment of the window, or at some moment.
    trigger : Formula or None
        The beginning of the window: whenever this holds; None: the start.
    is_after_step : bool
        Whether the step that begins the window does not count.
    """

    window: Window
    condition: Formula
    always: bool = False
    trigger: Formula | None = None
    is_after_step: bool = False
    _hash: int = field(default=0, init=False, repr=False, compare=False)

    @property
    def operands(self) -> tuple[Formula, ...]:  # type: ignore[override]
        """The trigger, if there is one, and the condition."""
        return (self.condition,) if self.trigger is None else (self.trigger, self.condition)

    def __str__(self) -> str:
        own = f"{'G' if self.always else 'F'}{self.window} ({self.condition})"
        if self.trigger is None:
            return own
        return f"G (({self.trigger}) -> {'X ' if self.is_after_step else ''}{own})"


def is_step(condition: Formula) -> bool:
    """Whether a condition is about firings."""
    return any(isinstance(part, Fired) for part in condition.subformulas())


def bounds_times(text: str) -> bool:
    """Return whether a formula has a temporal operator with a window."""
    return _WINDOW.search(_hidden(text)) is not None


def read_bounded(text: str) -> Bounded | None:
    """Read a formula with time bounds; None: it has no window.

    Raises
    ------
    FormulaError
        The window is empty, or its position is not supported.
    """
    hidden = _hidden(text)
    found = _WINDOW.search(hidden)
    if found is None:
        _refuse_no_window(hidden)
        return None
    column = found.start() + 1
    if _WINDOW.search(hidden, found.end()):
        raise FormulaError("only one operator of a formula has a window", column=column, hint=_SHAPES)
    before, rest = hidden[: found.start()], text[found.end() :]
    trigger, is_after = None, False
    if before.strip():
        begin = _TRIGGER.fullmatch(before)
        if begin is None or not rest.rstrip().endswith(")"):
            raise FormulaError("an operator with a window is not allowed here", column=column, hint=_SHAPES)
        start = begin.start("trigger")
        trigger = _condition(text[start : begin.end("trigger")], start)
        is_after = begin["next"] is not None
        rest = rest.rstrip()[:-1]
    condition = _condition(rest, found.end())
    return Bounded(_window(found, column), condition, found["operator"] == "G", trigger, is_after)


_SHAPES = "write F[<=d] b, G[<=d] b, G (a -> F[<=d] b) or G (a -> G[<=d] b)"


def _refuse_no_window(hidden: str) -> None:
    """Refuse brackets behind an operator that hold no window.

    Raises
    ------
    FormulaError
        There are such brackets.
    """
    found = _NO_WINDOW.search(hidden)
    if found is not None:
        shown = found["window"][:_LONGEST]
        raise FormulaError(
            f"{shown} is not a window of time",
            column=found.start("window") + 1,
            hint="write [<=5], [<5], [2,5] or [2,5), with decimal or rational numbers",
        )


def _hidden(text: str) -> str:
    """Return a text in which quoted names are blanked."""
    return _OPAQUE.sub(lambda match: "\0" * len(match[0]), text)


def _window(found: re.Match[str], column: int) -> Window:
    if found["most"]:
        window = Window(Fraction(0), number(found["most"], column), False, found["less"] == "<")
    else:
        low, high = number(found["low"], column), number(found["high"], column)
        window = Window(low, high, found["left"] == "(", found["right"] == ")")
    is_empty = window.latest == window.earliest and (window.is_open_below or window.is_open_above)
    if window.latest < window.earliest or is_empty:
        raise FormulaError("the window is empty", column=column)
    return window


def number(text: str, column: int) -> Fraction:
    """Read a bound from its decimal text.

    Raises
    ------
    FormulaError
        It is too long, or divides by zero.
    """
    if len(text) > _LONGEST:
        raise FormulaError(f"a bound has more than {_LONGEST} characters", column=column)
    whole, _, divisor = text.partition("/")
    if divisor and not int(divisor):
        raise FormulaError("a bound divides by zero", column=column)
    return Fraction(whole) / int(divisor or 1)


def _condition(text: str, start: int) -> Formula:
    """Read a condition; columns are those of the whole text."""
    formula = parse(" " * start + text)
    if any(isinstance(part, TEMPORAL) for part in formula.subformulas()):
        raise FormulaError(
            "in a formula with a window, conditions must not have temporal operators",
            column=start + 1,
            hint=_SHAPES,
        )
    return formula
