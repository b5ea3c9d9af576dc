"""Nets whose places hold few tokens, as propositional formulas: markings at several times, and steps.

A place of which at most b tokens are proved has b literals at each time: literal i says that it holds at
least i. A step fires one transition or several that touch no place which another one of them changes, so
that they may fire in any order. Every marking is within the bounds, and has the invariants' sums.

References
----------
K. Heljanko, *Bounded reachability checking with process semantics*, CONCUR 2001, LNCS 2154 (steps).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.logic.language.atoms import Condition, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.syntax import And, Atom, Constant, Equivalent, Formula, Implies, Not, Or
from dineros.analysis.nets.compiled import CompiledNet

#: Clauses of all times together.
MOST_CLAUSES = 2_000_000
CONFLICTS = 2_000
"""Of a solver between two looks at the clock."""


class TooLargeError(Exception):
    """The formula would be too large."""


@dataclass(frozen=True)
class Sums:
    """What is known of all reachable markings.

    Attributes
    ----------
    bounds : tuple of int
        By place: most tokens.
    proofs : tuple of mapping
        By place: the weights of places that prove its bound.
    weightings : tuple of mapping
        Place -> weight: sums that no firing changes.
    """

    bounds: tuple[int, ...]
    proofs: tuple[Mapping[int, int], ...]
    weightings: tuple[Mapping[int, int], ...] = ()


class Unrolling:
    """Markings at the times 0, 1, 2 ... in a solver, with a step between any two.

    Parameters
    ----------
    solver : Any
        One of python-sat, without clauses.
    conditions : mapping
        What the atoms of formulas ask.

    Attributes
    ----------
    markings : list of list of list of int
        By time, by place: its literals.
    firings : list of list of int
        By step, by transition: whether it fires.
    begins : int
        Assumed, it makes the first marking the initial one.
    """

    def __init__(
        self, net: CompiledNet, known: Sums, solver: Any, conditions: Mapping[Atom, Condition]
    ) -> None:
        self.net, self.known, self._solver, self._conditions = net, known, solver, conditions
        self.markings: list[list[list[int]]] = []
        self.firings: list[list[int]] = []
        self._variables = self._clauses = 0
        self.true = self._fresh()
        self._add(self.true)
        self._changers = [list(changing) for changing in net.changing]
        self._add_marking()
        self.begins = self._fresh()
        for literals, tokens in zip(self.markings[0], net.initial.tolist(), strict=True):
            for number, literal in enumerate(literals, 1):
                self._add(-self.begins, literal if tokens >= number else -literal)

    def add_step(self) -> None:
        """Add a step after the last marking, and the marking after it."""
        before = self.markings[-1]
        self._add_marking()
        after = self.markings[-1]
        net = self.net
        fires = [self._fresh() for _ in net.transitions]
        self.firings.append(fires)
        self._add(*fires)
        changed = [self._fresh() for _ in net.places]
        for t, fired in enumerate(fires):
            for place, weight in net.pre.row(t):
                self._add(-fired, self._holds(before, place, weight))
            for place, weight in net.inhibitor.row(t):
                self._add(-fired, -self._holds(before, place, weight))
            change = net.delta[t]
            for place, _ in (*net.pre.row(t), *net.inhibitor.row(t)):
                if place not in change:
                    self._add(-fired, -changed[place])
            for place, tokens in change.items():
                self._add(-fired, changed[place])
                self._move(fired, before, after, place, tokens)
        for place, changers in enumerate(self._changers):
            self._at_most_one([fires[t] for t in changers])
            more = [fires[t] for t in changers if net.delta[t][place] > 0]
            less = [fires[t] for t in changers if net.delta[t][place] < 0]
            for old, new in zip(before[place], after[place], strict=True):
                self._add(-new, old, *more)
                self._add(new, -old, *less)

    def literal(self, formula: Formula, time: int) -> int:
        """Return a literal that is true iff a condition holds in the marking of a time."""
        found: dict[Formula, int] = {}
        for part in formula.subformulas():
            operands = [found[operand] for operand in part.operands]
            match part:
                case Constant(value):
                    found[part] = self.true if value else -self.true
                case Atom():
                    found[part] = self._condition(self._conditions[part], time)
                case Not():
                    found[part] = -operands[0]
                case And():
                    found[part] = self._all(operands)
                case Or():
                    found[part] = self._any(operands)
                case Implies():
                    found[part] = self._any([-operands[0], operands[1]])
                case Equivalent():
                    both, neither = self._all(operands), self._all([-literal for literal in operands])
                    found[part] = self._any([both, neither])
                case _:
                    raise TypeError(f"no condition: {part}")
        return found[formula]

    def solve(self, assumptions: Sequence[int], steps: int, budget: Budget) -> bool:
        """Whether all clauses can be true together with some literals; `steps` is reported as progress.

        Raises
        ------
        BudgetExceededError
            When time is up.
        """
        while True:
            budget.report(Progress("steps", steps, 0))
            self._solver.conf_budget(CONFLICTS)
            found = self._solver.solve_limited(assumptions=list(assumptions))
            if found is not None:
                return bool(found)

    def trace(self, steps: int, model: Sequence[int]) -> tuple[int, ...]:
        """Return the firings of the first steps in a model."""
        return tuple(
            t
            for fires in self.firings[:steps]
            for t, fired in enumerate(fires)
            if model[fired - 1] > 0  # models name every variable in order
        )

    def _add_marking(self) -> None:
        marking = [[self._fresh() for _ in range(bound)] for bound in self.known.bounds]
        self.markings.append(marking)
        for literals in marking:
            for less, more in pairwise(literals):
                self._add(-more, less)
        for weights in self.known.weightings:
            total = sum(int(self.net.initial[place]) * weight for place, weight in weights.items())
            at_least, more = self._sum(marking, weights, total), self._sum(marking, weights, total + 1)
            self._add(at_least)
            self._add(-more)

    def _move(
        self, fired: int, before: list[list[int]], after: list[list[int]], place: int, tokens: int
    ) -> None:
        bound = len(after[place])
        for number in range(1, bound + 1):
            old, new = self._holds(before, place, number - tokens), after[place][number - 1]
            self._add(-fired, -old, new)
            self._add(-fired, old, -new)
        if tokens > 0:
            self._add(-fired, -self._holds(before, place, bound - tokens + 1))

    def _holds(self, marking: list[list[int]], place: int, tokens: int) -> int:
        """Return a literal which states that a place holds at least this number of tokens."""
        if tokens <= 0:
            return self.true
        return marking[place][tokens - 1] if tokens <= len(marking[place]) else -self.true

    def _condition(self, condition: Condition, time: int) -> int:
        marking, net = self.markings[time], self.net
        match condition:
            case Linear(factors, symbol, bound):
                least, more = (self._sum(marking, factors, number) for number in (bound, bound + 1))
                return {
                    ">=": least,
                    "<": -least,
                    ">": more,
                    "<=": -more,
                    "==": self._all([least, -more]),
                    "!=": self._any([-least, more]),
                }[symbol]
            case SomeEnabled(transitions):
                return self._any([self._enabled(marking, t) for t in sorted(transitions)])
            case NoneEnabled():
                return -self._any([self._enabled(marking, t) for t in range(len(net.transitions))])
        raise TypeError(f"no condition on markings: {condition}")

    def _enabled(self, marking: list[list[int]], transition: int) -> int:
        net = self.net
        needs = [self._holds(marking, place, weight) for place, weight in net.pre.row(transition)]
        blocks = [-self._holds(marking, place, weight) for place, weight in net.inhibitor.row(transition)]
        return self._all([*needs, *blocks])

    def _sum(self, marking: list[list[int]], factors: Mapping[int, int], least: int) -> int:
        """A literal for: a weighted sum of tokens is at least a number; by a diagram over the literals."""
        terms: list[tuple[int, int]] = []
        for place, factor in factors.items():
            for literal in marking[place]:
                terms.append((literal, factor) if factor > 0 else (-literal, -factor))
                least += 0 if factor > 0 else -factor
        rest = [0]
        for _, weight in reversed(terms):
            rest.append(rest[-1] + weight)
        rest.reverse()
        # Both sides of a diagram's node, from the last literal to the first.
        nodes: dict[int, int] = {}
        needed: list[set[int]] = [{least}]
        for _, weight in terms[:-1]:
            number = len(needed)
            needed.append({n for need in needed[-1] for n in (need, need - weight) if 0 < n <= rest[number]})

        def node(need: int, remaining: int) -> int:
            return self.true if need <= 0 else -self.true if need > remaining else nodes[need]

        if not terms or least <= 0 or least > rest[0]:
            return self.true if least <= 0 else -self.true
        for number in reversed(range(len(terms))):
            literal, weight = terms[number]
            remaining = rest[number + 1]
            made = {}
            for need in needed[number]:
                without, with_it = node(need, remaining), node(need - weight, remaining)
                made[need] = self._any([without, self._all([literal, with_it])])
            nodes = made
        return nodes[least]

    def _all(self, literals: Iterable[int]) -> int:
        return -self._any([-literal for literal in literals])

    def _any(self, literals: Iterable[int]) -> int:
        wanted = {literal for literal in literals if literal != -self.true}
        if self.true in wanted or any(-literal in wanted for literal in wanted):
            return self.true
        if len(wanted) < 2:
            return next(iter(wanted), -self.true)
        result = self._fresh()
        self._add(-result, *sorted(wanted))
        for literal in sorted(wanted):
            self._add(result, -literal)
        return result

    def _at_most_one(self, literals: Sequence[int]) -> None:
        """Sequential counter (Sinz, CP 2005)."""
        if len(literals) < 2:
            return
        before = self._fresh()
        self._add(-literals[0], before)
        for literal in literals[1:-1]:
            now = self._fresh()
            self._add(-literal, -before)
            self._add(-literal, now)
            self._add(-before, now)
            before = now
        self._add(-literals[-1], -before)

    def _fresh(self) -> int:
        self._variables += 1
        return self._variables

    def _add(self, *clause: int) -> None:
        self._clauses += 1
        if self._clauses > MOST_CLAUSES:
            raise TooLargeError
        self._solver.add_clause(list(clause))
