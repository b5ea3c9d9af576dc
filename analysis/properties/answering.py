"""Answering many properties of one net: what prepares the net is done once, and cheap ways come first.

1. the initial marking and what formulas say of themselves;
2. the first markings, all where they are few: every question at once, with three truth values;
3. random walks for goals, bounds and the net's own questions;
4. bounds of places and the state equation, which exclude goals and bound sums from above;
5. a larger part of the graph, induction and clauses for goals, decision diagrams of all markings;
6. what is left alone: linear time on the fly, deadlocks by stubborn sets, a net reduced for the question.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.evidence import Row
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.ctl.fixpoints import basic, initially, satisfying
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import TRUE, And, Atom, Constant, Exists, ForAll, Formula, Not
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.proofs.exclusion import excluded
from dineros.analysis.proofs.state_equation import StateEquation
from dineros.analysis.properties import engines
from dineros.analysis.properties.engines import GIVEN_UP, Clock
from dineros.analysis.properties.global_properties import GlobalQuestions
from dineros.analysis.properties.normal_form import everywhere, goal_of, is_linear, linear_equal
from dineros.analysis.properties.part_of_graph import PartialSets, PartOfGraph
from dineros.analysis.properties.predicates import Int64Array, is_condition, total
from dineros.analysis.properties.property import Property, PropertyAnswer
from dineros.analysis.properties.reduced import reduced
from dineros.analysis.properties.sheet import Sheet
from dineros.analysis.properties.solving import ask_solvers, search_reduced
from dineros.analysis.properties.walking import TRIES, Walker, follow
from dineros.analysis.symbolic.engine import SymbolicStateSpace
from dineros.analysis.walks.firing_counts import firings

#: Markings of the first part of the graph.
FEW_STATES = 20_000
#: Markings looked at from the end of a random walk on.
PROBE_STATES = 2_000
#: Seconds for a question unless told otherwise.
SECONDS = 30.0


def answer_properties(
    net: CompiledNet,
    names: Names,
    properties: Sequence[Property],
    seconds: float = SECONDS,
    memory: int = 2 << 30,
    answered: Callable[[PropertyAnswer], None] = lambda answer: None,
    stage: Callable[[str], None] = lambda name: None,
) -> list[PropertyAnswer]:
    """Answer properties of a net.

    Parameters
    ----------
    net : CompiledNet
        The net.
    names : Names
        What names in the properties stand for.
    properties : sequence of Property
        All that is asked.
    seconds : float
        For each question; what one does not need, others may use.
    memory : int
        Bytes that searches may take.
    answered : callable
        Told each answer as soon as there is one.
    stage : callable
        Told the name of each stage of the work.

    Returns
    -------
    list of PropertyAnswer
        In the order of the properties.
    """
    work = _Work(Sheet(net, names, properties, answered), seconds, memory, stage)
    work.run()
    sheet = work.sheet
    unknown = "time or memory did not suffice"
    return [
        sheet.answers.get(one.id) or PropertyAnswer(one.id, None, sheet.seconds, reason=unknown)
        for one in properties
    ]


class _Work:
    def __init__(self, sheet: Sheet, seconds: float, memory: int, stage: Callable[[str], None]) -> None:
        self.sheet, self.net, self.seconds, self.memory = sheet, sheet.net, seconds, memory
        self._stage = stage
        self.clock = Clock(seconds * len(sheet.properties))
        ids: dict[str, list[str]] = {}
        for one in sheet.properties:
            ids.setdefault(one.examination, []).append(one.id)

        def decide(name: str, value: bool, technique: str) -> None:
            for id in ids.get(name, ()):
                is_dead = (name, value) == ("QuasiLiveness", False)
                sheet.answer(id, value, technique, *(self.whole.proof or ()) if is_dead else ())

        self.whole = GlobalQuestions(self.net, decide)
        self.equation = StateEquation(self.net)
        self.walker = Walker(self.net)
        self.graph: PartOfGraph | None = None
        self.cells: Layout | None = None  #: found once, which takes its time
        self.space: SymbolicStateSpace | None = None
        self.tried = False  #: whether each part has had its time on the diagram

    def run(self) -> None:
        """Go through the stages until everything is answered."""
        for stage, share, name in (
            (self._few, 0.02, "the first markings"),
            (self._walk, 0.03, "random walks"),
            (self._bound, 0.05, "bounds of places"),
            (self._exclude, 0.08, "the state equation"),
            (self._many, 0.08, "many markings"),
            (self._probe, 0.05, "markings far away"),
            (partial(ask_solvers, self.sheet, self.whole), 0.08, "induction and clauses"),
            (self._draw, 0.25, "decision diagrams"),
            (self._alone, 1.0, "each question alone"),
            (self._again, 1.0, "what is left"),
        ):
            if self.sheet.is_done or self.clock.is_over():
                return
            if not self.has_all or stage in (self._many, self._alone, self._again):
                self._stage(name)
                stage(Clock(min(self.clock.left, share * self.seconds * len(self.sheet.properties))))

    @property
    def has_all(self) -> bool:
        """Whether all markings are stored: then nothing else is worth its time, but for linear time."""
        return self.graph is not None and self.graph.is_complete

    # stages

    def _few(self, clock: Clock) -> None:
        self._store(FEW_STATES, self.memory // 4, clock)

    def _walk(self, clock: Clock) -> None:
        walker = self.walker
        while not clock.is_over() and not self.sheet.is_done:
            rows = walker.walk()
            self.sheet.look(rows, "random walk")
            self.whole.look(rows, walker)
            if not (self.sheet.open_goals() or self.sheet.open_limits() or self.sheet.open_globals()):
                return

    def _bound(self, clock: Clock) -> None:
        proved = place_bounds(self.net)
        bounds = [None if bound is None else bound.value for bound in proved]
        self.whole.by_bounds(bounds)
        self.sheet.always.update(self.sheet.constants(proved))
        for limits in self.sheet.open_limits().values():
            parts = [bounds[place] for place in limits.factors]
            if None not in parts:
                factors = limits.factors.values()
                limits.most = sum(k * part for k, part in zip(factors, parts, strict=True) if part)
        self.sheet.settle("structure")
        if self.sheet.open_globals():
            self.whole.by_coverability()

    def _exclude(self, clock: Clock) -> None:
        sheet = self.sheet
        for limits in sheet.open_limits().values():
            if clock.is_over():
                return
            most = self.equation.largest(limits.factors)
            if most is not None and (limits.most is None or most < limits.most):
                limits.most = most
        sheet.settle("state equation")
        for limits in sheet.open_limits().values():
            gains = np.zeros(len(self.net.transitions), dtype=np.int64)
            for t, change in enumerate(self.net.delta):
                gains[t] = sum(limits.factors.get(p, 0) * tokens for p, tokens in change.items())
            if limits.most is not None and not clock.is_over():
                self._follow([(limits.factors, limits.most)], clock)
            elif not clock.is_over():
                self._follow([], clock, gains)
        if sheet.open_globals():
            self.whole.by_state_equation(self.equation, clock)
        goals = sheet.open_goals()
        for number, (part, condition, value) in enumerate(goals):
            own = Clock(clock.left / (len(goals) - number) * 2)
            if clock.is_over():
                break
            goal = simplified(condition)

            def reached(rows: Sequence[Row], part: Formula = part, own: Clock = own) -> bool:
                self._follow(rows, own)
                return part in sheet.known

            if found := excluded(self.equation, goal, sheet.conditions, own.is_over, reached):
                sheet.known[part], sheet.evidence[part] = not value, found
        sheet.settle("state equation")
        self._exclude_atoms(clock)

    def _follow(self, rows: Sequence[Row], clock: Clock, gains: Int64Array | None = None) -> None:
        """Walk as a solution of the state equation says, and see what that decides."""
        counts = firings(self.net, rows, gains)
        for seed in range(TRIES if counts is not None else 0):
            if clock.is_over():
                return
            assert counts is not None
            self.sheet.look(follow(self.walker.arrays, counts, seed), "directed walk")

    def _exclude_atoms(self, clock: Clock) -> None:
        """Find atoms that are constant: they make formulas smaller whatever these say."""
        sheet = self.sheet
        found = [
            part
            for formula in sheet.open_formulas().values()
            for part in formula.subformulas()
            if part not in sheet.always and is_condition(part) and not isinstance(part, Constant)
        ]
        # Larger conditions first: what they decide needs no atoms.
        for part in sorted(dict.fromkeys(found), key=lambda part: isinstance(part, Atom)):
            if clock.is_over():
                break
            for value, condition in ((False, simplified(part)), (True, simplified(Not(part)))):
                proof = excluded(self.equation, condition, sheet.conditions, clock.is_over, most_traps=0)
                if proof is not None:
                    sheet.always[part], sheet.evidence[part] = value, proof
                    break
        sheet.settle("state equation")

    def _many(self, clock: Clock) -> None:
        if self.graph is not None and self.has_all:
            self._look_at(self.graph, clock)
        else:
            self._store(None, self.memory // 2, clock)

    def _store(self, states: int | None, memory: int, clock: Clock) -> None:
        self.graph = None
        self.graph = engines.part_of_graph(self.net, states, memory, clock.left / 2, cells=self.cells)
        if self.graph is not None:
            self.cells = self.graph.layout
            # What is stored is worth some time, also where storing took all of it.
            self._look_at(self.graph, Clock(max(clock.left, self.seconds / 2)))

    def _look_at(self, graph: PartOfGraph, clock: Clock) -> None:
        """Decide what a part of the graph decides, as far as time goes."""
        sheet = self.sheet
        for limits in sheet.open_limits().values():
            limits.least = max(limits.least, int(total(graph, limits.factors).max()))
            if graph.is_complete:
                limits.most = limits.least
        sheet.settle("explicit")
        if sheet.open_globals():
            self.whole.by_graph(graph)
        sets = PartialSets(graph, sheet.conditions, clock.tell)
        parts = [part for part in sheet.open_parts() if not is_linear(part)]
        with contextlib.suppress(BudgetExceededError):
            # Goals first: they need the least.
            for part in sorted(parts, key=lambda part: goal_of(part) is None):
                wanted = basic(part)
                value = sets.value(satisfying(wanted, sets)[wanted])
                if value is not None:
                    sheet.known[part] = value
                    sheet.settle("explicit")

    def _probe(self, clock: Clock) -> None:
        """Look for markings far away that refute ``AG f`` or show ``EF f``, where f is no mere condition."""
        sheet = self.sheet
        self.graph = None
        for number, start in enumerate(self.walker.ends):
            parts = [(part, inner) for part in sheet.open_parts() if (inner := everywhere(part)) is not None]
            if not parts or clock.is_over():
                return
            own = Clock(clock.left / (len(self.walker.ends) - number))
            graph = engines.part_of_graph(
                self.net, PROBE_STATES, self.memory // 8, own.left / 2, start, self.cells
            )
            if graph is None:
                return
            sets = PartialSets(graph, sheet.conditions, own.tell)
            with contextlib.suppress(BudgetExceededError):
                for part, inner in parts:
                    wanted = basic(inner)
                    sure, possible = satisfying(wanted, sets)[wanted]
                    if isinstance(part, Exists) and sure.any():
                        sheet.known[part] = True
                    elif isinstance(part, ForAll) and not possible.all():
                        sheet.known[part] = False
            sheet.settle("explicit, from a random walk")

    def _draw(self, clock: Clock) -> None:
        sheet = self.sheet
        if not any(not is_linear(part) for part in sheet.open_parts()) and not (
            sheet.open_limits() or sheet.open_globals()
        ):
            return
        self.graph = None
        self.space = space = engines.diagram(self.net, self.memory // 2, clock)
        if space is None:
            return
        for limits in sheet.open_limits().values():
            weights, constant = space.weights_of(limits.factors)
            limits.most = limits.least = constant + space.counts.largest(weights)
        sheet.settle("symbolic")
        if sheet.open_globals():
            self.whole.by_diagram(space, Clock(min(2 * self.seconds, self.clock.left)))
        self._branch(space)

    def _branch(self, space: SymbolicStateSpace) -> None:
        """Decide parts of branching time on a diagram, as far as each has time."""
        sheet = self.sheet
        parts = [part for part in sheet.open_parts() if not is_linear(part)]
        atoms = BoundAtoms(self.net, And((TRUE, *parts)), sheet.names)
        pinned, sets, clock = len(space.diagram.pinned), None, Clock(0)
        for number, part in enumerate(parts):
            # The first time round, none takes more than its own.
            share = self.clock.left / (len(parts) - number)
            clock.restart(share if self.tried else min(self.seconds, share))
            try:
                # What one part has made, others use; where it takes too much memory, it is made anew.
                if sets is None:
                    sets = SymbolicSets(space, atoms, Budget(progress=clock.tell))
                sheet.known[part] = initially(basic(part), sets)
            except BudgetExceededError:
                continue
            except GIVEN_UP:
                del space.diagram.pinned[pinned:]
                sets = None
                continue
            sheet.settle("symbolic")
        self.tried = True

    def _always(self, path: Formula, clock: Clock) -> bool | None:
        """Decide linear time on the net reduced for it where that can be, else on the net itself."""
        smaller = reduced(self.net, path, self.sheet.names)
        if smaller is not None:
            names = NetNames(smaller.net)
            holds = engines.always(smaller.net, smaller.formula, names, self.memory // 2, clock.left)
            if holds is not None or clock.is_over():
                return holds
        return engines.always(self.net, path, self.sheet.names, self.memory // 2, clock.left, self.cells)

    def _again(self, clock: Clock) -> None:
        """Use the time that is left for what the engines have not got through."""
        if self.graph is not None and self.has_all:
            self._look_at(self.graph, clock)
        elif self.space is not None:
            self._branch(self.space)
        else:
            self._store(None, self.memory // 2, clock)

    def _alone(self, clock: Clock) -> None:
        sheet = self.sheet
        if self.whole.is_open("ReachabilityDeadlock") and sheet.open_globals():
            found = engines.can_deadlock(self.net, self.memory // 2, min(self.seconds, clock.left))
            if found is not None:
                self.whole.tell("ReachabilityDeadlock", found, "stubborn sets")
        search_reduced(sheet, Clock(clock.left / 2), self.seconds, self.memory // 2)
        linear = [(part, (part.operands[0], True)) for part in sheet.open_parts() if is_linear(part)]
        branching = [(part, linear_equal(part)) for part in sheet.open_parts() if not is_linear(part)]
        parts = [*linear, *((part, equal) for part, equal in branching if equal is not None)]
        for number, (part, (path, value)) in enumerate(parts):
            share = min(self.seconds, clock.left / (len(parts) - number))
            holds = self._always(path, Clock(share))
            if holds is not None:
                sheet.known[part] = value == holds
                sheet.settle("on the fly")
