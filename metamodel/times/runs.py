"""How many tokens one run of a callback puts on a place, at most and at least, found by exploring the runs.

A run starts once, and each request that it waits for gets one response. What its transitions take from
elsewhere is always there. So every order of its steps is among those explored, and the greatest number is
a bound. There is none where a run can go round a circle that puts a token, or leaves tokens for later runs.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Iterable

from dineros.metamodel import pn, pnm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body, calls_of
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.elements import node_net_of, nodes, resolve, system_model_of
from dineros.metamodel.times.given import runs_at_once
from dineros.metamodel.times.once import once

MOST_STATES = 300
"""Largest number of markings of one run that are explored."""

_Marking = frozenset[tuple[pn.Node, int]]


@once
def most_put(page: sym.CallbackPage, place: pn.Place) -> int | None:
    """Return how many tokens one run of a callback puts on a place at most; None if nothing bounds it."""
    run = _Run(page, place)
    if not run.starts_by_ports:
        return None
    in_turn = run.put_in_turn()
    if in_turn is not None or runs_at_once(page) > 1:
        return in_turn
    try:
        return run.explored()
    except _UnboundedError:
        return None


@once
def least_put(page: sym.CallbackPage, place: pn.Place) -> int:
    """Return how many tokens each run of a callback puts on a place at least, once it ends; 0 if unknown."""
    run = _Run(page, place)
    try:
        return run.explored(min) if run.starts_by_ports else 0
    except _UnboundedError:
        return 0


def is_changed_elsewhere(page: sym.CallbackPage, place: pn.Place) -> bool:
    """Return whether a transition outside of a callback page takes from a place of the page, or puts there.

    What the rules add does not count: it is another way to fire a transition of the page (rule D3), or takes
    what the page puts.
    """
    return any(each is not page for each in _changed_by(place))


@once
def only_put_by(place: pn.Place) -> list[sym.CallbackPage] | None:
    """Return the callbacks that put tokens on a place; None if something outside of callbacks may, too.

    The place may be on a page of a callback, or in its node, whose callbacks refer to it.
    """
    pages = _changed_by(place)
    found = {page for page in pages if page is not None and runs_callbacks(node_net_of(page))}
    return sorted(found, key=lambda page: str(page.id)) if found == pages else None


@once
def _changed_by(place: pn.Place) -> set[sym.CallbackPage | None]:
    """Return the callbacks with arcs from and to a place; None among them: arcs outside of callbacks."""
    around = [arc for each in stand_for(place) for arc in (*each.incoming, *each.outgoing)]
    return {callback_page_of(arc) for arc in around if not isinstance(arc.page, pnm.Sheet)}


def stand_for(place: pn.Place) -> list[pn.Node]:
    """Return a place and the references to it."""
    model = system_model_of(place)
    return [place] if model is None else [place, *_references_of(model).get(place, ())]


@once
def _references_of(model: sym.SystemModel) -> dict[pn.Node, list[pn.Node]]:
    found: dict[pn.Node, list[pn.Node]] = defaultdict(list)
    for node in nodes(model):
        if isinstance(node, pn.ReferencePlace):
            found[resolve(node)].append(node)
    return found


def places_of_ports(model: sym.SystemModel | None) -> set[pn.Place]:
    """Return the places that ports of a model name: the middleware puts tokens there, or takes them."""
    return set() if model is None else {each for each in _ports_of(model) if isinstance(each, pn.Place)}


def ports_at(place: pn.Place) -> list[EObject]:
    """Return the ports that name a place: the middleware puts tokens there, or takes them."""
    model = system_model_of(place)
    return [] if model is None else _ports_of(model).get(place, [])


@once
def _ports_of(model: sym.SystemModel) -> dict[EObject, list[EObject]]:
    """Return the ports of a model by what they name; each names a thing once at most, in this list."""
    found: dict[EObject, list[EObject]] = defaultdict(list)
    for channel in model.channels:
        for part in channel.eAllContents():
            named = {getattr(part, name, None) for name in _references(part)}
            for each in named:
                if isinstance(each, EObject):
                    found[each].append(part)
    return found


_REFERENCES: dict[str, tuple[str, ...]] = {}
"""By class of a part of a channel: its features that may name a node of a net."""


def _references(part: EObject) -> tuple[str, ...]:
    kind = type(part).__name__
    if kind not in _REFERENCES:
        found = type(part).eClass.eAllReferences()
        _REFERENCES[kind] = tuple(each.name for each in found if not each.containment and not each.many)
    return _REFERENCES[kind]


class _UnboundedError(Exception):
    """A run goes round a circle, leaves something, or has too many markings."""


class _Run:
    """The net of one run: the places that its own transitions raise, and one start."""

    def __init__(self, page: sym.CallbackPage, place: pn.Place) -> None:
        self.page = page
        calls = calls_of(page)
        self.body = Body(page, calls)
        self.changes: dict[pn.Transition, Counter[pn.Node]] = {}
        self.puts: Counter[pn.Transition] = Counter()
        for transition in self.body.transitions:
            self.changes[transition] = self._changed(transition, calls)
            self.puts[transition] = sum(
                arc.weight for arc in transition.outgoing if resolve(arc.target) is place
            )
        changes = [each for change in self.changes.values() for each in change.items()]
        raised = {node for node, number in changes if number > 0}
        lowered = {node for node, number in changes if number < 0}
        self.fed = places_of_ports(system_model_of(page))
        responses = {response for request, response in calls if request in self.body.requests}
        self.own = {node for node in raised & lowered if node in responses or self._is_own(node)}
        timer = page.kind == sym.CallbackKind.timer
        self.starts = set(self.body.beginnings()) if timer else set(self._takers())
        self.starts_by_ports = timer or all(
            any(number < 0 and node in self.fed for node, number in self.changes[start].items())
            for start in self.starts
        )
        self.ends = set(self.body.ends())
        self.onward: dict[_Marking, int | None] = {}
        """How many tokens are still put from each marking; None while its ways are explored."""

    def _changed(self, transition: pn.Transition, calls: list[tuple[pn.Place, pn.Place]]) -> Counter[pn.Node]:
        """Return what a transition changes; a request puts its response, too."""
        changed: Counter[pn.Node] = Counter()
        for arc in transition.incoming:
            if arc.kind == pn.ArcKind.normal:
                changed[resolve(arc.source)] -= arc.weight
        for arc in transition.outgoing:
            target = resolve(arc.target)
            changed[target] += arc.weight
            if target in self.body.requests:
                # Answers of other kinds do not come; their tokens stay, so that there is no bound.
                for request, response in calls:
                    if request is target:
                        changed[response] += arc.weight
        return changed

    def _is_own(self, node: pn.Node) -> bool:
        return (
            isinstance(node, pn.Place)
            and callback_page_of(node) is self.page
            and node not in self.fed
            and not is_changed_elsewhere(self.page, node)
        )

    def _takers(self) -> list[pn.Transition]:
        """Return the transitions that take nothing of the run's own: messages and requests start them."""
        return [
            transition
            for transition, changed in self.changes.items()
            if not any(number < 0 and node in self.own for node, number in changed.items())
        ]

    def put_in_turn(self) -> int | None:
        """Return the bound of a run that several overlap: it has one token, which moves without circles."""
        if any(self.body.continues(each) > 1 for each in self.body.transitions):
            return None
        if any(self.body.continues(each) for each in self.ends):
            return None
        return None if self._is_circular() else sum(self.puts.values())

    def _is_circular(self) -> bool:
        """Return whether a transition can follow itself."""
        left = {
            each: {
                after
                for after, changed in self.changes.items()
                if any(changed[node] < 0 < number for node, number in self.changes[each].items())
            }
            for each in self.changes
        }
        while left:
            last = {each for each, after in left.items() if not after & left.keys()}
            if not last:
                return True
            for each in last:
                del left[each]
        return False

    def explored(self, choose: Callable[[Iterable[int]], int] = max) -> int:
        """Return the most, or the least, that a run puts from its start to its end.

        Raises
        ------
        _UnboundedError
            Nothing bounds it.
        """
        first = Counter[pn.Node]({node: node.tokens for node in self.own if isinstance(node, pn.Place)})
        self.onward.clear()
        numbers = [
            self.puts[start] + self._from(after, first, start in self.ends, choose)
            for start in self.starts
            if (after := self._fired(start, first)) is not None
        ]
        return choose(numbers) if numbers else 0

    def _fired(self, transition: pn.Transition, marking: Counter[pn.Node]) -> Counter[pn.Node] | None:
        after = marking.copy()
        for node, number in self.changes[transition].items():
            if node in self.own:
                after[node] += number
                if after[node] < 0:
                    return None
        return after

    def _from(
        self,
        marking: Counter[pn.Node],
        first: Counter[pn.Node],
        is_over: bool,
        choose: Callable[[Iterable[int]], int],
    ) -> int:
        enabled = [
            (transition, after)
            for transition in self.changes.keys() - self.starts
            if (after := self._fired(transition, marking)) is not None
        ]
        if is_over:
            if enabled or +marking != +first:
                raise _UnboundedError
            return 0
        key = frozenset((+marking).items())
        if self.onward.get(key, 0) is None or len(self.onward) >= MOST_STATES:
            raise _UnboundedError
        if (known := self.onward.get(key)) is not None:
            return known
        self.onward[key] = None
        numbers = [
            self.puts[transition] + self._from(after, first, transition in self.ends, choose)
            for transition, after in enabled
        ]
        self.onward[key] = found = choose(numbers) if numbers else 0
        return found
