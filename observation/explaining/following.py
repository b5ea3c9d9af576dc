"""The set of all markings that a model can have after the messages so far.

They are kept as a union of products, with one factor for each part of the net. If one transition shows a
topic's messages, there is one product; if several do, there is one product for each explanation of the
messages, and products that differ in one factor are merged.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import ParamSpec
from weakref import WeakValueDictionary

from dineros.analysis.answers.budget import Budget
from dineros.metamodel.errors import BudgetError
from dineros.observation.explaining.marking_sets import NOTHING, MarkingSets, SetsFullError
from dineros.observation.explaining.parts import Joining, parts_of
from dineros.observation.explaining.shown import ShownNet

P = ParamSpec("P")
Product = tuple[int, ...]

FULL = "memory ran out: too many markings are possible at once"

MOST_PRODUCTS = 2_000
"""Limit of the products of one union."""
MOST_STATES = 50_000
"""Limit of the unions that are kept, with their successors."""
LEAST_MEMORY = 64 << 20
"""Least bytes for the diagram of each part, even if the budget is smaller."""


class State:
    """The possible markings at one moment; equal states are the same object while they are in use."""

    __slots__ = ("__weakref__", "following", "joined", "products")

    def __init__(self, products: tuple[Product, ...]) -> None:
        self.products = products
        """The union; empty: no marking is possible."""
        # Many are used only once, and fewer objects mean less garbage collection.
        self.following: dict[str, State] | None = None
        """Known successors, by topic of the next message."""
        self.joined: dict[State, State] | None = None
        """Known unions of this state with another one."""

    def __bool__(self) -> bool:
        return bool(self.products)


class Follower:
    """Follows the messages of a recording through a model.

    Parameters
    ----------
    net : ShownNet
        The model, with its visible transitions.
    budget : Budget
        The budget of all diagrams together.
    joining : Joining
        The places that are followed as one part.

    Attributes
    ----------
    joining : Joining
        The same.
    """

    def __init__(self, net: ShownNet, budget: Budget, joining: Joining = "silence") -> None:
        self.net, self.joining = net, joining
        seen = {transition for found in net.shown.values() for transition in found}
        parts = parts_of(net.subject.net, seen, joining)
        most = max(LEAST_MEMORY, budget.memory // max(1, len(parts)))
        self.parts = [MarkingSets(part, budget.share(most_bytes=most)) for part in parts]
        """The parts of the net."""
        self.touched = {
            transition: [
                number for number, sets in enumerate(self.parts) if transition in sets.part.transitions
            ]
            for transition in seen
        }
        """By transition that shows a message: numbers of the parts that it changes or looks at."""
        self.parts_of = {
            topic: frozenset(number for transition in found for number in self.touched[transition])
            for topic, found in net.shown.items()
        }
        """By topic: the parts that its messages affect."""
        self.forgotten = 0
        """Number of times that sets of markings were discarded, so that their numbers were reused."""
        self._states: WeakValueDictionary[tuple[Product, ...], State] = WeakValueDictionary()

    @property
    def is_certain(self) -> bool:
        """Whether the markings are exact, and not limited by a bound on tokens."""
        return not any(sets.reached_edge for sets in self.parts)

    def start(self, midway: bool = False) -> State:
        """Return the possible markings before the first message.

        `midway`: whether the nodes may have run before: then each part can have any of its markings,
        independent of the other parts.
        """
        return self._state((tuple(sets.anywhere if midway else sets.start for sets in self.parts),))

    def step(self, state: State, topic: str) -> State:
        """Return the possible markings after a message on a recorded topic.

        Raises
        ------
        BudgetError
            There are too many ways in which the messages may have come about.
        """
        following = state.following
        known = following.get(topic) if following is not None else None
        if known is None:
            known = self._found(self._step, state, topic)
            if state.following is None:
                state.following = {}
            state.following[topic] = known
            if len(self._states) > MOST_STATES:
                self._forget_states()
                if any(sets.is_full for sets in self.parts):
                    self.forget()
        return known

    def union(self, one: State, other: State) -> State:
        """Return the union of two states."""
        if one is other:
            return one
        known = one.joined.get(other) if one.joined is not None else None
        if known is None:
            known = self._found(self._union, one, other)
            if one.joined is None:
                one.joined = {}
            one.joined[other] = known
        return known

    def _union(self, one: State, other: State) -> State:
        if self.covers(one, other):
            return one
        if self.covers(other, one):
            return other
        return self._state(self._compact({*one.products, *other.products}))

    def covers(self, one: State, other: State) -> bool:
        """Return whether a state includes another one; False if this cannot be decided."""
        return one is other or all(
            its in one.products or any(self._holds(product, its) for product in one.products)
            for its in other.products
        )

    def possible(self, state: State) -> list[str]:
        """Return the topics on which a message may come next."""
        return [topic for topic in self.net.shown if self.step(state, topic)]

    def forget(self) -> None:
        """Clear the successors, and so all states except those in use."""
        self.forgotten += 1
        self._forget_states()
        used = list(self._states.values())
        for number, sets in enumerate(self.parts):
            sets.forget({product[number] for state in used for product in state.products})

    def _forget_states(self) -> None:
        """Clear the successors only. Sets of markings and the steps between them are fewer and cost more."""
        for state in list(self._states.values()):
            state.following = state.joined = None

    def fired(self, product: Product, transition: int) -> Product | None:
        """Return a product after a shown transition; None if no marking of it enables the transition."""
        factors = list(product)
        for number in self.touched[transition]:
            factors[number] = self.parts[number].step(factors[number], transition)
            if factors[number] == NOTHING:
                return None
        return tuple(factors)

    def _found(self, operation: Callable[P, State], *arguments: P.args, **named: P.kwargs) -> State:
        """Return the result of an operation; if the memory is full, clear the caches and retry once."""
        try:
            return operation(*arguments, **named)
        except SetsFullError:
            self.forget()
            try:
                return operation(*arguments, **named)
            except SetsFullError:
                raise BudgetError(FULL) from None

    def _step(self, state: State, topic: str) -> State:
        shown = self.net.shown[topic]
        if len(shown) == len(state.products) == 1:
            product = self.fired(state.products[0], shown[0])
            return self._state(() if product is None else (product,))
        return self._state(self._compact(set(self._ways(state.products, topic))))

    def _ways(self, products: Sequence[Product], topic: str) -> Iterator[Product]:
        for product in products:
            for transition in self.net.shown[topic]:
                found = self.fired(product, transition)
                if found is not None:
                    yield found

    def _state(self, products: tuple[Product, ...]) -> State:
        found = self._states.get(products)
        if found is None:
            found = self._states[products] = State(products)
        return found

    def _compact(self, products: set[Product]) -> tuple[Product, ...]:
        """Merge products that differ in one factor, and remove those that others include."""
        if len(products) == 1:
            return tuple(products)
        while True:
            before = len(products)
            # If all have the same factor, no two differ only in that one.
            factors = [set(of_all) for of_all in zip(*products, strict=True)]
            for number, different in enumerate(factors):
                if len(different) > 1:
                    products = self._merged(products, number)
            if len(products) in (0, 1, before):
                break
        if len(products) > 1:
            products = {
                one
                for one in products
                if not any(other is not one and self._holds(other, one) for other in products)
            }
        if len(products) > MOST_PRODUCTS:
            raise BudgetError(f"there are more than {MOST_PRODUCTS:,} explanations of the messages")
        return tuple(sorted(products))

    def _merged(self, products: set[Product], number: int) -> set[Product]:
        found: dict[Product, int] = {}
        for product in products:
            others = (*product[:number], *product[number + 1 :])
            factor = product[number]
            found[others] = self.parts[number].union(found[others], factor) if others in found else factor
        if len(found) == len(products):
            return products
        return {(*others[:number], factor, *others[number:]) for others, factor in found.items()}

    def _holds(self, one: Product, other: Product) -> bool:
        """Return whether a product is included in another one."""
        for sets, factor, its in zip(self.parts, one, other, strict=True):
            if factor != its and not sets.covers(factor, its):
                return False
        return True
