"""Questions of the contest about any net: deadlock, safety, liveness, stable marking.

A marking is *stable* if some place always has its initial number of tokens. A net is quasi-live if every
transition can fire once, live if every transition can fire again from every reachable marking.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Evidence, Excluded
from dineros.analysis.logic.graphs.predicates import Flags, MarkingMatrix, enabled
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.coverability import coverability
from dineros.analysis.nets.graph_parts import numbered_parts
from dineros.analysis.nets.repetition import repeatable_transitions
from dineros.analysis.portfolio.budgets import GIVEN_UP, told
from dineros.analysis.portfolio.walker import Walker
from dineros.analysis.proofs.state_equation import StateEquation
from dineros.analysis.properties.behaviour import TooMuchWorkError, behaviour
from dineros.analysis.properties.part_of_graph import PartOfGraph
from dineros.analysis.symbolic.engine import SymbolicStateSpace

Decide = Callable[[str, bool, str], None]


class GlobalQuestions:
    """The known answers about a net as a whole.

    Parameters
    ----------
    decide : callable
        Called with the name of a question, its answer and the technique, when it is known; perhaps
        repeatedly.
    """

    def __init__(self, net: CompiledNet, decide: Decide) -> None:
        self.net, self._decide = net, decide
        self.fired = np.zeros(len(net.transitions), dtype=np.bool_)
        self.dead = np.zeros(len(net.transitions), dtype=np.bool_)
        self.stable = np.ones(len(net.places), dtype=np.bool_)
        self.bounded = False
        self.decided: dict[str, bool] = {}
        self.proof: tuple[str, Evidence] | None = None  #: a transition that never fires, with the evidence
        if int(net.initial.max(initial=0)) > 1:
            self.tell("OneSafe", False, "initial marking")
        if not net.changing or any(not row for row in net.changing):
            self.tell("StableMarking", True, "structure")

    def tell(self, name: str, value: bool, technique: str) -> None:
        """Record an answer, and those that follow from it."""
        if self.decided.setdefault(name, value) != value:
            raise AssertionError(f"{name} is both true and false")
        self._decide(name, value, technique)
        is_stuck = (name, value) in (("ReachabilityDeadlock", True), ("QuasiLiveness", False))
        if is_stuck and self.net.transitions and self.is_open("Liveness"):
            self.tell("Liveness", False, technique)
        if (name, value) == ("Liveness", True):
            for other, also in (("QuasiLiveness", True), ("ReachabilityDeadlock", False)):
                if self.is_open(other):
                    self.tell(other, also, technique)

    def is_open(self, *names: str) -> bool:
        """Whether one of some questions is unanswered."""
        return any(name not in self.decided for name in names)

    def look(self, rows: MarkingMatrix, walker: Walker) -> None:
        """Evaluate markings of random walks."""
        most = rows.rows.max(axis=0)
        self.stable &= (most == self.net.initial) & (rows.rows.min(axis=0) == self.net.initial)
        self.fired |= walker.fired
        self._conclude(int(most.max(initial=0)), walker.deadlocked, "random walk")

    def _conclude(self, most: int, has_deadlock: bool, technique: str) -> None:
        if most > 1:
            self.tell("OneSafe", False, technique)
        if has_deadlock:
            self.tell("ReachabilityDeadlock", True, technique)
        if self.fired.all():
            self.tell("QuasiLiveness", True, technique)
        if not self.stable.any():
            self.tell("StableMarking", False, technique)

    def by_bounds(self, bounds: list[int | None]) -> None:
        """Evaluate the bounds of places."""
        net = self.net
        self.bounded = all(bound is not None for bound in bounds)
        if all(bound is not None and bound <= 1 for bound in bounds):
            self.tell("OneSafe", True, "structure")
        for t in range(len(net.transitions)):
            if any((bound := bounds[p]) is not None and bound < weight for p, weight in net.pre.row(t)):
                self._dead(t, "structure")
        if (
            self.bounded
            and self.is_open("Liveness")
            and len(repeatable_transitions(net)) < len(net.transitions)
        ):
            self.tell("Liveness", False, "structure")

    def _dead(self, transition: int, technique: str) -> None:
        self.dead[transition] = True
        self.tell("QuasiLiveness", False, technique)

    def by_state_equation(self, equation: StateEquation, budget: Budget) -> None:
        """Apply the state equation to transitions not seen enabled and places not seen changing."""
        net = self.net
        if self.is_open("QuasiLiveness"):
            for t in np.flatnonzero(~self.fired & ~self.dead).tolist():
                if budget.is_over:
                    return
                case = equation.excludes([({p: 1}, weight) for p, weight in net.pre.row(t)])
                if case is not None:
                    self.proof = net.transitions[t], Excluded((case,))
                    self._dead(t, "state equation")
                    break
        if self.is_open("StableMarking"):
            for p in np.flatnonzero(self.stable).tolist():
                if budget.is_over:
                    return
                tokens = int(net.initial[p])
                if equation.largest({p: 1}) == tokens and equation.largest({p: -1}) == -tokens:
                    self.tell("StableMarking", True, "state equation")
                    break
        if self.is_open("OneSafe"):
            for p in range(len(net.places)):
                if budget.is_over or (most := equation.largest({p: 1})) is None or most > 1:
                    return
            self.tell("OneSafe", True, "state equation")

    def by_coverability(self) -> None:
        """Evaluate the coverability tree, if it is small."""
        if self.bounded or not self.is_open("OneSafe", "QuasiLiveness"):
            return
        known = coverability(self.net, 2_000)
        if known.is_bounded is False:
            self.tell("OneSafe", False, "coverability")
        if known.bounds is not None and max(known.bounds, default=0) <= 1:
            self.tell("OneSafe", True, "coverability")
        if known.maximal is not None:
            for t in range(len(self.net.transitions)):
                row = self.net.pre.row(t)
                if not any(all(m[p] >= weight for p, weight in row) for m in known.maximal):
                    self._dead(t, "coverability")
                    break

    def by_graph(self, graph: PartOfGraph) -> None:
        """Evaluate stored markings."""
        most = 0
        for p, tokens in enumerate(self.net.initial.tolist()):
            column = graph.tokens(p)
            most = max(most, int(column.max()))
            self.stable[p] &= bool((column == tokens).all())
        able: dict[int, Flags] = {}
        for t in range(len(self.net.transitions)):
            if graph.is_complete or not self.fired[t]:
                able[t] = enabled(graph, t)
                self.fired[t] |= bool(able[t].any())
        dead = bool(graph.deadlocks().any())
        self._conclude(most, dead, "explicit")
        if graph.is_complete:
            self._all_seen(most, dead, bool(self.fired.all()), bool(self.stable.any()), "explicit")
            if self.is_open("Liveness"):
                self.tell("Liveness", _is_live(graph, able), "explicit")

    def _all_seen(self, most: int, dead: bool, quasi: bool, stable: bool, technique: str) -> None:
        self.tell("OneSafe", most <= 1, technique)
        self.tell("ReachabilityDeadlock", dead, technique)
        self.tell("QuasiLiveness", quasi, technique)
        self.tell("StableMarking", stable, technique)

    def by_diagram(self, space: SymbolicStateSpace, budget: Budget) -> None:
        """Evaluate a decision diagram of all markings."""
        try:
            if self.is_open("OneSafe"):
                self.tell("OneSafe", max(space.largest_place(), default=0) <= 1, "symbolic")
            if self.is_open("ReachabilityDeadlock") and (count := space.deadlocks()) is not None:
                self.tell("ReachabilityDeadlock", count > 0, "symbolic")
            if self.is_open("QuasiLiveness"):
                names = self.net.transitions
                others = np.flatnonzero(~self.fired).tolist()
                self.tell("QuasiLiveness", all(space.enabled(names[t]) > 0 for t in others), "symbolic")
            if self.is_open("StableMarking"):
                stable = (p for p in np.flatnonzero(self.stable).tolist() if space.is_stable(p))
                self.tell("StableMarking", next(stable, None) is not None, "symbolic")
            if self.is_open("Liveness"):
                self.tell("Liveness", not behaviour(space, told(budget)).not_live, "symbolic")
        except (*GIVEN_UP, TooMuchWorkError):
            return


def _is_live(graph: PartOfGraph, able: dict[int, Flags]) -> bool:
    """Whether each transition is enabled somewhere in each terminal component of the graph."""
    sources, targets = graph.arcs.tails(), graph.arcs.targets
    count, component = numbered_parts(graph.size, sources, targets)
    is_last = np.ones(count, dtype=np.bool_)
    is_last[component[sources][component[sources] != component[targets]]] = False
    for flags in able.values():
        has = np.zeros(count, dtype=np.bool_)
        has[component[flags]] = True
        if not has[is_last].all():
            return False
    return True
