"""Converts the branches of a callback from the reader to a graph of steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace

from dineros.observation.importing.flows.graphs import Graph
from dineros.observation.importing.flows.knowing import GIVEN, STARTED
from dineros.observation.importing.flows.labels import Ask, Deciding, Has, Know, Label, Set, Step, Test
from dineros.sources.branches import (
    Accepted,
    Answered,
    Anything,
    Attempt,
    Block,
    Branch,
    Called,
    Compared,
    Condition,
    Do,
    Give,
    Joined,
    Leave,
    Loop,
    Negated,
    Put,
    Received,
    Turns,
    blocks,
    conditions,
)
from dineros.sources.facts import Effect, Item
from dineros.sources.places import Place, located
from dineros.sources.variables import Variable

END = 0


@dataclass(frozen=True)
class Responses:
    """Fields of responses on which a callback depends, or that it gives; empty: none."""

    calls: Mapping[Effect, Deciding] = field(default_factory=dict)
    """Of the responses of its calls."""
    started: Deciding | None = None
    """Of the response that has started it."""
    given: Deciding | None = None
    """Of the response that it gives."""

    def values(self) -> dict[str, frozenset[str]]:
        """Return all values of the fields, by their names."""
        found: dict[str, frozenset[str]] = {}
        for each in (*self.calls.values(), self.started, self.given):
            if each is not None:
                found[each.name] = found.get(each.name, frozenset()) | frozenset(each.texts)
        return found


_MOST_TURNS = 3
"""Limit of the iterations of a loop that are distinguished if they do the same."""


class Branching:
    """Builds the graph of one callback.

    Parameters
    ----------
    step : callable
        Returns the step of an effect in the model; None: it has none.
    names : mapping of Variable to str
        The variables that the model has, with their names.
    texts : callable
        Returns the values of a variable in the model, those of the code as keys.
    accepted : bool or None
        Whether the goal of the callback is accepted; None: it may be or not.
    folder : str
        In which the files are.
    received : (Deciding, str) or None
        A field of the message that the callback has received, with its value.
    responses : Responses
        Fields of responses.
    """

    def __init__(
        self,
        steps: Callable[[Effect], tuple[list[Label], bool] | None],
        names: Mapping[Variable, str],
        texts: Callable[[Variable], Mapping[tuple[object, ...], str]],
        accepted: bool | None = None,
        folder: str = "",
        received: tuple[Deciding, str] | None = None,
        responses: Responses | None = None,
    ) -> None:
        self._responses = responses or Responses()
        self._received = received
        self._folder = folder
        self._steps, self._names, self._texts, self._accepted = steps, names, texts, accepted
        self._ways: dict[str, int] = {"returns": END, "raises": END, "breaks": END, "continues": END}
        self._trap: int | None = None
        self.graph = Graph()

    def read(self, body: Block) -> int:
        """Add a body; return its first state."""
        start = first = self._state()
        started = self._responses.started
        if started is not None:
            asked = (each for each in conditions(body) if isinstance(each, Answered) and each.starts)
            at = next((each.at for each in asked), None)
            first = self._state()
            for value in started.texts:
                has = self._state()
                line = "" if at is None else self._at(at)
                self.graph.edge(start, Has(started.name, value, line), has)
                self.graph.edge(has, Know(STARTED, value), first)
        self.graph.edge(self._block(body, first), None, END)
        return start

    def _at(self, place: Place) -> str:
        return located(place, self._folder)

    def _state(self) -> int:
        found = self.graph.state()
        if self._trap is not None:
            self.graph.edge(found, None, self._trap)
        return found

    def _block(self, block: Block, state: int) -> int:
        """Add the items of a block after a state; return the state after them."""
        for item in block:
            state = self._item(item, state)
        return state

    def _item(self, item: Item, state: int) -> int:
        if isinstance(item, Leave):
            self.graph.edge(state, None, self._ways[item.way])
            return self.graph.state()  # nothing leads there
        if isinstance(item, Do):
            return self._does(item, state)
        if isinstance(item, Put):
            return self._puts(item, state)
        if isinstance(item, Give):
            return self._gives(item, state)
        if isinstance(item, Branch):
            after = self._state()
            for block, first in zip(
                (item.then, item.otherwise), self._asked(item.condition, state), strict=True
            ):
                self.graph.edge(self._block(block, first), None, after)
            return after
        if isinstance(item, Loop):
            return self._loop(item.condition, item.body, state, is_endless=item.is_entered)
        if isinstance(item, Turns):
            return self._turns(item, state)
        if isinstance(item, Called):
            after = self._state()
            with self._with(returns=after):
                self.graph.edge(self._block(item.body, state), None, after)
            return after
        if isinstance(item, Attempt):
            return self._attempt(item, state)
        return state

    def _does(self, item: Do, state: int) -> int:
        found, effect = self._steps(item.effect), item.effect
        asked = self._responses.calls.get(effect)
        unknown = None if asked is None else Know(effect, None)
        if found is None:
            return state if unknown is None else self._marked(state, unknown)
        (label, *waits), is_perhaps = found
        after = self._state()
        if asked is not None and isinstance(label, Step) and label.verb == "call":
            for value in asked.texts:
                answered = self._state()
                self.graph.edge(state, replace(label, answer=(asked.name, value)), answered)
                self.graph.edge(answered, Know(effect, value), after)
        else:
            self.graph.edge(state, label, after)
            for wait in waits:
                waited = self._state()
                self.graph.edge(after, wait, waited)
                after = waited
            after = after if unknown is None else self._marked(after, unknown)
        if is_perhaps:
            self.graph.edge(state, unknown, after)
        return after

    def _marked(self, state: int, mark: Know) -> int:
        after = self._state()
        self.graph.edge(state, mark, after)
        return after

    def _gives(self, item: Give, state: int) -> int:
        given = self._responses.given
        if given is None or item.name not in ("", given.name):
            return state
        value = None if item.value is None else given.known.get(item.value)
        return self._marked(state, Know(GIVEN, value))

    def _puts(self, item: Put, state: int) -> int:
        name = self._names.get(item.variable)
        if name is None:
            return state
        after, texts = self._state(), self._texts(item.variable)
        for text in texts.values() if item.values is None else (texts[each] for each in item.values):
            self.graph.edge(state, Set(name, text, self._at(item.at)), after)
        return after

    # ----------------------------------------------------------------------------------------------- loops

    def _loop(self, condition: Condition, body: Block, state: int, *, is_endless: bool) -> int:
        head, after = self._state(), self._state()
        self.graph.edge(state, None, head)
        yes, no = (head, None) if is_endless else self._asked(condition, head)
        if no is not None:
            self.graph.edge(no, None, after)
        with self._with(breaks=after, continues=head):
            self.graph.edge(self._block(body, yes), None, head)
        return after

    def _turns(self, item: Turns, state: int) -> int:
        if len(item.turns) > _MOST_TURNS and len({_sign(each) for each in item.turns}) == 1:
            return self._loop(Anything(), item.turns[0], state, is_endless=False)
        after = self._state()
        for turn in item.turns:
            following = self._state()
            with self._with(breaks=after, continues=following):
                self.graph.edge(self._block(turn, state), None, following)
            state = following
        self.graph.edge(state, None, after)
        return after

    # ------------------------------------------------------------------------------------------- exceptions

    def _attempt(self, item: Attempt, state: int) -> int:
        after = self._state()
        ways = {way: self._finally(item.last, target) for way, target in self._ways.items()}
        trap = None if self._trap is None else self._finally(item.last, self._trap)
        done = self._finally(item.last, after)
        caught = self._state()
        with self._with(**ways), self._trapped(trap):
            for handler in item.handlers:
                first = self._state()
                self.graph.edge(caught, None, first)
                self.graph.edge(self._block(handler, first), None, done)
            raised, inner = (caught, caught) if item.handlers else (ways["raises"], trap)
            with self._with(raises=raised), self._trapped(inner):
                first = self._state()
                self.graph.edge(state, None, first)
                last = self._block(item.body, first)
            last = self._block(item.otherwise, last)
            self.graph.edge(last, None, done)
        return after

    def _finally(self, last: Block, target: int) -> int:
        """Return the first state of a path to a target that runs the ``finally`` block."""
        if not last:
            return target
        first = self._state()
        self.graph.edge(self._block(last, first), None, target)
        return first

    @contextmanager
    def _with(self, **ways: int) -> Iterator[None]:
        before = self._ways
        self._ways = {**before, **ways}
        try:
            yield
        finally:
            self._ways = before

    @contextmanager
    def _trapped(self, trap: int | None) -> Iterator[None]:
        before, self._trap = self._trap, trap
        try:
            yield
        finally:
            self._trap = before

    # ------------------------------------------------------------------------------------------- conditions

    def _asked(self, condition: Condition, state: int) -> tuple[int, int]:
        """Return the state in which a condition holds, and the one in which it does not."""
        yes, no = self._state(), self._state()
        self._ask(condition, state, yes, no)
        return yes, no

    def _ask(self, condition: Condition, state: int, yes: int, no: int) -> None:
        if isinstance(condition, Negated):
            self._ask(condition.condition, state, no, yes)
        elif isinstance(condition, Joined):
            for each in condition.conditions[:-1]:
                following = self._state()
                self._ask(each, state, *((yes, following) if condition.is_or else (following, no)))
                state = following
            self._ask(condition.conditions[-1], state, yes, no)
        elif isinstance(condition, Compared) and condition.variable in self._names:
            name, texts = self._names[condition.variable], self._texts(condition.variable)
            for target, outcome in ((yes, False), (no, True)):
                values = frozenset(
                    text for value, text in texts.items() if condition.holds(value) is not outcome
                )
                if values:
                    self.graph.edge(state, Ask(name, values, self._at(condition.at)), target)
        elif isinstance(condition, Accepted) and self._accepted is not None:
            self.graph.edge(state, None, yes if self._accepted else no)
        elif isinstance(condition, Answered) and (asked := self._answer(condition)) is not None:
            key, values, others = asked
            state = self._block(condition.before, state)
            self.graph.edge(state, Test(key, values), yes)
            self.graph.edge(state, Test(key, others), no)
        elif isinstance(condition, Received) and (holds := self._holds(condition)) is not None:
            self.graph.edge(state, None, yes if holds else no)
        else:
            if isinstance(condition, Anything):
                state = self._block(condition.before, state)
            self.graph.edge(state, None, yes)
            self.graph.edge(state, None, no)

    def _holds(self, condition: Received) -> bool | None:
        """Return whether a test of the received message holds; None: it is not known."""
        if self._received is None or condition.name != self._received[0].name:
            return None
        values = self._received[0].among(condition.values)
        return None if values is None else self._received[1] in values

    def _answer(self, condition: Answered) -> tuple[object, frozenset[str], frozenset[str]] | None:
        """Return the response that a test asks, with the values for which it holds and does not hold."""
        key: object = STARTED if condition.starts else condition.call
        if condition.starts:
            asked = self._responses.started
        else:
            asked = None if condition.call is None else self._responses.calls.get(condition.call)
        values = asked.among(condition.values) if asked is not None else None
        if asked is None or values is None or asked.name != condition.name:
            return None
        return key, values & frozenset(asked.texts), frozenset(asked.texts) - values


def _sign(block: Block) -> tuple[object, ...]:
    """Return a key that distinguishes blocks with different effects."""
    return tuple(
        (
            type(item).__name__,
            id(item.effect) if isinstance(item, Do) else None,
            (id(item.variable), item.values) if isinstance(item, Put) else None,
            item.way if isinstance(item, Leave) else None,
            (item.name, item.value) if isinstance(item, Give) else None,
            tuple(_sign(each) for each in blocks(item)),
            _asks(item.condition) if isinstance(item, (Branch, Loop)) else None,
        )
        for item in block
    )


def _asks(condition: Condition) -> tuple[object, ...]:
    if isinstance(condition, Negated):
        return ("not", _asks(condition.condition))
    if isinstance(condition, Joined):
        return (condition.is_or, *(_asks(each) for each in condition.conditions))
    if isinstance(condition, Compared):
        return (id(condition.variable), condition.operator, condition.value)
    if isinstance(condition, Received):
        return ("received", condition.name, condition.values)
    if isinstance(condition, Answered):
        return ("answered", condition.name, id(condition.call), condition.starts, condition.values)
    return (type(condition).__name__, id(getattr(condition, "client", None)))
