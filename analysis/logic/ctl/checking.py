"""CTL on nets: which engine decides a formula, with sets of states of which kind.

Runs are infinite; one that reaches a deadlock stays there for ever, so a deadlock is its own successor.

References
----------
E. M. Clarke, E. A. Emerson, A. P. Sistla, *Automatic verification of finite-state concurrent systems using
temporal logic specifications*, TOPLAS 8(2), 1986.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Literal

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.turns import HEAD_START, Member
from dineros.analysis.logic.ctl.fixpoints import basic, satisfying, show
from dineros.analysis.logic.ctl.state_sets import States, StateSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.symbolic.order_cache import OrderCache

Engine = Literal["auto", "explicit", "symbolic"]

LIMITS_SHARE, FIRST_WORK = 0.6, 3_000_000
"""Part of the time, and cache misses of saturation, about a second, for nets with limits before others."""

#: Markings up to which `check_ctl` stores them one by one.
FEW_STATES = 500_000


def check_ctl(
    net: CompiledNet,
    formula: str | Formula,
    names: Names | None = None,
    budget: Budget = UNLIMITED,
    engine: Engine = "auto",
    orders: OrderCache | None = None,
    seed: int = 1,
) -> Outcome:
    """Decide whether the initial marking of a net satisfies a CTL formula.

    Parameters
    ----------
    net : CompiledNet
        The net; if it is unbounded the answer is ``unknown`` when a limit is hit.
    formula : str or Formula
        The formula.
    names : Names, optional
        What names stand for; by default places and transitions of the net.
    budget : Budget, optional
        Limits; by default there are none.
    engine : {"auto", "explicit", "symbolic"}
        How sets of markings are stored: one by one, which gives shortest witnesses, or as decision diagrams.
        ``auto`` begins explicitly, and goes on with both by turns where there are many markings.
    orders : OrderCache, optional
        Where orders of levels are kept for the symbolic engine.
    seed : int
        Of its search for an order.

    Returns
    -------
    Outcome
        With a replayed path or lasso for the outermost operator where one shows the answer: a counterexample
        to ``AG``, a witness of ``EF``, and so on. Where a limit is hit while it is looked for, the answer
        stands without it, and the reason says so.

    Raises
    ------
    FormulaError
        If the formula is none or names something unknown.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 1, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> check_ctl(net, "AG EF idle >= 1")
    Outcome(status='violated', trace=(0,), loop=(), states=2, ...)
    """
    tree = parse(formula, "ctl") if isinstance(formula, str) else formula
    atoms = BoundAtoms(net, tree, names or NetNames(net))
    budget = budget.begun()
    if engine == "explicit":
        return _explicitly(net, tree, atoms, budget)

    def with_limits(share: Budget, most_work: int | None = None) -> Outcome | None:
        from dineros.analysis.logic.ctl.limits import decide_with_limits

        return decide_with_limits(net, tree, names or NetNames(net), share, most_work)

    if engine == "auto":
        with suppress(BudgetExceededError):
            # Where markings may have no end, storing them one by one comes to none as a rule.
            answer = with_limits(budget.share(LIMITS_SHARE), FIRST_WORK)
            if answer is not None:
                return answer
    if engine == "auto" and (budget.states is None or budget.states > FEW_STATES):
        answer = _explicitly(net, tree, atoms, budget.share(most_states=FEW_STATES))
        if answer.status != "unknown":
            return answer
    elif engine == "auto":
        return _explicitly(net, tree, atoms, budget)
    if engine == "symbolic":
        found = _symbolically(net, tree, atoms, budget, orders, seed)
        return found or _unknown(budget, 0, "the places have no known bounds")
    has_bounds = True

    def by_diagrams(share: Budget) -> Outcome | None:
        nonlocal has_bounds
        found = _symbolically(net, tree, atoms, share, orders, seed)
        has_bounds = found is not None
        return found if has_bounds else _unknown(share, 0, "the places have no known bounds")

    found = first_of_two(
        [
            Member(by_diagrams, head_start=HEAD_START),
            Member(with_limits),
            Member(lambda share: _explicitly(net, tree, atoms, share)),
        ],
        budget,
        lambda answer: answer.status != "unknown" or not has_bounds,
    )
    if not has_bounds:
        from dineros.analysis.logic.ctl.endless import decide_endless

        endless = decide_endless(net, tree, atoms, names or NetNames(net), budget, check_ctl)
        return endless or _explicitly(net, tree, atoms, budget)
    return found or _unknown(budget, 0, "no engine has answered")


def _unknown(budget: Budget, states: int, reason: object) -> Outcome:
    return Outcome("unknown", states=states, seconds=budget.spent, reason=str(reason))


def _explicitly(net: CompiledNet, tree: Formula, atoms: BoundAtoms, budget: Budget) -> Outcome:
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


def _symbolically(
    net: CompiledNet,
    tree: Formula,
    atoms: BoundAtoms,
    budget: Budget,
    orders: OrderCache | None,
    seed: int,
) -> Outcome | None:
    """Decide with decision diagrams; None where bounds of places are not known, or too large for levels."""
    from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
    from dineros.analysis.symbolic.engine import symbolic_state_space
    from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    try:
        budget.check_time()
        space = symbolic_state_space(net, budget, seed, orders=orders)
    except (UnknownBoundError, LevelSizeError):
        return None
    except BudgetExceededError as limit:
        return _unknown(budget, 0, limit)
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
    """Return whether the initial one of so many states satisfies a formula, and a run that shows it."""
    from dineros.analysis.symbolic.saturation import DiagramMemoryError

    wanted = basic(tree)
    found = satisfying(wanted, sets)
    holds = sets.initially(found[wanted])
    try:
        (stem, loop), reason = show(sets, wanted, holds, found)
    except (BudgetExceededError, DiagramMemoryError) as limit:
        # The answer stands; only how to show it was not found.
        stem, loop, reason = (), (), f"a run showing it was not found: {limit}"
    return Outcome("holds" if holds else "violated", stem, loop, states, budget.spent, reason)
