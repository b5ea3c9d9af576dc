"""Property directed reachability (IC3): what keeps a goal away is learned clause by clause.

Frame i holds clauses that are true of all markings that at most i steps reach. Where the last frame admits a
marking that meets the goal, that is to be excluded, with all markings from which the same transition leads
there, which are asked for in turn. A cube that cannot be reached from the frame before is generalised as
far as possible, and becomes a clause. Clauses that a step from their frame keeps continue to the next one:
where a frame loses all of its own, the next ones keep the goal away forever.

References
----------
A. R. Bradley, *SAT-based model checking without unrolling*, VMCAI 2011, LNCS 6538. N. Een, A. Mishchenko, R.
Brayton, *Efficient implementation of property directed reachability*, FMCAD 2011. Z. Hassan, A. R. Bradley,
F. Somenzi, *Better generalization in IC3*, FMCAD 2013.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import chain
from typing import Any

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.evidence import Inductive, Row
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.language.atoms import Condition
from dineros.analysis.logic.language.syntax import Atom, Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.proofs.encoding import Sums, Unrolling, within_limits
from dineros.analysis.proofs.induction import sums_of

PDR = "property directed reachability"

MOST_FRAMES = 10_000
MOST_QUERIES = 20_000
"""Of one solver: then a new one begins without what is left of them."""

MOST_COUNTEREXAMPLES = 3
"""Markings excluded on the way to a more general clause."""

Cube = tuple[int, ...]
"""Literals of a marking at time 0, all of which hold."""


def by_clauses(
    net: CompiledNet,
    goal: Formula,
    conditions: Mapping[Atom, Condition],
    budget: Budget,
    known: Sums | None = None,
) -> Outcome:
    """Look for a way to a goal, or for clauses that keep it away; asked and answered as `by_induction`."""

    def search(known: Sums, budget: Budget) -> Outcome:
        with closing(_PdrSearch(net, known, goal, conditions, budget)) as work:
            found = work.run()
        if isinstance(found, _PdrFinding):
            return Outcome("reachable", found.trace, seconds=budget.spent, by=PDR)
        evidence = Inductive(int(bool(found)), known.bounds, known.proofs, known.weightings, tuple(found))
        return Outcome("unreachable", seconds=budget.spent, by=PDR, evidence=evidence)

    return within_limits(search, budget.begun(), known or sums_of(net))


@dataclass(frozen=True)
class _PdrFinding:
    trace: tuple[int, ...]


@dataclass(frozen=True)
class _Wanted:
    """Markings from which a transition leads to those of another cube, or to the goal."""

    cube: Cube
    transition: int
    then: _Wanted | None

    def trace(self) -> tuple[int, ...]:
        """Return a path from its markings to the goal."""
        trace, wanted = [], self
        while wanted.then is not None:
            trace.append(wanted.transition)
            wanted = wanted.then
        return tuple(trace)


class _PdrSearch:
    def __init__(
        self,
        net: CompiledNet,
        known: Sums,
        goal: Formula,
        conditions: Mapping[Atom, Condition],
        budget: Budget,
    ) -> None:
        self.net, self.known, self.goal, self.conditions, self.budget = net, known, goal, conditions, budget
        self.frames: list[set[Cube]] = [set(), set()]
        """By number: cubes that this frame excludes, and those before, but none after it."""
        self.used: Counter[int] = Counter()
        """By literal: in how many cubes it was; these are left out last."""
        self.solver: Any = None

    def run(self) -> _PdrFinding | list[tuple[Row, ...]]:
        """Return a way to the goal, or clauses that exclude it and that every step keeps."""
        self._start()
        if self._solve([self.unrolling.begins, self.met]):
            return _PdrFinding(())
        while len(self.frames) <= MOST_FRAMES:
            while self._solve([*self._frame(len(self.frames) - 1), self.met]):
                found = self._exclude(_Wanted(self._meeting(), -1, None))
                if found is not None:
                    return found
            self.frames.append(set())
            self.guards.append(self.unrolling.new())
            kept = self._propagate()
            if kept is not None:
                return [tuple(self._row(-literal) for literal in cube) for cube in sorted(kept)]
        raise BudgetExceededError(f"{MOST_FRAMES} steps do not decide it")

    def close(self) -> None:
        """Give back what the solver takes."""
        if self.solver is not None:
            self.solver.delete()
            self.solver = None

    def _start(self) -> None:
        """Begin with a new solver that knows the frames; its variables are those of the one before."""
        from pysat.solvers import Glucose4

        self.close()
        self.solver = Glucose4()
        self.queries = 0
        self.unrolling = Unrolling(self.net, self.known, self.solver, self.conditions)
        self.met = self.unrolling.literal(self.goal, 0)
        self.unrolling.add_step(is_alone=True)
        self.literals, later = self.unrolling.markings
        self.place = {
            literal: (p, number)
            for p, literals in enumerate(self.literals)
            for number, literal in enumerate(literals, 1)
        }
        self.after = dict(zip(chain(*self.literals), chain(*later), strict=True))
        self.initial = {
            literal if self.net.initial[p] >= number else -literal
            for literal, (p, number) in self.place.items()
        }
        self.guards = [self.unrolling.begins]
        for number, cubes in enumerate(self.frames[1:], 1):
            self.guards.append(self.unrolling.new())
            for cube in cubes:
                self._tell(cube, number)

    # what is to be excluded

    def _exclude(self, wanted: _Wanted) -> _PdrFinding | None:
        """Exclude markings from the last frame, and before that from others whatever leads to them."""
        last = len(self.frames) - 1
        queue: list[tuple[int, int, _Wanted]] = []
        count = 0
        heappush(queue, (last, count, wanted))
        while queue:
            if self.queries > MOST_QUERIES:
                self._start()
            number, _, wanted = heappop(queue)
            if self.initial.issuperset(wanted.cube):
                return _PdrFinding(wanted.trace())
            if self._is_excluded(wanted.cube, number):
                if number < last:
                    count -= 1
                    heappush(queue, (number + 1, count, wanted))
                continue
            cube = self._unreached(wanted.cube, number - 1)
            count -= 1
            if cube is None:
                before = self._before(wanted)
                heappush(queue, (number, count, wanted))
                count -= 1
                heappush(queue, (number - 1, count, before))
                continue
            cube = self._generalised(cube, number - 1)
            while number < last and (more := self._unreached(cube, number)) is not None:
                cube, number = more, number + 1
            self._add(cube, number)
            if number < last:
                heappush(queue, (number + 1, count, wanted))
        return None

    def _is_excluded(self, cube: Cube, number: int) -> bool:
        parts = set(cube)
        if any(parts.issuperset(other) for frame in self.frames[number:] for other in frame):
            return True
        return not self._solve([*self._frame(number), *cube])

    def _before(self, wanted: _Wanted) -> _Wanted:
        """Return all markings from which the transition of the model leads to those of a cube."""
        model = self.solver.get_model()
        fires = self.unrolling.firings[0]
        transition = next(t for t, fired in enumerate(fires) if model[fired - 1] > 0)
        return _Wanted(self._leading_to(wanted.cube, transition), transition, wanted)

    def _leading_to(self, cube: Cube, transition: int) -> Cube:
        net, change = self.net, self.net.delta[transition]
        least: dict[int, int] = dict(net.pre.row(transition))
        most = {p: weight - 1 for p, weight in net.inhibitor.row(transition)}
        for literal in cube:
            p, number = self.place[abs(literal)]
            number -= change.get(p, 0)
            if literal > 0:
                least[p] = max(number, least.get(p, 0))
            else:
                most[p] = min(number - 1, most.get(p, number))
        found = [self.literals[p][number - 1] for p, number in least.items() if number > 0]
        found += [-self.literals[p][number] for p, number in most.items() if number < len(self.literals[p])]
        return tuple(sorted(found, key=abs))

    def _meeting(self) -> Cube:
        """Return markings that all meet the goal, the model's one among them."""
        model = self.solver.get_model()
        marking = self._strongest(literal for literal in self.place if model[literal - 1] > 0)
        self._solve([-self.met, *marking])  # which cannot be: its core says what meets the goal
        core = set(self.solver.get_core() or ())
        cube = [literal for literal in marking if literal in core]
        for literal in marking:
            fewer = [other for other in cube if other != literal]
            if len(fewer) < len(cube) and not self._solve([-self.met, *fewer]):
                core = set(self.solver.get_core() or ())
                cube = [other for other in fewer if other in core]
        return tuple(cube)

    def _strongest(self, held: Iterable[int]) -> Cube:
        """Return literals that name a marking: at least its tokens, and no more, of each place."""
        tokens = [0] * len(self.literals)
        for literal in held:
            p, number = self.place[literal]
            tokens[p] = max(tokens[p], number)
        found = [self.literals[p][number - 1] for p, number in enumerate(tokens) if number]
        found += [-self.literals[p][n] for p, n in enumerate(tokens) if n < len(self.literals[p])]
        return tuple(sorted(found, key=abs))

    # clauses

    def _unreached(self, cube: Cube, number: int) -> Cube | None:
        """Return a part of a cube that no step from other markings of a frame reaches; None without one."""
        guard = self.unrolling.new()
        self.solver.add_clause([-guard, *(-literal for literal in cube)])
        after = [self._next(literal) for literal in cube]
        is_reached = self._solve([guard, *self._frame(number), *after])
        core = () if is_reached else set(self.solver.get_core() or ())
        self.solver.add_clause([-guard])
        if is_reached:
            return None
        part = tuple(literal for literal, new in zip(cube, after, strict=True) if new in core)
        return self._without_initial(part, cube)

    def _without_initial(self, part: Cube, whole: Cube) -> Cube:
        if not self.initial.issuperset(part):
            return part
        first = next(literal for literal in whole if literal not in self.initial)
        return tuple(sorted((*part, first), key=abs))

    def _generalised(self, cube: Cube, number: int, is_deep: bool = True) -> Cube:
        """Leave literals out as long as no step from a frame reaches the cube."""
        for literal in sorted(cube, key=lambda one: (self.used[one], abs(one))):
            fewer = tuple(other for other in cube if other != literal)
            if len(fewer) < len(cube) and not self.initial.issuperset(fewer):
                smaller = self._down(fewer, number) if is_deep else self._unreached(fewer, number)
                cube = smaller or cube
        return cube

    def _down(self, cube: Cube, number: int) -> Cube | None:
        """Return a part of a cube that is not reached, once some of what reaches it is excluded itself."""
        for _ in range(MOST_COUNTEREXAMPLES):
            found = self._unreached(cube, number)
            if found is not None or number == 0:
                return found
            before = self._before(_Wanted(cube, -1, None)).cube
            smaller = None if self.initial.issuperset(before) else self._unreached(before, number - 1)
            if smaller is None:
                return None
            self._add(self._generalised(smaller, number - 1, is_deep=False), number)
        return None

    def _add(self, cube: Cube, number: int) -> None:
        parts = set(cube)
        for frame in self.frames[1 : number + 1]:
            frame -= {other for other in frame if parts.issubset(other)}
        self.frames[number].add(cube)
        self.used.update(cube)
        self._tell(cube, number)

    def _tell(self, cube: Cube, number: int) -> None:
        self.solver.add_clause([-self.guards[number], *(-literal for literal in cube)])

    def _propagate(self) -> set[Cube] | None:
        """Give clauses to the next frames; return those that every step keeps, once there are such."""
        for number in range(1, len(self.frames) - 1):
            for cube in sorted(self.frames[number], key=len):
                if cube not in self.frames[number]:
                    continue
                after = [self._next(literal) for literal in cube]
                if not self._solve([*self._frame(number), *after]):
                    core = set(self.solver.get_core() or ())
                    part = tuple(literal for literal, new in zip(cube, after, strict=True) if new in core)
                    self._add(self._without_initial(part, cube), number + 1)
            if not self.frames[number]:
                return {cube for frame in self.frames[number + 1 :] for cube in frame}
        return None

    # the solver

    def _frame(self, number: int) -> list[int]:
        return [self.unrolling.begins] if number == 0 else self.guards[number:]

    def _next(self, literal: int) -> int:
        return self.after[literal] if literal > 0 else -self.after[-literal]

    def _row(self, literal: int) -> Row:
        p, number = self.place[abs(literal)]
        return ({p: 1}, number) if literal > 0 else ({p: -1}, 1 - number)

    def _solve(self, assumptions: Sequence[int]) -> bool:
        self.queries += 1
        return self.unrolling.solve(assumptions, len(self.frames), self.budget)
