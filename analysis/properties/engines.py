"""The engines as properties use them: a share of time and memory each, None where that was not enough."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.explicit import find
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.explicit.layout import Layout
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.combining import combined, condition_of
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.ltl.emptiness import Emptiness
from dineros.analysis.logic.verdicts.verdict import check_counterexample
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.part_of_graph import PartOfGraph
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

#: What an engine raises that has not got enough, or cannot take the net.
GIVEN_UP = (BudgetExceededError, DiagramMemoryError, UnknownBoundError, LevelSizeError, MemoryError)

#: What is derived of a net that does not hang on its initial marking.
KEPT = ("delta", "changing")


class Clock:
    """Time for one stage of the work.

    Parameters
    ----------
    seconds : float
        From now on.
    """

    def __init__(self, seconds: float) -> None:
        self.restart(seconds)

    def restart(self, seconds: float) -> None:
        """Give so many seconds from now on."""
        self.until = time.perf_counter() + max(0.0, seconds)

    @property
    def left(self) -> float:
        """Seconds left."""
        return max(0.0, self.until - time.perf_counter())

    def is_over(self) -> bool:
        """Whether time is up."""
        return self.left == 0.0

    def tell(self, _: Any = None) -> None:
        """Raise `BudgetExceededError` when time is up."""
        if self.is_over():
            raise BudgetExceededError("time")


def part_of_graph(
    net: CompiledNet,
    states: int | None,
    memory: int,
    seconds: float,
    start: Sequence[int] | None = None,
    cells: Layout | None = None,
) -> PartOfGraph | None:
    """Return the first markings of a net, all where they are few; from another marking if one is given."""
    if start is not None:
        derived: dict[str, Any] = {name: net.__dict__[name] for name in KEPT if name in net.__dict__}
        net = replace(net, initial=np.array(start, dtype=np.int64))
        net.__dict__.update(derived)
    try:
        return PartOfGraph(net, Budget(memory, states, seconds).begun(), cells)
    except GIVEN_UP:
        return None


def diagram(net: CompiledNet, memory: int, clock: Clock) -> SymbolicStateSpace | None:
    """Return all markings as a decision diagram."""
    try:
        space = symbolic_state_space(net, Budget(memory, progress=clock.tell))
    except GIVEN_UP:
        return None
    return space if space.complete else None


def always(
    net: CompiledNet,
    formula: Formula,
    names: Names,
    memory: int,
    seconds: float,
    cells: Layout | None = None,
) -> bool | None:
    """Decide whether all runs satisfy an LTL formula; a run that does not is checked, but not made short."""
    budget = Budget(memory, seconds=seconds).begun()
    atoms = BoundAtoms(net, formula, names)
    try:
        automaton = translate(negated(combined(formula)))
        conditions = [condition_of(atom, atoms.conditions) for atom in automaton.atoms]
        run = Emptiness(Product(net, automaton, conditions, (), (), budget, cells), budget).run()
    except (*GIVEN_UP, FormulaError):  # of which its automaton is too large
        return None
    if run is not None:
        check_counterexample(net, formula, atoms, run.stem, run.loop)
    return run is None


def can_deadlock(net: CompiledNet, memory: int, seconds: float) -> bool | None:
    """Decide whether a marking is reachable that enables nothing, by stubborn sets."""
    answer = find(net, Goal.deadlock(), Budget(memory, seconds=seconds), reduction="stubborn", workers=1)
    return {"reachable": True, "unreachable": False}.get(answer.status)
