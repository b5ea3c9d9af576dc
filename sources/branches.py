"""The control flow of a callback: effects, variables that it sets and variables that it tests, by branch.

A value of a variable is ``("const", type, value)``, ``("member", class, member)`` of an enumeration,
``("outside", path)`` of a constant that is not in the folder, `SOME` or `OTHER`.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from dineros.sources.facts import Effect, Entity, Item
from dineros.sources.places import Place
from dineros.sources.variables import Known, Variable

SOME: Known = ("some",)
"""An object that is true and not None."""
OTHER: Known = ("other",)
"""Any value that the code does not name."""
NOTHING: Known = ("const", "NoneType", None)
"""None."""


def constant(value: object) -> Known:
    """Return a constant as a value of a variable."""
    return ("const", type(value).__name__, value)


TRUE, FALSE = constant(True), constant(False)


# ----------------------------------------------------------------------------------------------- conditions


class Condition:
    """Whether a branch is taken."""


@dataclass(eq=False)
class Anything(Condition):
    """A condition with an unknown result; evaluating it may have effects."""

    before: list[Item] = field(default_factory=list)


@dataclass(eq=False)
class Received(Anything):
    """A field of the message that the callback has received has one of some values: by default, true."""

    name: str = ""
    at: Place | None = None
    values: frozenset[Known] = frozenset((TRUE,))


@dataclass(eq=False)
class Answered(Anything):
    """A field of the response that a client has received has one of some values; asking may be the call."""

    name: str = ""
    """The field."""
    call: Effect | None = None
    """The request."""
    starts: bool = False
    """Whether the response has started the callback."""
    at: Place | None = None
    values: frozenset[Known] = frozenset((TRUE,))
    """The values; by default, true."""


@dataclass(eq=False)
class Compared(Condition):
    """A comparison of a variable with a constant by ``==`` or ``is``; without one, a truth test."""

    variable: Variable
    operator: str
    at: Place
    value: Known | None = None

    def holds(self, value: Known) -> bool | None:
        """Return whether it holds for a value of the variable; None: unknown."""
        if self.value is None:
            return _truth(value)
        if value in (SOME, OTHER):
            return False if self.value == NOTHING else None
        if value == self.value:
            return True
        if NOTHING in (value, self.value):
            return False
        if value[0] != self.value[0] or value[0] == "outside":
            return None
        if value[0] == "member":
            return False if value[1] == self.value[1] else None
        return bool(value[2] == self.value[2]) if self.operator == "==" else None


@dataclass(eq=False)
class Accepted(Condition):
    """The server has accepted the goal of a client."""

    client: Entity | None


@dataclass(eq=False)
class Negated(Condition):
    """The opposite of a condition."""

    condition: Condition


@dataclass(eq=False)
class Joined(Condition):
    """Conditions that are evaluated in order until one decides: ``and``, ``or``."""

    conditions: list[Condition]
    is_or: bool


def _truth(value: Known) -> bool | None:
    if value == SOME:
        return True
    return bool(value[2]) if value[0] == "const" else None


def parts(condition: Condition) -> Iterator[Condition]:
    """Yield the conditions of which one is made, in their order."""
    if isinstance(condition, Negated):
        yield from parts(condition.condition)
    elif isinstance(condition, Joined):
        for each in condition.conditions:
            yield from parts(each)
    else:
        yield condition


# ----------------------------------------------------------------------------------------------- statements


Block = list[Item]
"""Items in their order."""


@dataclass(eq=False)
class Do(Item):
    """An effect."""

    effect: Effect


@dataclass(eq=False)
class Put(Item):
    """An assignment of one of several values to a variable; None: any value."""

    variable: Variable
    values: tuple[Known, ...] | None
    at: Place


@dataclass(eq=False)
class Give(Item):
    """An assignment to a field of a response of a service; None: of any value; no name: to all fields."""

    name: str
    value: Known | None
    at: Place


@dataclass(eq=False)
class Branch(Item):
    """One block or another; without a condition, any of them."""

    condition: Condition
    then: Block
    otherwise: Block


@dataclass(eq=False)
class Loop(Item):
    """A block that is repeated while a condition holds, any number of times."""

    condition: Condition
    """While it holds."""
    body: Block
    is_entered: bool = False
    """Whether the block runs at least once."""
    count: int = 1
    """How many times it runs, if the code says so and nothing leaves it; else 1."""


@dataclass(eq=False)
class Turns(Item):
    """The turns of a loop, one after another."""

    turns: list[Block]


@dataclass(eq=False)
class Called(Item):
    """The body of a function."""

    body: Block


@dataclass(eq=False)
class Attempt(Item):
    """A ``try``: each point of its body may lead to one of its handlers."""

    body: Block
    otherwise: Block
    handlers: list[Block] = field(default_factory=list)
    last: Block = field(default_factory=list)


@dataclass(eq=False)
class Leave(Item):
    """An exit of a block: ``returns``, ``raises``, ``breaks``, ``continues``."""

    way: str


def blocks(item: Item) -> list[Block]:
    """Return the blocks of an item."""
    if isinstance(item, (Branch, Loop)):
        asked = [each.before for each in parts(item.condition) if isinstance(each, Anything)]
        return [*asked, *([item.then, item.otherwise] if isinstance(item, Branch) else [item.body])]
    if isinstance(item, Called):
        return [item.body]
    if isinstance(item, Turns):
        return item.turns
    if isinstance(item, Attempt):
        return [item.body, item.otherwise, *item.handlers, item.last]
    return []


def walk(block: Block) -> Iterator[Item]:
    """Yield all items of a block, those of blocks inside among them."""
    todo = list(block)
    while todo:
        item = todo.pop()
        yield item
        for each in blocks(item):
            todo.extend(each)


def conditions(block: Block) -> Iterator[Condition]:
    """Yield the conditions of a block, each without ``not``, ``and`` and ``or`` around it."""
    for item in walk(block):
        if isinstance(item, (Branch, Loop)):
            yield from parts(item.condition)


def variables_set(block: Block) -> set[Variable]:
    """Return the variables that a block sets."""
    return {item.variable for item in walk(block) if isinstance(item, Put)}


def variables_tested(block: Block) -> set[Variable]:
    """Return the variables that a block tests."""
    return {each.variable for each in conditions(block) if isinstance(each, Compared)}


# ------------------------------------------------------------------------------------- fields of the message


Fields = frozenset[tuple[str, bool]]
"""Fields of a received message with their truth values."""


def fields_of_effects(block: Block) -> dict[Effect, dict[str, bool]]:
    """Return for each effect of a callback the fields of its message that are true or false then."""
    found: dict[Effect, Fields] = {}
    _follow(block, frozenset(), found)
    return {effect: dict(fields) for effect, fields in found.items()}


def _follow(block: Block, known: Fields, found: dict[Effect, Fields]) -> None:
    """Follow the items of a block in which fields are known."""
    for item in block:
        if isinstance(item, Do):
            found[item.effect] = found.get(item.effect, known) & known
        if not isinstance(item, Branch):
            for each in blocks(item):
                _follow(each, known, found)
            continue
        for part in parts(item.condition):
            _follow(part.before if isinstance(part, Anything) else [], known, found)
        yes, no = (_both(known, _tested(item.condition, outcome)) for outcome in (True, False))
        _follow(item.then, yes, found)
        _follow(item.otherwise, no, found)
        if _leaves(item.then) != _leaves(item.otherwise):
            known = no if _leaves(item.then) else yes


def _both(known: Fields, more: Fields) -> Fields:
    """Return fields of two tests; those that contradict each other are left out."""
    both = known | more
    return frozenset((name, value) for name, value in both if (name, not value) not in both)


def _tested(condition: Condition, outcome: bool) -> Fields:
    """Return the fields that are known after a test."""
    if isinstance(condition, Received) and condition.values == {TRUE}:
        return frozenset(((condition.name, outcome),))
    if isinstance(condition, Negated):
        return _tested(condition.condition, not outcome)
    if isinstance(condition, Joined) and condition.is_or is not outcome:
        found: Fields = frozenset()
        for each in condition.conditions:
            found = _both(found, _tested(each, outcome))
        return found
    return frozenset()


def _leaves(block: Block) -> bool:
    """Return whether nothing after a block runs; what raises an error may be caught by a ``with``."""
    last = block[-1] if block else None
    if isinstance(last, Branch):
        return _leaves(last.then) and _leaves(last.otherwise)
    return isinstance(last, Leave) and last.way != "raises"
