"""Builds the net of a callback page: open behaviour if nothing is given, otherwise the given steps.

*Open* is the worst case: after it has begun, a callback may publish on any publisher of its node, call any
service that its node is a client of and wait for the answer or not, and send any goal, in any order and any
number of times; or it ends.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.observation.importing.flows.graphs import steps_of, variables_of
from dineros.observation.importing.flows.labels import Answers, Ask, Flow, Has, Received, Set, Step
from dineros.observation.importing.names import Ids, flat


@dataclass(frozen=True)
class Call:
    """The places of a client on a callback page; `timed_out` gets a token after a time-out."""

    request: sym.Place
    response: sym.Place
    timed_out: sym.Place | None = None


@dataclass(frozen=True)
class Possible:
    """The possible steps of callbacks of a node."""

    puts: Mapping[Step, tuple[pn.Place, ...]]
    """Places on which a step puts a token: of each publisher of a topic, of the goals of an action, of
    requests without a wait.
    """
    call: Callable[[sym.CallbackPage, Step, float | None], Call]
    """Creates the client of a call for a page, with its arguments: page, step, seconds until it gives up."""
    calls: tuple[Step, ...]
    """The calls that the node can make."""
    waits: Mapping[Step, pn.Place] = field(default_factory=dict)
    """Places from which a step takes a token: of messages and results that other callbacks have taken."""
    variables: Mapping[str, Mapping[str, pn.Place]] = field(default_factory=dict)
    """A place for each value of each variable; one of them has a token."""

    def steps(self) -> tuple[Step, ...]:
        """Return the steps that a callback may take, any number of times."""
        return tuple(Step(step.verb, step.name, "*") for step in (*self.puts, *self.calls))


class Body:
    """The net of one callback page.

    Parameters
    ----------
    page : sym.CallbackPage
        The page; its id is the prefix of the ids of its elements.
    ids : Ids
        Creates ids.
    possible : Possible
        The possible steps of the node.
    """

    def __init__(self, page: sym.CallbackPage, ids: Ids, possible: Possible) -> None:
        self.page = page
        self._ids = ids
        self._possible = possible
        self._references: dict[pn.Place, pn.ReferencePlace] = {}
        self._calls: dict[tuple[str, str | None], Call] = {}
        self._called = set[tuple[pn.Place, pn.Place]]()
        self._limits: dict[tuple[str, str | None], float | None] = {}

    def place(self, word: str, **features: object) -> sym.Place:
        """Add a place to the page."""
        return sym.Place(id=self._id(word), page=self.page, **features)  # type: ignore[arg-type]

    def transition(self, word: str, *, kind: str = "discrete", at: str = "") -> sym.Transition:
        """Add a transition to the page; it represents a line of code if one is given."""
        return sym.Transition(id=self._id(word), kind=kind, page=self.page, sourceLine=at or None)

    def run(
        self,
        begin: sym.Transition,
        steps: tuple[Step, ...] | None,
        branches: Flow | None = None,
        message: sym.Place | None = None,
    ) -> pn.Place:
        """Add the steps of the callback after its first transition; return the last place.

        Parameters
        ----------
        begin : sym.Transition
            Its first transition.
        steps : tuple of Step or None
            In order; None: open.
        branches : Flow or None
            The steps in branches, if variables or responses decide about them.
        message : sym.Place or None
            Where the response is that has started the callback.
        """
        state = self.place("runs")
        flow(begin, state)
        if branches is not None and self._is_followed(branches):
            started = {edge.label.name for edge in branches.edges if isinstance(edge.label, Has)}
            if started and message is not None and message.tokenType is not None:
                state.tokenType = message.tokenType
                names = sorted(started)
                begin.assigns = ", ".join(f"{_field(state, n)} := {_field(message, n)}" for n in names)
            return self._follow(state, branches)
        if steps is None:
            for step in self._possible.steps():
                self._do(step, state, state, is_chosen=True)
            return state
        self._limit(steps)
        for step in steps:
            if step.times == "*":
                self._do(step, state, state, is_chosen=True)
                continue
            after = self.place("goes_on")
            self._do(step, state, after, is_chosen=step.times == "?")
            if step.times == "?":
                flow(state, self.transition(f"without_{flat(step.name)}", at=step.at), after)
            state = after
        return state

    def reply(
        self,
        begin: sym.Transition,
        steps: tuple[Step, ...] | None,
        branches: Flow | None,
        answer: sym.Place,
    ) -> None:
        """Add the steps of a service's callback after its first transition, and its responses."""
        gives = branches is not None and any(isinstance(each.label, Answers) for each in branches.edges)
        if branches is None or not gives or not self._is_followed(branches) or answer.tokenType is None:
            self.end(self.run(begin, steps, branches), answer)
            return
        state = self.place("runs")
        flow(begin, state)
        self._follow(state, branches, answer)

    def _is_followed(self, branches: Flow) -> bool:
        """Return whether the node has all variables of a flow."""
        return bool(self._possible.variables) or not variables_of(branches)

    def decide(self, begin: sym.Transition, message: sym.Place, received: Received) -> pn.Place:
        """Add the branches of a callback that a field of its message decides; return the last place."""
        state = self.place("runs", tokenType=message.tokenType)
        flow(begin, state)
        begin.assigns = f"{_field(state, received.name)} := {_field(message, received.name)}"
        self._limit(step for _, each in received.branches for step in steps_of(each))
        after = self.place("goes_on")
        for value, branches in received.branches:
            tests = self.transition(f"{flat(received.name)}_is_{value}", at=received.at)
            tests.guard = f"{_field(state, received.name)} = {_worth(value)}"
            if branches.start == branches.end:
                flow(state, tests, after)
                continue
            first = self.place("goes_on")
            flow(state, tests, first)
            self._follow(first, branches, after)
        return after

    def _limit(self, steps: Iterable[Step]) -> None:
        """Represent all calls of a service by one client: it has a time-out only if all calls have one."""
        for step in steps:
            if step.verb == "call":
                client = step.name, step.group
                known = self._limits.get(client, step.timeout)
                both = known is not None and step.timeout is not None
                self._limits[client] = max(known or 0, step.timeout or 0) if both else None

    def _follow(self, first: pn.Place, branches: Flow, last: pn.Place | None = None) -> pn.Place:
        """Add a flow after a place, up to a place if one is given; return the place where it ends."""
        self._limit(steps_of(branches))
        states: dict[int, pn.Place] = {branches.start: first}
        if last is not None:
            states[branches.end] = last
        for edge in branches.edges:
            for state in (edge.source, edge.target):
                if state not in states:
                    states[state] = self.place("goes_on")
        if branches.end not in states:
            states[branches.end] = self.place("goes_on")  # nothing leads there
        leaving = Counter(edge.source for edge in branches.edges)
        for edge in branches.edges:
            before, after, label = states[edge.source], states[edge.target], edge.label
            if isinstance(label, Step):
                self._do(label, before, after, is_chosen=leaving[edge.source] > 1)
            elif isinstance(label, Set):
                self._set(label, before, after)
            elif isinstance(label, Has):
                tests = self.transition(f"{flat(label.name)}_is_{label.value}", at=label.at)
                if _has_type(before):
                    tests.guard = f"{_field(before, label.name)} = {_worth(label.value)}"
                flow(before, tests, after)
            elif isinstance(label, Answers):
                answers = self.transition("answers")
                flow(before, answers, after)
                if label.value is not None and _has_type(after):
                    answers.assigns = f"{_field(after, label.name)} := {_worth(label.value)}"
            elif isinstance(label, Ask):
                for value in sorted(label.values):
                    asks = self.transition(f"{flat(label.variable)}_is_{flat(value)}", at=label.at)
                    flow(before, asks, after)
                    here = self._here(self._possible.variables[label.variable][value])
                    flow(here, asks, here)
            else:
                flow(before, self.transition("continues"), after)
        return states[branches.end]

    def _set(self, label: Set, before: pn.Place, after: pn.Place) -> None:
        """Assign a value to a variable, independent of its previous value."""
        places = self._possible.variables[label.variable]
        for value, old in places.items():
            if label.before is not None and value not in label.before:
                continue
            sets = self.transition(f"sets_{flat(label.variable)}_{flat(label.value)}", at=label.at)
            flow(before, sets, after)
            flow(self._here(old), sets, self._here(places[label.value]))

    def store(self, state: pn.Place, kept: pn.Place | None) -> pn.Place:
        """Notify the callbacks that wait for this one; return the place after it."""
        if kept is None:
            return state
        after, here = self.place("stored"), self._here(kept)
        at = str(self.page.sourceLine or "")
        first, again = self.transition("stores", at=at), self.transition("stores_again", at=at)
        flow(state, first, after)
        flow(first, here)
        flow(state, again, after)
        flow(here, again, here)
        return after

    def end(
        self,
        state: pn.Place,
        exit: pn.Place | None = None,
        overlaps: tuple[sym.Transition, int] | None = None,
    ) -> None:
        """End the callback: with a token on a place, a server's response, or nothing.

        `overlaps`: its first transition, and how many of its runs there are at once at most.
        """
        if exit is None:
            ends = self.transition("ends", kind="end")
            flow(state, ends)
            if overlaps is not None:
                free = self.place("free", tokens=overlaps[1])
                flow(free, overlaps[0])
                flow(ends, free)
        else:
            flow(state, self.transition("answers"), exit)

    def _do(self, step: Step, before: pn.Place, after: pn.Place, *, is_chosen: bool = False) -> None:
        """Add a step; one that is chosen among others is begun first, so that a wait can last forever."""
        name = flat(step.name)
        if step.verb == "call":
            client = step.name, step.group
            if client not in self._calls:
                self._calls[client] = self._possible.call(self.page, step, self._limits.get(client))
            call = self._calls[client]
            known = (before, call.request)
            if step.answer is None or known not in self._called:  # one call, a step for each answer
                self._called.add(known)
                flow(before, self.transition(f"calls_{name}", at=step.at), call.request)
            has = self.transition(f"has_{name}", at=step.at)
            flow(call.response, has, after)
            if step.answer is not None and call.response.tokenType is not None:
                field, value = step.answer
                has.guard = f"{_field(call.response, field)} = {_worth(value)}"
            if call.timed_out is not None:
                flow(call.timed_out, self.transition(f"gives_up_{name}", at=step.at), after)
            return
        kept = self._possible.waits.get(Step(step.verb, step.name))
        if kept is not None:
            if is_chosen:
                waiting = self.place("waits")
                flow(before, self.transition(f"begins_to_wait_for_{name}", at=step.at), waiting)
                before = waiting
            waits = self.transition(f"waits_for_{name}", at=step.at)
            flow(before, waits, after)
            flow(self._here(kept), waits)
            return
        for place in self._possible.puts[Step(step.verb, step.name)]:  # any of them, where there are several
            does = self.transition(f"{_VERBS[step.verb]}_{name}", at=step.at)
            flow(before, does, after)
            flow(does, self._here(place))
            if step.sends and isinstance(place, sym.Place) and place.tokenType is not None:
                does.assigns = ", ".join(
                    f"{_field(place, name)} := {_worth(value)}" for name, value in step.sends
                )

    def _here(self, place: pn.Place) -> pn.ReferencePlace:
        """Return the reference to a place of the node on this page."""
        if place not in self._references:
            id = self._ids.new(f"{place.id}@{self.page.id}")
            self._references[place] = pn.ReferencePlace(id=id, target=place, page=self.page)
        return self._references[place]

    def _id(self, word: str) -> str:
        return self._ids.new(f"{self.page.id}.{word}")


def _has_type(place: pn.Place) -> bool:
    """Return whether guards can refer to the tokens of a place."""
    return isinstance(place, sym.Place) and place.tokenType is not None


def _field(place: pn.Place, field: str) -> str:
    """Return a field of the token of a place, as guards and assignments write it."""
    quoted = str(place.id).replace("\\", "\\\\").replace('"', '\\"')
    return f'"{quoted}".{field}'


def _worth(value: str) -> str:
    """Return the value of a field, as guards and assignments write it."""
    return value if value in ("true", "false") else f"'{value}'"


_VERBS = {"publish": "publishes", "send": "sends", "goal": "wants", "cancel": "cancels"}
