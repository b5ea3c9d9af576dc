"""Answering many properties of one net: what prepares the net is done once, and cheap ways come first.

1. the initial marking and what formulas say of themselves;
2. the first markings, all where they are few: every question at once, with three truth values;
3. random walks for goals, bounds and the net's own questions;
4. bounds of places and the state equation, which exclude goals and bound sums from above;
5. a larger part of the graph, decision diagrams of all markings;
6. what is left alone: linear time on the fly, deadlocks by stubborn sets, a net reduced for the question.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Sequence

from dineros.analysis.logic.ctl.checking import basic, satisfying
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.syntax import Atom, Formula, Not
from dineros.analysis.logic.verdicts.budget import BudgetExceededError
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties import engines
from dineros.analysis.properties.engines import GIVEN_UP, Clock
from dineros.analysis.properties.exclusion import is_excluded
from dineros.analysis.properties.global_properties import GlobalQuestions
from dineros.analysis.properties.normal_form import goal_of, is_linear
from dineros.analysis.properties.part_of_graph import PartialSets, PartOfGraph
from dineros.analysis.properties.predicates import total
from dineros.analysis.properties.property import Property, PropertyAnswer
from dineros.analysis.properties.sheet import Sheet
from dineros.analysis.properties.state_equation import StateEquation
from dineros.analysis.properties.walking import Walker
from dineros.analysis.symbolic.engine import SymbolicStateSpace

#: Markings of the first part of the graph.
FEW_STATES = 20_000
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
                sheet.answer(id, value, technique)

        self.whole = GlobalQuestions(self.net, decide)
        self.equation = StateEquation(self.net)
        self.graph: PartOfGraph | None = None
        self.space: SymbolicStateSpace | None = None

    def run(self) -> None:
        """Go through the stages until everything is answered."""
        for stage, share in (
            (self._few, 0.02),
            (self._walk, 0.03),
            (self._bound, 0.05),
            (self._exclude, 0.08),
            (self._many, 0.08),
            (self._draw, 0.25),
            (self._alone, 1.0),
        ):
            if self.sheet.is_done or self.clock.is_over():
                return
            self._stage(stage.__name__.lstrip("_"))
            stage(Clock(min(self.clock.left, share * self.seconds * len(self.sheet.properties))))

    # stages

    def _few(self, clock: Clock) -> None:
        self._store(FEW_STATES, self.memory // 4, clock)

    def _walk(self, clock: Clock) -> None:
        walker = Walker(self.net)
        while not clock.is_over() and not self.sheet.is_done:
            rows = walker.walk()
            self.sheet.look(rows, "random walk")
            self.whole.look(rows, walker)
            if not (self.sheet.open_goals() or self.sheet.open_limits() or self.sheet.open_globals()):
                return

    def _bound(self, clock: Clock) -> None:
        bounds = [None if bound is None else bound.value for bound in place_bounds(self.net)]
        self.whole.by_bounds(bounds)
        self.sheet.always.update(self.sheet.constants(bounds))
        for limits in self.sheet.open_limits().values():
            parts = [bounds[place] for place in limits.factors]
            known = [
                factor * part
                for part, factor in zip(parts, limits.factors.values(), strict=True)
                if part is not None
            ]
            if len(known) == len(parts):
                limits.most = sum(known)
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
        if sheet.open_globals():
            self.whole.by_state_equation(self.equation, clock)
        goals = sheet.open_goals()
        for number, (part, condition, value) in enumerate(goals):
            own = Clock(clock.left / (len(goals) - number) * 2)
            if clock.is_over():
                break
            if is_excluded(self.equation, simplified(condition), sheet.conditions, own.is_over):
                sheet.known[part] = not value
        sheet.settle("state equation")
        self._exclude_atoms(clock)

    def _exclude_atoms(self, clock: Clock) -> None:
        """Find atoms that are constant: they make formulas smaller whatever these say."""
        sheet = self.sheet
        atoms = [
            atom
            for formula in sheet.open_formulas().values()
            for atom in formula.subformulas()
            if atom in sheet.conditions and atom not in sheet.always
        ]
        for atom in dict.fromkeys(atoms):
            if clock.is_over():
                break
            assert isinstance(atom, Atom)
            for value, condition in ((False, atom), (True, simplified(Not(atom)))):
                if is_excluded(self.equation, condition, sheet.conditions, clock.is_over):
                    sheet.always[atom] = value
                    break
        sheet.settle("state equation")

    def _many(self, clock: Clock) -> None:
        if self.graph is None or not self.graph.is_complete:
            self._store(None, self.memory // 2, clock)
        else:
            self._look_at(self.graph, Clock(self.clock.left))

    def _store(self, states: int | None, memory: int, clock: Clock) -> None:
        self.graph = None
        self.graph = graph = engines.part_of_graph(self.net, states, memory, clock.left / 2)
        # What is stored is worth some time, also where storing took all of it.
        self._look_at(graph, Clock(max(clock.left, self.seconds / 2)))

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

    def _draw(self, clock: Clock) -> None:
        if self.graph is not None and self.graph.is_complete:
            return
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
        parts = [part for part in sheet.open_parts() if not is_linear(part)]
        for number, part in enumerate(parts):
            own = Clock(min(self.seconds, self.clock.left / (len(parts) - number)))
            value = self._by_diagram(space, part, own)
            if value is not None:
                sheet.known[part] = value
                sheet.settle("symbolic")

    def _by_diagram(self, space: SymbolicStateSpace, part: Formula, clock: Clock) -> bool | None:
        pinned = len(space.diagram.pinned)
        try:
            atoms = BoundAtoms(self.net, part, self.sheet.names)
            sets = SymbolicSets(space, atoms, clock.tell)
            wanted = basic(part)
            return sets.initially(satisfying(wanted, sets)[wanted])
        except GIVEN_UP:
            return None
        finally:
            del space.diagram.pinned[pinned:]

    def _alone(self, clock: Clock) -> None:
        sheet = self.sheet
        if self.whole.is_open("ReachabilityDeadlock") and sheet.open_globals():
            found = engines.can_deadlock(self.net, self.memory // 2, min(self.seconds, clock.left))
            if found is not None:
                self.whole.tell("ReachabilityDeadlock", found, "stubborn sets")
        parts = [part for part in sheet.open_parts() if is_linear(part)]
        for number, part in enumerate(parts):
            share = min(self.seconds, clock.left / (len(parts) - number))
            value = engines.always(self.net, part.operands[0], sheet.names, self.memory // 2, share)
            if value is not None:
                sheet.known[part] = value
                sheet.settle("on the fly")
