"""CTL's sets of states as decision diagrams, and runs that show why a formula is true.

"Until" is one constrained saturation. "Globally" is the set of markings that can reach, inside the set, a
marking that is its own successor, or one from which repeatable transitions continue forever.

References
----------
Y. Zhao, G. Ciardo, *Symbolic CTL model checking of asynchronous systems using constrained saturation*, ATVA
2009, LNCS 5799.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, cached_property, partial
from operator import itemgetter
from typing import Any

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.logic.ctl.climbing import climb
from dineros.analysis.logic.ctl.state_sets import Run
from dineros.analysis.logic.language.atoms import BoundAtoms, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.syntax import Atom, Exists, Formula, Globally, Next, Until
from dineros.analysis.logic.verdicts.verdict import Marking, ReplayError, fired, replayed
from dineros.analysis.nets.repetition import repeatable_transitions
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import moves
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.symbolic.vector_sets import Scope, VectorSets


class SymbolicSets:
    """The `StateSets` of a symbolic state space. A set is the number of a node, pinned until the end.

    Parameters
    ----------
    atoms : BoundAtoms, optional
        The atoms that may be evaluated; without it, there are none.
    budget : Budget, optional
        Its progress is reported periodically; when its time is over, the computation ends.
    """

    def __init__(
        self, space: SymbolicStateSpace, atoms: BoundAtoms | None = None, budget: Budget = UNLIMITED
    ) -> None:
        self.space = space
        self._conditions = {} if atoms is None else atoms.conditions
        self.sets = VectorSets(space.diagram, budget)
        self.everything = space.diagram.root
        #: For each set, the markings in which its infinite runs end: own successors, or infinite repeatable
        #: steps.
        self._ends: dict[int, int] = {}

    def constant(self, value: bool) -> int:
        """Return all states or none."""
        return self.everything if value else 0

    def atom(self, atom: Atom) -> int:
        """Return the states in which an atom is true."""
        match self._conditions[atom]:
            case Linear(factors, symbol, bound):
                return self._pinned(self._sums(factors, symbol, bound))
            case SomeEnabled(transitions):
                boxes = [box for t in sorted(transitions) for box in self.space.event_masks(t)]
                return self.complement(self.sets.without_boxes(self.everything, boxes))
            case NoneEnabled():
                return self._deadlocks
        raise TypeError(f"no atom of CTL: {atom}")

    def complement(self, states: int) -> int:
        """Return the other states."""
        return self._pinned(self.sets.difference(self.everything, states))

    def intersection(self, left: int, right: int) -> int:
        """Return the states in both sets."""
        return self._pinned(self.sets.intersection(left, right))

    def union(self, left: int, right: int) -> int:
        """Return the states in at least one of the sets."""
        return self._pinned(self.sets.union(left, right))

    def some_next(self, states: int) -> int:
        """EX: return the states with a successor in a set."""
        moving = self._pinned(self.sets.image(states, self.everything, backwards=True))
        return self.union(moving, self.sets.intersection(states, self._unchanged))

    def some_until(self, stay: int, goal: int) -> int:
        """EU: return the states from which some run stays in one set until it is in the other."""
        within = self.union(stay, goal)
        return self._pinned(self.sets.closure(goal, within, backwards=True))

    def some_globally(self, states: int) -> int:
        """EG: return the states from which some run never leaves a set."""
        sets, unchanged = self.sets, self._unchanged
        with Scope(self.space.diagram) as scope:
            still = sets.intersection(states, unchanged)
            scope.hold(still)
            # Every infinite run ends with repeatable transitions only.
            ends = sets.union(self._going_on(states), still)
            scope.hold(ends)
            lasting = sets.closure(ends, states, backwards=True)
        self._ends[lasting] = self._pinned(ends)
        return self._pinned(lasting)

    def _going_on(self, states: int) -> int:
        """Markings from which some infinite run of repeatable transitions never leaves a set.

        Few rounds of trimming are sufficient if there are few repeatable transitions; otherwise, strongly
        connected components are computed as well.
        """
        sets = self._repeating
        lasting, rounds = 0, 1
        with Scope(self.space.diagram) as scope:
            while states:
                scope.hold(lasting, states)
                states, is_fixed = self._trimmed(states, rounds)
                rounds *= 2
                if is_fixed:
                    return sets.union(lasting, states)
                scope.hold(lasting, states)
                part, single = sets.last_part(states)
                if single:
                    continue
                found = sets.closure(part, states, backwards=True)
                scope.hold(states, lasting, found)
                lasting = sets.union(lasting, found)
                scope.hold(states, lasting, found)
                states = sets.difference(states, found)
        return lasting

    def initially(self, states: int) -> bool:
        """Whether the initial state is in a set."""
        return self.contains(states, tuple(self.space.net.initial.tolist()))

    def contains(self, states: int, marking: Marking) -> bool:
        """Whether a reachable marking is in a set."""
        return self.sets.contains(states, self._vector(marking))

    def single(self, marking: Marking) -> int:
        """Return the set of one marking."""
        return self.sets.single(self._vector(marking))

    def path(self, path: Formula, found: Mapping[Formula, int]) -> Run:
        """Return a replayed run from the initial state that shows a basic path formula."""
        start: Marking = tuple(self.space.net.initial.tolist())
        stem: tuple[int, ...] = ()
        loop: tuple[int, ...] = ()
        match path:
            case Next(operand):
                stem = self._step(start, found[operand])
            case Until(left, right):
                stem = self._way(start, found[left], found[right], found[Exists(path)])
            case Globally():
                stem, loop = self._lasso(start, found[Exists(path)])
            case _:
                raise TypeError(f"no basic path formula: {path}")
        first, again = replayed(self.space.net, stem, loop, must_loop=isinstance(path, Globally))
        self._check(path, found, [step.marking for step in (*first, *again)])
        return stem, loop

    def way_to(self, goal: int) -> tuple[int, ...]:
        """Return transitions that lead from the initial marking into a set of reachable markings."""
        near = self._pinned(self.sets.closure(goal, self.everything, backwards=True))
        start = tuple(self.space.net.initial.tolist())
        route = self._way(start, self.everything, goal, near)
        if not self.contains(goal, fired(self.space.net, start, route)[1]):
            raise ReplayError("a way does not lead to its goal")
        return route

    def way_between(self, start: Marking, goal: int) -> tuple[int, ...]:
        """Return transitions that lead from a marking into a set that it can reach; none is redundant."""
        net = self.space.net
        initial = np.array(start, dtype=np.int64)
        route = self._route(self.sets, start, self.everything, goal)
        here = replace(net, initial=initial)
        return shortened(here, route, lambda marking: self.contains(goal, tuple(marking)))

    def _check(self, path: Formula, found: Mapping[Formula, int], markings: list[Marking]) -> None:
        match path:
            case Next(operand):
                good = self.contains(found[operand], markings[-1])
            case Until(left, right):
                good = all(self.contains(found[left], m) for m in markings[:-1])
                good &= self.contains(found[right], markings[-1])
            case _:
                good = all(self.contains(found[path.operands[0]], m) for m in markings)
        if not good:
            raise ReplayError(f"a witness does not show {path}")

    def _pinned(self, states: int) -> int:
        self.space.diagram.pinned.append(states)
        return states

    def _vector(self, marking: Marking) -> list[int]:
        """Local states, in the order of the encoding's levels."""
        return [positions[pick(marking)] for pick, positions in self._positions]

    @cached_property
    def _positions(self) -> list[tuple[Callable[[Marking], Any], dict[Any, int]]]:
        """For each level, a function that gets its local state from a marking, and the states' numbers."""
        return [
            (itemgetter(*level.places), {s if s[1:] else s[0]: i for i, s in enumerate(level.states)})
            for level in self.space.encoding.levels
        ]

    @cached_property
    def _repeating(self) -> VectorSets:
        """The same sets, with only the steps that may be on cycles."""
        return self.sets.restricted(self._repeatable)

    @cached_property
    def _repeatable(self) -> frozenset[int]:
        return repeatable_transitions(self.space.net)

    @cached_property
    def _deadlocks(self) -> int:
        return self._pinned(self.sets.without_boxes(self.everything, self.space.event_masks()))

    @cached_property
    def _unchanged(self) -> int:
        """Markings that are their own successors: deadlocks, and markings with an ineffective firing."""
        boxes = [
            {k: [j >= 0 for j in table] for k, table in event.tables.items()}
            for event in self.space.encoding.events
            if not event.is_change
        ]
        idle = self.complement(self.sets.without_boxes(self.everything, boxes))
        return self.union(self._deadlocks, idle)

    def _sums(self, factors: Mapping[int, int], symbol: str, bound: int) -> int:
        weights, constant = self.space.encoding.weights_of(factors)
        bound -= constant
        low, high = {
            "<": (None, bound - 1),
            "<=": (None, bound),
            "==": (bound, bound),
            "!=": (bound, bound),
            ">=": (bound, None),
            ">": (bound + 1, None),
        }[symbol]
        found = self.sets.intersection(self.everything, self.sets.sums(weights, low, high))
        return self.sets.difference(self.everything, found) if symbol == "!=" else found

    def _trimmed(self, states: int, rounds: int) -> tuple[int, bool]:
        """Remove markings that no repeatable step keeps in a set, several times; whether this is complete."""
        with Scope(self.space.diagram) as scope:
            for _ in range(rounds):
                scope.hold(states)
                smaller = self._repeating.image(states, states, backwards=True)
                if smaller == states:
                    return states, True
                states = smaller
        return states, states == 0

    def _step(self, marking: Marking, goal: int) -> tuple[int, ...]:
        for transition, after in moves(self.space.net, marking):
            if self.contains(goal, after):
                return (transition,)
        return ()  # it stays in a deadlock

    def _lasso(self, start: Marking, lasting: int) -> Run:
        unchanged, ends = self._unchanged, self._ends[lasting]
        stem = self._way(start, lasting, ends, lasting)
        marking = fired(self.space.net, start, stem)[1]
        sets = self._repeating
        with Scope(self.space.diagram) as scope:
            single = self.single(marking)
            scope.hold(single)
            ahead = sets.closure(single, ends, backwards=False)
            scope.hold(ahead)
            still = sets.intersection(ahead, unchanged)
            part = still or sets.last_part(ahead)[0]
            scope.hold(ahead, part)
            stem += self._route(sets, marking, ahead, part)
            marking = fired(self.space.net, start, stem)[1]
            if still:
                return stem, tuple(t for t, after in moves(self.space.net, marking) if after == marking)[:1]
            first, after = next(
                move for move in moves(self.space.net, marking) if self.contains(part, move[1])
            )
            home = self.single(marking)
            scope.hold(part, home)
            return stem, (first, *self._route(sets, after, part, home))

    def _way(self, start: Marking, stay: int, goal: int, near: int) -> tuple[int, ...]:
        """Transitions from a marking to a set through another one; `near`: markings that can reach it so."""
        net = self.space.net
        is_goal = cache(partial(self.contains, goal))
        route = climb(net, start, partial(self.contains, near), is_goal, self._repeatable)
        if route is None:
            return self._route(self.sets, start, stay, goal)
        if stay != self.everything:
            return route
        return shortened(net, route, lambda marking: is_goal(tuple(marking)))

    def _route(self, sets: VectorSets, start: Marking, stay: int, goal: int) -> tuple[int, ...]:
        """Transitions from a marking to a set through another one, with at most as many steps as layers.

        A layer is the set of markings that can reach the goal by firing the events in turn, so that a step
        always leads to an earlier layer.
        """
        diagram = self.space.diagram
        with Scope(diagram) as scope:
            scope.hold(stay, goal)
            within = sets.union(stay, goal)
            scope.hold(within, goal)
            within = sets.closure(self.single(start), within, backwards=False)
            scope.hold(within, goal)
            layers = [sets.intersection(goal, within)]
            near = sets.neighbours
            queue: dict[int, None] = {}
            vector = self._vector(start)
            while not self.sets.contains(layers[-1], vector):
                # An event that added markings makes its neighbours worth trying; if none is left, all events
                # are done.
                queue = queue or dict.fromkeys(range(sets.events))
                event = next(iter(queue))
                del queue[event]
                scope.hold(within, *layers)
                added = sets.event_image(layers[-1], within, event, backwards=True)
                larger = sets.union(layers[-1], added)
                if larger != layers[-1]:
                    layers.append(larger)
                    queue.update(dict.fromkeys(near[event]))
            scope.hold(*layers)
            events = self.space.encoding.events
            return tuple(events[n].transition for n in self.sets.descent(vector, layers))
