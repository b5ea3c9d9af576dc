"""What a constraint is: a guard, a check, a message and a fix, declared in a few lines.

>>> from dineros.metamodel import pn
>>> @constraint("{it} holds {element.tokens} tokens", fix="give it 9 or fewer")
... def few_tokens(place: pn.Place, index: Index) -> bool:
...     '''A place holds at most nine tokens.'''
...     return place.tokens < 10
>>> few_tokens.name, few_tokens.about, few_tokens.says
('few-tokens', <class 'dineros.metamodel.pn.Place'>, 'A place holds at most nine tokens.')
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any, Literal, TypeVar, get_type_hints

from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.positions import location_of

E = TypeVar("E", bound=EObject)
Severity = Literal["error", "warning"]
Outcome = bool | str | DinerosError
"""True where a constraint holds; otherwise False, what was found, or an error with message and hint."""


@dataclass(frozen=True)
class Violation:
    """An element that violates a constraint; prints as one line ``FILE:LINE: message (fix)``."""

    constraint: str
    severity: Severity
    element: EObject
    message: str
    fix: str
    location: Location | None = None

    def __str__(self) -> str:
        where = f"{self.location}: " if self.location else ""
        return f"{where}{self.message} ({self.fix})"


@dataclass(frozen=True)
class Constraint:
    """A condition on all elements of a class.

    Attributes
    ----------
    name : str
        What it is called, in words joined by dashes.
    says : str
        The condition, in one sentence.
    about : type[EObject]
        Class of the elements it is about, subclasses included.
    severity : Severity
        Whether a violation makes the model wrong or only suspicious.
    guard : Callable[[Any, Index], bool] | None
        Whether an element is checked at all; absent: always.
    check : Callable[[Any, Index], Outcome]
        Whether an element satisfies it, or what was found instead.
    message : str
        What is wrong; `{it}` names the element, `{element.weight}` gives a feature, `{found}` the outcome.
    fix : str
        What would fix it, with the same placeholders.
    """

    name: str
    says: str
    about: type[EObject]
    severity: Severity
    guard: Callable[[Any, Index], bool] | None
    check: Callable[[Any, Index], Outcome]
    message: str
    fix: str

    def violation(self, element: EObject, found: Outcome) -> Violation:
        """Return what is wrong with an element, given what `check` found instead of True."""
        fix = self.fix
        if isinstance(found, DinerosError):
            fix = found.hint.replace("{", "{{").replace("}", "}}") if found.hint else fix
            found = found.message
        words = {"it": describe(element), "element": element, "found": found}
        return Violation(
            self.name,
            self.severity,
            element,
            _one_line(self.message.format(**words)),
            _one_line(fix.format(**words)),
            location_of(element),
        )


def constraint(
    message: str,
    *,
    fix: str,
    severity: Severity = "error",
    guard: Callable[[Any, Index], bool] | None = None,
) -> Callable[[Callable[[E, Index], Outcome]], Constraint]:
    """Make a constraint of a check; its name, its first parameter's class and its docstring belong to it."""

    def make(check: Callable[[E, Index], Outcome]) -> Constraint:
        return Constraint(
            name=check.__name__.replace("_", "-"),
            says=(inspect.getdoc(check) or "").split("\n\n")[0].replace("\n", " "),
            about=_first_type(check),
            severity=severity,
            guard=guard,
            check=check,
            message=message,
            fix=fix,
        )

    return make


def _first_type(check: Any) -> Any:
    """Return the type of a function's first parameter; other annotations take time, and are not evaluated."""
    name, text = next(iter(check.__annotations__.items()))
    return get_type_hints(SimpleNamespace(__annotations__={name: text}), check.__globals__)[name]


def _one_line(text: str) -> str:
    return " ".join(text.split())
