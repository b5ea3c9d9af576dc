"""Terms over variables: colours, multisets of colours, and conditions (ISO/IEC 15909-2, clause 5.3).

`value_of`, `multiset_of` and `truth_of` return functions that evaluate a term under a binding, a mapping of
names of variables to values. A term is therefore walked once, not once for each binding.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from itertools import product as tuples_of
from math import prod

from dineros.metamodel.colours.sorts import Product, Sort

Binding = Mapping[str, int]


@dataclass(frozen=True)
class Variable:
    """A variable of a transition."""

    name: str
    sort: Sort


@dataclass(frozen=True)
class Constant:
    """One colour."""

    value: int
    sort: Sort


@dataclass(frozen=True)
class Shift:
    """A colour `by` steps after another; the first follows the last."""

    term: Value
    by: int

    @property
    def sort(self) -> Sort:
        """Sort of the colour."""
        return self.term.sort


@dataclass(frozen=True)
class Mapped:
    """The image of a colour in a table, such as its element of a partition."""

    term: Value
    table: tuple[int, ...]
    sort: Sort


@dataclass(frozen=True)
class Tuple:
    """A tuple of colours."""

    terms: tuple[Value, ...]
    sort: Product


Value = Variable | Constant | Shift | Mapped | Tuple


@dataclass(frozen=True)
class All:
    """Each colour of a sort once."""

    sort: Sort


@dataclass(frozen=True)
class Times:
    """A multiset several times."""

    number: int
    multiset: Multiset


@dataclass(frozen=True)
class Sum:
    """All tokens of several multisets."""

    parts: tuple[Multiset, ...]


@dataclass(frozen=True)
class Difference:
    """The tokens of one multiset without those of another, which must be contained in the first."""

    first: Multiset
    second: Multiset


@dataclass(frozen=True)
class Tuples:
    """All tuples with one token of each multiset, at least one of which is not a single colour."""

    parts: tuple[Multiset, ...]
    sort: Product


Multiset = Value | All | Times | Sum | Difference | Tuples


@dataclass(frozen=True)
class Truth:
    """A condition that always has the same value."""

    value: bool


@dataclass(frozen=True)
class Comparison:
    """Compares the order of two colours; `operator` is one of ``== != < <= > >=``."""

    operator: str
    left: Value
    right: Value
    shift: int = 0
    """Added to the left number; ranges of numbers may begin at different numbers."""


@dataclass(frozen=True)
class Not:
    """Negation."""

    condition: Condition


@dataclass(frozen=True)
class Junction:
    """All of the conditions, or any of them."""

    needs_all: bool
    parts: tuple[Condition, ...]


Condition = Truth | Comparison | Not | Junction
Term = Value | Multiset | Condition

OPERATORS: dict[str, Callable[[int, int], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


class TooLargeError(ValueError):
    """A multiset, or the plain net, is larger than allowed."""


class TooManyValuesError(TooLargeError):
    """Conditions would have to be tried with more values of variables than allowed."""


class NegativeCountError(ValueError):
    """A difference takes more tokens than there are in the first multiset."""


def variables_of(term: Term) -> Iterator[Variable]:
    """Yield the variables of a term, each as often as it occurs."""
    match term:
        case Variable():
            yield term
        case Shift(inner) | Mapped(inner) | Not(inner) | Times(_, inner):
            yield from variables_of(inner)
        case Tuple(parts) | Sum(parts) | Tuples(parts) | Junction(_, parts):
            for part in parts:
                yield from variables_of(part)
        case Comparison(_, first, second) | Difference(first, second):
            yield from variables_of(first)
            yield from variables_of(second)
        case _:
            pass


def value_of(term: Value) -> Callable[[Binding], int]:
    """Return a function that evaluates a colour."""
    match term:
        case Variable(name):
            return operator.itemgetter(name)
        case Constant(value):
            return lambda binding: value
        case Shift(inner, by):
            of, size = value_of(inner), inner.sort.size
            return lambda binding: (of(binding) + by) % size
        case Mapped(inner, table):
            source = value_of(inner)
            return lambda binding: table[source(binding)]
        case Tuple(terms, sort):
            parts = [value_of(part) for part in terms]
            return lambda binding: sort.join([part(binding) for part in parts])


def multiset_of(term: Multiset, most: int) -> Callable[[Binding], dict[int, int]]:
    """Return a function that evaluates a multiset to the number of tokens by colour.

    The function raises `NegativeCountError` if a difference takes more tokens than there are.

    Parameters
    ----------
    term : Multiset
        The multiset.
    most : int
        The colours of `all`, or of the tuples of some multisets, at most.

    Raises
    ------
    TooLargeError
        `all` stands for more colours; the function raises it for tuples.
    """
    match term:
        case All(sort):
            if sort.size > most:
                raise TooLargeError
            return lambda binding: dict.fromkeys(range(sort.size), 1)
        case Times(number, inner):
            of = multiset_of(inner, most)
            return lambda binding: {value: number * count for value, count in of(binding).items() if number}
        case Sum(parts):
            addends = [multiset_of(part, most) for part in parts]
            return lambda binding: _added([addend(binding) for addend in addends])
        case Difference(first, second):
            whole, less = multiset_of(first, most), multiset_of(second, most)
            return lambda binding: _without(whole(binding), less(binding))
        case Tuples(parts, product):
            factors = [multiset_of(part, most) for part in parts]
            return lambda binding: _paired([factor(binding) for factor in factors], product, most)
        case _:
            one = value_of(term)
            return lambda binding: {one(binding): 1}


def truth_of(condition: Condition) -> Callable[[Binding], bool]:
    """Return a function that evaluates a condition."""
    match condition:
        case Truth(value):
            return lambda binding: value
        case Comparison(name, left, right, shift):
            holds, first, second = OPERATORS[name], value_of(left), value_of(right)
            return lambda binding: holds(first(binding) + shift, second(binding))
        case Not(inner):
            of = truth_of(inner)
            return lambda binding: not of(binding)
        case Junction(needs_all, parts):
            inner_parts = [truth_of(part) for part in parts]
            combine = all if needs_all else any
            return lambda binding: combine(part(binding) for part in inner_parts)


def conjuncts_of(condition: Condition) -> Iterator[Condition]:
    """Yield conditions that hold together exactly if the condition holds."""
    if isinstance(condition, Junction) and condition.needs_all:
        for part in condition.parts:
            yield from conjuncts_of(part)
    else:
        yield condition


def summands_of(term: Multiset, number: int = 1) -> Iterator[tuple[int, Multiset]]:
    """Yield multisets that are not sums, with their multiplicities in the sum; no multiplicity is zero."""
    match term:
        case Times(times, inner):
            yield from summands_of(inner, number * times)
        case Sum(parts):
            for part in parts:
                yield from summands_of(part, number)
        case _ if number:
            yield number, term


def _added(multisets: list[dict[int, int]]) -> dict[int, int]:
    total: dict[int, int] = {}
    for multiset in multisets:
        for value, count in multiset.items():
            total[value] = total.get(value, 0) + count
    return total


def _without(whole: dict[int, int], less: dict[int, int]) -> dict[int, int]:
    left = {value: count - less.get(value, 0) for value, count in whole.items()}
    if any(count < 0 for count in left.values()) or any(less[value] for value in less.keys() - whole.keys()):
        raise NegativeCountError
    return {value: count for value, count in left.items() if count}


def _paired(multisets: list[dict[int, int]], sort: Product, most: int) -> dict[int, int]:
    if prod(map(len, multisets)) > most:
        raise TooLargeError
    made: dict[int, int] = {}
    for combination in tuples_of(*(multiset.items() for multiset in multisets)):
        number = 1
        for _, count in combination:
            number *= count
        value = sort.join([each for each, _ in combination])
        made[value] = made.get(value, 0) + number
    return made
