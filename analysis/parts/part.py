"""Parts of a net that grow only as far as a question needs them.

A part is some places with the transitions that change them. Conditions on other places are ignored, so each
run of the net is a run of the part: what no run of the part does, no run of the net does. A run of the part
is fired in the net. If the net can fire it, the part has shown a run of the net. Otherwise, the places that
block it are added to the part (E. Clarke et al., *Counterexample-guided abstraction refinement for symbolic
model checking*, JACM 50(5), 2003). Places of one semiflow are added together: together they have few
markings, such as the steps of one callback, of which exactly one is reached.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from functools import cached_property

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.nets.bounds import Bound, FlowsAndBounds, flows_and_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.structure import PlaceInvariant, never_possible
from dineros.analysis.reductions.cut_out import cut_out
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

TOO_LARGE = (BudgetExceededError, LevelSizeError, UnknownBoundError, DiagramMemoryError)
"""Errors that end the work on a part: it is too large for the budget."""

PARTS_TOO_LARGE = "the relevant parts of the net are too large"

MOST_TOGETHER = 40
"""Largest number of places of a semiflow that are added together."""


class Whole:
    """A net that is analysed in parts.

    `dead`: transitions that can never fire; no part has them.

    Attributes
    ----------
    dead : set of int
        Transitions that are proved never to fire.
    free : dict of int to int
        For each place with a proved bound, how many tokens it may have beyond its initial ones. Only these
        places can belong to a part.
    """

    def __init__(self, net: CompiledNet, dead: Collection[int] = ()) -> None:
        self.net = net
        self.flows, self.bounds = net.once(flows_and_bounds)
        self.free = {
            p: bound.value - int(net.initial[p]) for p, bound in enumerate(self.bounds) if bound is not None
        }
        self.dead: set[int] = set(dead)
        self._flows = [set(flow.weights) for flow in self.flows or () if len(flow.weights) <= MOST_TOGETHER]
        self._together: dict[int, set[int]] = {}
        self.prove_dead(())

    def prove_dead(self, transitions: Iterable[int]) -> None:
        """Record that transitions never fire, and others that need what only these would make."""
        self.dead.update(transitions)
        self.dead |= never_possible(self.net, self.dead)

    def takes(self, transition: int) -> set[int]:
        """Return the places that decide whether a transition is enabled."""
        return self._takes[transition]

    def grown(self, places: Iterable[int]) -> set[int]:
        """Return places with those of a small semiflow of each, as far as they have bounds."""
        found: set[int] = set()
        for place in places:
            if place not in self._together:
                own = min((flow for flow in self._flows if place in flow), key=len, default={place})
                self._together[place] = {p for p in (*own, place) if p in self.free}
            found |= self._together[place]
        return found

    def blocking(self, transition: int, marking: Sequence[int]) -> set[int]:
        """Return the places that keep a transition from firing in a marking of the net."""
        few = {p for p, weight in self.net.pre.row(transition) if marking[p] < weight}
        return few | {p for p, weight in self.net.inhibitor.row(transition) if marking[p] >= weight}

    def lifted(self, way: Iterable[int]) -> tuple[list[int], set[int]]:
        """Fire transitions in the net; return the last marking, and the places that block some of them.

        After a transition that is blocked, the others are tried as if the tokens that it lacks were there: so
        more of what blocks the run is known at once. The marking is one of the net if nothing blocks.
        """
        marking: list[int] = self.net.initial.tolist()
        found: set[int] = set()
        for transition in way:
            found |= self.blocking(transition, marking)
            for place, tokens in self.net.delta[transition].items():
                marking[place] = max(0, marking[place] + tokens)
        return marking, found

    @cached_property
    def _takes(self) -> list[set[int]]:
        tables = self.net.pre, self.net.inhibitor
        return [{p for table in tables for p, _ in table.row(t)} for t in range(len(self.net.transitions))]


class GrowingPart:
    """All markings of a part of a net.

    Parameters
    ----------
    places : collection of int
        Places of the part; they have bounds.
    asked : collection of int
        Further transitions of interest that only test these places.
    budget : Budget
        Time and memory.
    most_work : int
        Cache misses of saturation that the markings may cost.

    Attributes
    ----------
    transitions : list of int
        For each transition of the part, its number in the net.

    Raises
    ------
    BudgetExceededError, LevelSizeError, UnknownBoundError, DiagramMemoryError
        The part is too large, see `TOO_LARGE`.
    """

    def __init__(
        self, whole: Whole, places: Collection[int], asked: Collection[int], budget: Budget, most_work: int
    ) -> None:
        self.whole = whole
        self.places = set(places)
        net, order = whole.net, sorted(places)
        users = set(asked).union(*(net.changing[place] for place in order))
        self.transitions = sorted(users - whole.dead)
        self.net = cut_out(net, order, self.transitions, whole.free)

        def stop(work: int) -> None:
            if work > most_work:
                raise BudgetExceededError(PARTS_TOO_LARGE)

        self.space = symbolic_state_space(self.net, budget, between=stop, facts=self._facts(order))
        if not self.space.complete:
            raise BudgetExceededError(RAN_OUT[self.space.reason])
        self.sets = SymbolicSets(self.space, budget=budget)

    def _facts(self, order: Sequence[int]) -> FlowsAndBounds:
        """Return semiflows and bounds of the part: those of the net that lie in it, and the complements.

        A weighting of places of the part changes with each transition as it does in the net. To find all
        semiflows of each part again takes longer than its markings.
        """
        whole, number = self.whole, {place: number for number, place in enumerate(order)}

        def own(weights: Mapping[int, int]) -> dict[int, int] | None:
            return {number[p]: w for p, w in weights.items()} if weights.keys() <= number.keys() else None

        pairs = [{number: 1, len(order) + number: 1} for number in range(len(order))]
        inside = [weights for flow in whole.flows or () if (weights := own(flow.weights)) is not None]
        flows = [PlaceInvariant.of(self.net, weights) for weights in (*pairs, *inside)]
        bounds = []
        for place, pair in zip(order, flows, strict=False):
            known = whole.bounds[place]
            weights = None if known is None else own(known.weights)
            better = None if known is None or weights is None else Bound(known.value, weights)
            bounds.append(better or Bound(pair.constant, pair.weights))
        rooms = [Bound(pair.constant, pair.weights) for pair in flows[: len(order)]]
        return flows, bounds + rooms

    def is_certain(self, transition: int) -> bool:
        """Whether places outside the part never keep a transition from firing."""
        return self.whole.takes(transition) <= self.places

    def is_dead(self, transition: int) -> bool:
        """Whether no marking of the part enables a transition of the part: then it never fires in the net."""
        return self.space.enabled(self.whole.net.transitions[transition]) == 0

    def way_to_enabled(self, transition: int) -> tuple[int, ...]:
        """Return transitions of the net that lead to a marking of the part that enables one of its own."""
        found = 0
        for masks in self.space.event_masks(self.transitions.index(transition)):
            found = self.sets.union(found, self.sets.sets.box(masks))
        return self.way_to(self.sets.intersection(self.sets.everything, found))

    def way_to(self, states: int) -> tuple[int, ...]:
        """Return transitions of the net that lead to some of the markings of the part."""
        return tuple(self.transitions[number] for number in self.sets.way_to(states))
