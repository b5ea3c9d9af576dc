"""Plans for listing the bindings of a transition: the order of matching inputs and checking conditions.

An input ``Fork(x-1)`` and a token ``Fork(3)`` give ``x = 4``. A plan first matches the inputs, because few
colours can occur in most places. Each condition is checked as soon as its variables are bound. Only variables
that no input binds run over all values of their sort.

Example: the inputs are ``At(x, y)`` and ``Free(y+1)``, the condition is ``x != y``. The plan that starts with
a token in ``Free`` matches ``Free`` (binds y), looks up ``At`` by its second component (binds x), and checks
``x != y``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field

from dineros.metamodel.colours.sorts import Product
from dineros.metamodel.colours.terms import (
    Comparison,
    Condition,
    Shift,
    TooManyValuesError,
    Tuple,
    Value,
    Variable,
    conjuncts_of,
    truth_of,
    value_of,
    variables_of,
)

Bound = dict[str, int]


class Occurring:
    """The colours that can occur in a place, looked up by some of their components."""

    def __init__(self, sort: Product | None) -> None:
        self._sort = sort
        self._seen: set[int] = set()
        self._indices: dict[tuple[bool, tuple[int, ...]], dict[tuple[int, ...], list[tuple[int, ...]]]] = {}

    def add(self, value: int) -> bool:
        """Add a colour; return whether it is new."""
        if value in self._seen:
            return False
        self._seen.add(value)
        for (is_split, positions), index in self._indices.items():
            self._enter(index, self.components(value, is_split), positions)
        return True

    def components(self, value: int, is_split: bool) -> tuple[int, ...]:
        """Return the components of a colour, or the colour as its only component."""
        return self._sort.split(value) if is_split and self._sort is not None else (value,)

    def matching(
        self, is_split: bool, positions: tuple[int, ...], key: tuple[int, ...]
    ) -> Sequence[tuple[int, ...]]:
        """Return the components of all colours that have the key at the positions."""
        index = self._indices.get((is_split, positions))
        if index is None:
            index = self._indices[is_split, positions] = {}
            for value in sorted(self._seen):
                self._enter(index, self.components(value, is_split), positions)
        return index.get(key, ())

    @staticmethod
    def _enter(
        index: dict[tuple[int, ...], list[tuple[int, ...]]],
        components: tuple[int, ...],
        positions: tuple[int, ...],
    ) -> None:
        index.setdefault(tuple(components[position] for position in positions), []).append(components)


class Pattern:
    """A colour that a transition takes from a place, as a term."""

    def __init__(self, place: int, term: Value) -> None:
        self.place = place
        self.is_split = isinstance(term, Tuple)
        self.terms: tuple[Value, ...] = term.terms if isinstance(term, Tuple) else (term,)
        self.variables = {variable.name for variable in variables_of(term)}

    def step(self, bound: set[str]) -> _Match:
        """Return the step that matches the pattern after some variables are bound."""
        known, checks, binds = [], [], []
        seen = set(bound)
        for position, term in enumerate(self.terms):
            names = {variable.name for variable in variables_of(term)}
            if names <= bound:
                known.append((position, value_of(term)))
                continue
            inverse = _inverse(term)
            if inverse is not None and inverse[0] not in seen:
                name, by, size = inverse
                seen.add(name)
                binds.append((position, name, by, size))
            else:
                checks.append((position, term, names))
        late = [(position, value_of(term)) for position, term, names in checks if names <= seen]
        return _Match(self, tuple(known), tuple(binds), tuple(late), frozenset(seen - bound))

    def needs_later(self, bound: set[str]) -> Iterator[tuple[Value, int]]:
        """Yield components that can be compared only after other variables are bound."""
        after = bound | self.step(bound).new
        for position, term in enumerate(self.terms):
            if not {variable.name for variable in variables_of(term)} <= after:
                yield term, position


def _inverse(term: Value) -> tuple[str, int, int] | None:
    """Return name, shift and number of values of the variable that a colour determines, or None."""
    by = 0
    while isinstance(term, Shift):
        by += term.by
        term = term.term
    return (term.name, by, term.sort.size) if isinstance(term, Variable) else None


@dataclass(frozen=True)
class _Match:
    """Look up colours by their known components, bind variables, and compare the other components."""

    pattern: Pattern
    known: tuple[tuple[int, Callable[[Bound], int]], ...]
    binds: tuple[tuple[int, str, int, int], ...]
    late: tuple[tuple[int, Callable[[Bound], int]], ...]
    new: frozenset[str]

    def bindings(self, bound: Bound, occurring: Sequence[Occurring]) -> Iterator[Bound]:
        positions = tuple(position for position, _ in self.known)
        key = tuple(of(bound) for _, of in self.known)
        place = occurring[self.pattern.place]
        for components in place.matching(self.pattern.is_split, positions, key):
            made = self.bind(components, bound)
            if made is not None:
                yield made

    def seed(self, value: int, occurring: Sequence[Occurring]) -> Bound | None:
        """Bind the variables by one colour; None if it does not match."""
        components = occurring[self.pattern.place].components(value, self.pattern.is_split)
        if any(components[position] != of({}) for position, of in self.known):
            return None
        return self.bind(components, {})

    def bind(self, components: tuple[int, ...], bound: Bound) -> Bound | None:
        made = dict(bound)
        for position, name, by, size in self.binds:
            made[name] = (components[position] - by) % size
        for position, of in self.late:
            if components[position] != of(made):
                return None
        return made


@dataclass(frozen=True)
class _Check:
    holds: Callable[[Bound], bool]

    def bindings(self, bound: Bound, occurring: Sequence[Occurring]) -> Iterator[Bound]:
        if self.holds(bound):
            yield bound


@dataclass(frozen=True)
class _Define:
    """Bind a variable to a term that it must equal."""

    name: str
    of: Callable[[Bound], int]

    def bindings(self, bound: Bound, occurring: Sequence[Occurring]) -> Iterator[Bound]:
        yield {**bound, self.name: self.of(bound)}


@dataclass
class Tries:
    """Counts how many values are tried of variables that no token binds; `most` at most."""

    most: int
    count: int = 0

    def add(self) -> None:
        """Count one more; raise TooManyValuesError if there are too many."""
        self.count += 1
        if self.count > self.most:
            raise TooManyValuesError


@dataclass(frozen=True)
class _Each:
    """Bind a variable to each value of its sort."""

    name: str
    size: int
    tries: Tries

    def bindings(self, bound: Bound, occurring: Sequence[Occurring]) -> Iterator[Bound]:
        for value in range(self.size):
            self.tries.add()
            yield {**bound, self.name: value}


_Step = _Match | _Check | _Define | _Each


@dataclass
class Plan:
    """Plan for listing the bindings of a transition, starting from one given input or from none.

    Parameters
    ----------
    patterns : sequence of Pattern
        Colours that the transition takes.
    condition : Condition
        Condition that its variables must satisfy.
    variables : mapping of str to Variable
        All variables by name.
    tries : Tries
        Counts the values that are tried of variables that no token binds.
    first : Pattern or None
        The given input.
    """

    patterns: Sequence[Pattern]
    condition: Condition
    variables: Mapping[str, Variable]
    tries: Tries
    first: Pattern | None = None
    _steps: list[_Step] = field(default_factory=list, init=False)
    _seed: _Match | None = field(default=None, init=False)

    def __post_init__(self) -> None:
        bound: set[str] = set()
        rest = [pattern for pattern in self.patterns if pattern is not self.first]
        conditions = list(conjuncts_of(self.condition))
        if self.first is not None:
            self._seed = self.first.step(bound)
            bound |= self._seed.new
            rest += [self.first] if any(self.first.needs_later(set())) else []
        while True:
            conditions = self._checked(conditions, bound)
            if rest:
                rest.sort(key=lambda pattern: len(pattern.variables - bound))
                match = rest.pop(0).step(bound)
                again = any(match.pattern.needs_later(bound))
                bound |= match.new
                self._steps.append(match)
                if again:  # looked up once all variables are bound: no comparison was possible before
                    rest.append(match.pattern)
                    if not match.new:
                        self._bind_one(bound)
            elif self.variables.keys() - bound:
                self._bind_one(bound)
            else:
                break

    def _bind_one(self, bound: set[str]) -> None:
        name = min(self.variables.keys() - bound, key=lambda name: (self.variables[name].sort.size, name))
        self._steps.append(_Each(name, self.variables[name].sort.size, self.tries))
        bound.add(name)

    def _checked(self, conditions: Iterable[Condition], bound: set[str]) -> list[Condition]:
        """Add a step for each condition whose variables are bound, and for each that defines a variable."""
        left = list(conditions)
        progress = True
        while progress:
            progress = False
            for condition in list(left):
                names = {variable.name for variable in variables_of(condition)}
                if names <= bound:
                    self._steps.append(_Check(truth_of(condition)))
                elif (defined := _definition(condition, bound)) is not None:
                    self._steps.append(_Define(defined[0], value_of(defined[1])))
                    bound.add(defined[0])
                else:
                    continue
                left.remove(condition)
                progress = True
        return left

    def bindings(self, occurring: Sequence[Occurring], value: int | None = None) -> Iterator[Bound]:
        """Yield the bindings; `value` is the colour of the given input."""
        start: Bound | None = {} if self._seed is None or value is None else self._seed.seed(value, occurring)
        if start is not None:
            yield from self._from(0, start, occurring)

    def _from(self, number: int, bound: Bound, occurring: Sequence[Occurring]) -> Iterator[Bound]:
        if number == len(self._steps):
            yield bound
            return
        for made in self._steps[number].bindings(bound, occurring):
            yield from self._from(number + 1, made, occurring)


def _definition(condition: Condition, bound: set[str]) -> tuple[str, Value] | None:
    """Return the variable that an equation defines, and the term that it equals."""
    if not isinstance(condition, Comparison) or condition.operator != "==" or condition.shift:
        return None
    for one, other in ((condition.left, condition.right), (condition.right, condition.left)):
        inverse = _inverse(one)
        if inverse is None or inverse[0] in bound or one.sort.size != other.sort.size:
            continue
        if {variable.name for variable in variables_of(other)} <= bound:
            name, by, _ = inverse
            return name, Shift(other, -by) if by else other
    return None
