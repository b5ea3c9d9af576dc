"""The attributes of objects that a program sets, and unknown code that could set them."""

from __future__ import annotations

from dineros.sources.facts import Known, Place, Variable
from dineros.sources.language.values import (
    Bound,
    Either,
    Function,
    Object,
    Outside,
    OutsideMethod,
    Partial,
    Value,
)


class Attributes:
    """Known facts about the attributes of objects.

    Attributes
    ----------
    stores : set of (str, int, int)
        Path, line and column of each assignment to an attribute that was followed.
    names : set of str
        Attributes that unknown code may set.
    calls : set of str
        Names of functions and methods that unknown code may call.
    single : set of int
        Ids of objects that are made once.
    is_wild : bool
        Whether something unknown may call anything.
    has_begun : bool
        Whether callbacks run already.
    """

    def __init__(self) -> None:
        self._all: dict[tuple[int, str], tuple[Object, Variable]] = {}
        self._first: dict[Variable, set[Known] | None] = {}
        self.stores: set[tuple[str, int, int]] = set()
        self.names: set[str] = set()
        self.calls: set[str] = set()
        self.single: set[int] = set()
        self.is_wild = False
        self.has_begun = False

    def of(self, holder: Object, name: str, at: Place) -> Variable:
        """Return the variable of an attribute."""
        if (id(holder), name) not in self._all:
            self._all[id(holder), name] = holder, Variable(name, at)
        return self._all[id(holder), name][1]

    def all(self) -> list[tuple[Object, Variable]]:
        """Return all variables with their objects, in the order in which they were found."""
        return list(self._all.values())

    def begin(
        self, variable: Variable, values: tuple[Known, ...] | None, at: Place, *, is_certain: bool
    ) -> None:
        """Record a value from before callbacks run; a value assigned in a branch is one of several."""
        variable.at = at
        if is_certain or variable not in self._first:
            self._first[variable] = set(values) if values is not None else None
            if not is_certain:
                self._first[variable] = None
            return
        before = self._first[variable]
        self._first[variable] = None if before is None or values is None else before | set(values)

    def has_first(self, variable: Variable) -> bool:
        """Return whether a variable was assigned before callbacks run."""
        return variable in self._first

    def first(self, variable: Variable) -> Known | None:
        """Return the only value of a variable when callbacks begin to run; None: unknown."""
        found = self._first.get(variable)
        return next(iter(found)) if found is not None and len(found) == 1 else None

    def may_call(self, function: Value | None) -> None:
        """Record that unknown code may call a function at any time."""
        if isinstance(function, Either):
            for each in function.options:
                self.may_call(each)
        elif isinstance(function, (Bound, Partial)):
            self.may_call(function.function)
        elif isinstance(function, Function):
            self.calls.add(function.name)
        elif isinstance(function, OutsideMethod):
            if not isinstance(function.instance, Object):
                self.calls.add(function.name)
        elif isinstance(function, Object):
            self.calls.add("__call__")
        elif not isinstance(function, Outside):
            self.is_wild = True
