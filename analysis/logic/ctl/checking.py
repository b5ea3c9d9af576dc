"""CTL on nets: a formula is decided with sets of states of one kind.

Runs are infinite; one that reaches a deadlock stays there forever, so a deadlock is its own successor.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from dineros.analysis.answers.budget import RAN_OUT, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.ctl.fixpoints import basic, satisfying, show
from dineros.analysis.logic.ctl.state_sets import States, StateSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.symbolic.engine import SymbolicStateSpace
    from dineros.analysis.symbolic.order_cache import OrderCache


def _unknown(budget: Budget, states: int, reason: object) -> Outcome:
    return Outcome("unknown", states=states, seconds=budget.spent, reason=str(reason))


def explicitly(net: CompiledNet, tree: Formula, atoms: BoundAtoms, budget: Budget) -> Outcome:
    """Decide with markings stored one by one, which gives shortest witnesses."""
    from dineros.analysis.logic.ctl.explicit_sets import ExplicitSets
    from dineros.analysis.logic.graphs.stored import StateGraph

    states = 0
    try:
        budget.stage("the graph of markings")
        graph = StateGraph(net, atoms.conditions, budget)
        try:
            graph.explore()
        finally:
            states = graph.size
        budget.stage("sets of markings")
        return replace(decided(tree, ExplicitSets(graph), states, budget), by="explicit search")
    except BudgetExceededError as limit:
        return _unknown(budget, states, limit)


def symbolically(
    net: CompiledNet,
    tree: Formula,
    atoms: BoundAtoms,
    budget: Budget,
    orders: OrderCache | None = None,
    seed: int = 1,
) -> Outcome | None:
    """Decide with decision diagrams; None: bounds of places are unknown, or too large for levels."""
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError

    try:
        budget.check_time()
        space = symbolic_state_space(net, budget, seed, orders=orders)
    except (UnknownBoundError, LevelSizeError):
        return None
    except BudgetExceededError as limit:
        return _unknown(budget, 0, limit)
    return on_diagram(space, tree, atoms, budget)


def on_diagram(space: SymbolicStateSpace, tree: Formula, atoms: BoundAtoms, budget: Budget) -> Outcome:
    """Decide with a decision diagram of all markings of the net."""
    from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    states = space.markings
    try:
        if not space.complete:
            raise DiagramMemoryError
        budget.check_time()
        budget.stage("sets of markings as decision diagrams")
        answer = decided(tree, SymbolicSets(space, atoms, budget), states, budget)
        return replace(answer, by="decision diagrams")
    except DiagramMemoryError:
        more = f"more than {budget.memory / 2**20:.0f} MiB needed"
        return _unknown(budget, states, f"{RAN_OUT['memory']}: {more}")
    except BudgetExceededError as limit:
        return _unknown(budget, states, limit)


def decided(tree: Formula, sets: StateSets[States], states: int, budget: Budget) -> Outcome:
    """Return whether the initial state satisfies a formula, with a run that shows it."""
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    wanted = basic(tree)
    found = satisfying(wanted, sets)
    holds = sets.initially(found[wanted])
    try:
        (stem, loop), reason = show(sets, wanted, holds, found)
    except (BudgetExceededError, DiagramMemoryError) as limit:
        # The answer is valid; only a run that shows it was not found.
        stem, loop, reason = (), (), f"no run that shows it was found: {limit}"
    return Outcome("holds" if holds else "violated", stem, loop, states, budget.spent, reason)
