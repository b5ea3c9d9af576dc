"""When the engine of a node of the execution `net` fires a transition, and what can keep it from that."""

from __future__ import annotations

from dineros.analysis.bounds.reading import Tasks
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import label, node_nets, resolve
from dineros.metamodel.times.given import reaction_of
from dineros.metamodel.times.handlers import handled_for, handled_until, is_kept_back
from dineros.metamodel.times.rates import seconds_of
from dineros.metamodel.times.runs import ports_at

_COPIED = {sym.CallbackKind.server, sym.CallbackKind.goal}
"""Callbacks of which each instance has places of its own."""


class OpenError(Exception):
    """Nothing bounds it; the message says why."""


class EngineFirings:
    """Says within which time transitions fire, in units of time.

    `tasks`: what the transitions do, and the unit.
    """

    def __init__(self, tasks: Tasks) -> None:
        self._tasks, self._works = tasks, tasks.works

    def reaction(self, node: sym.NodeNet) -> int:
        """Return how long the engine of a node takes at most."""
        reaction = reaction_of(node)
        if reaction is None or reaction.latest is None:
            raise OpenError(f"the reaction of node {label(node)} is not given")
        return self._tasks.units(seconds_of(reaction.latest))

    def fired(self, place: pn.Place, node: sym.NodeNet) -> int:
        """Return within which time a token of a place is taken by some transition."""
        around, moves = self._works.around[place], self._works.moves
        if any(moves[each].needs(place) > 1 for each in around):
            raise OpenError(f"transitions of node {label(node)} put messages back, or take several")
        found = [
            time
            for each in around
            if moves[each].takes[place] and set(moves[each].takes) == {place}
            if (time := self.latest(each, node)) is not None
        ]
        if not found:
            raise OpenError(self._why_waiting(place, node))
        return min(found)

    def _why_waiting(self, place: pn.Place, node: sym.NodeNet) -> str:
        """Return what the first transition needs that could take all tokens of a place, in words."""
        what = f"no transition of node {label(node)} takes each message within a time"
        moves, works = self._works.moves, self._works
        for each in works.around[place]:
            needs, name = moves[each], f"transition {label(each)}"
            if not needs.takes[place]:
                continue
            others = [other for other in {**needs.takes, **needs.reads} if other is not place]
            wanting = next((other for other in others if not self._is_there(other, needs.needs(other))), None)
            if wanting is not None:
                return f"{what}: {name} needs place {label(wanting)}, too"
            if isinstance(each, sym.Transition) and each.guard is not None:
                return f"{what}: {name} has a guard"
            if isinstance(each, sym.Transition) and each.clause is not None:
                return f"{what}: {name} waits for signals"
            if needs.inhibits or each in works.overridden:
                return f"{what}: {name} can be kept from firing by an inhibitor arc, or by another transition"
            if is_kept_back(each):
                return f"{what}: handlers in flight can keep {name} from firing"
            if full := next((other for other in needs.puts if not self._is_open(other, each)), None):
                return f"{what}: {name} needs room at place {label(full)}"
            return f"{what}: the latest time of {name} is not given"
        return what

    def latest(self, move: pn.Transition, node: sym.NodeNet) -> int | None:
        """Return within which time a transition fires that has what it takes; None if it may wait."""
        works = self._works
        needs = works.moves[move]
        tested = set(needs.reads) - set(needs.takes)
        if not all(self._is_there(place, needs.reads[place]) for place in tested):
            return None
        if needs.inhibits or move in works.overridden:
            return None
        if is_kept_back(move) or not all(self._is_open(place, move) for place in needs.puts):
            return None
        if isinstance(move, sym.Transition) and (move.clause is not None or move.guard is not None):
            return None
        if handled_for(move) is not None:
            until = handled_until(node, move)
            return None if until is None else self._tasks.units(seconds_of(until))
        if move.interval is None:
            return self.reaction(node)
        latest = move.interval.latest
        return None if latest is None else self._tasks.units(seconds_of(latest))

    def earliest(self, move: pn.Transition, node: sym.NodeNet) -> int:
        """Return how long a transition waits at least from the moment at which it can fire."""
        if move.interval is not None:
            return self._tasks.units(seconds_of(move.interval.earliest or 0.0))
        return 0 if handled_for(move) is not None or is_kept_back(move) else self.reacts_from(node)

    def reacts_from(self, node: sym.NodeNet) -> int:
        """Return how long it takes at least."""
        reaction = reaction_of(node)
        return 0 if reaction is None else self._tasks.units(seconds_of(reaction.earliest or 0.0))

    def _takes_all(self, client: sym.ClientPort, place: pn.Place) -> bool:
        """Return whether a place of requests has room for any number of them."""
        is_plain = place_of(client.request) is place and client.outstanding != UNLIMITED
        return is_plain and not any(node.lifecycle is not None for node in node_nets(self._tasks.model))

    def _is_there(self, place: pn.Place, number: int) -> bool:
        """Return whether a place holds tokens that no transition takes, not even to put them back."""
        page, moves = callback_page_of(place), self._works.moves
        if ports_at(place) or (page is not None and page.kind in _COPIED) or place.tokens < number:
            return False
        return not any(moves[each].takes[place] for each in self._works.around[place])

    def _is_open(self, place: pn.Place, move: pn.Transition) -> bool:
        """Return whether a place has room for what a transition puts, and its room restarts no clock.

        A message that is published has room for a moment only after the one before has left; so no other
        transition may publish there. Requests have room always.
        """
        if place.capacity:
            return False
        ports = ports_at(place)
        if ports and all(isinstance(port, sym.ClientPort) and self._takes_all(port, place) for port in ports):
            return True
        is_published = all(isinstance(port, sym.PublisherPort) for port in ports)
        return not ports or (is_published and self._works.around[place] == [move] and not place.tokens)

    def is_pool(self, place: pn.Place) -> bool:
        """Return whether a place holds what it has at the start, until transitions take that."""
        page, moves = callback_page_of(place), self._works.moves
        if ports_at(place) or (page is not None and page.kind in _COPIED):
            return False
        return not any(moves[each].puts[place] for each in self._works.around[place])

    def is_inside(self, place: pn.Place) -> bool:
        """Return whether only transitions of the node put tokens on a place and take them, one at a time.

        Each token is new: nothing is there at the start, and no transition puts one back.
        """
        page, moves = callback_page_of(place), self._works.moves
        if ports_at(place) or place.tokens or place.capacity or (page is not None and page.kind in _COPIED):
            return False
        around = self._works.around[place]
        return not any(moves[each].takes[place] and moves[each].puts[place] for each in around)


def place_of(place: pn.Node) -> pn.Place:
    """Return a place, or the one that a reference stands for."""
    found = resolve(place)
    assert isinstance(found, pn.Place)
    return found
