"""LTL on nets: decides whether every run satisfies a formula, or finds a counterexample.

The negation is translated to an automaton, and its product with the net is searched on the fly for an
accepting run. Runs are infinite; a run that ends in a deadlock stays there forever, without firings.

References
----------
M. Y. Vardi, P. Wolper, *An automata-theoretic approach to automatic program verification*, LICS 1986.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.atoms import BoundAtoms, all_resolved
from dineros.analysis.logic.language.combining import combined, condition_of
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.logic.verdicts.verdict import check_counterexample
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.logic.graphs.product import Product
    from dineros.analysis.logic.ltl.earlier import EarlierSearches
    from dineros.analysis.logic.ltl.lassos import ProductRun

ENDLESS = Share(time=0.5)
"""Share of methods for unbounded nets, before the search of the product continues."""

FEWEST_NEARBY = 20_000
"""Minimum number of states examined for a shorter counterexample."""

MOST_NEARBY = 150_000
"""Maximum number of states examined for a shorter counterexample."""


def verify_ltl(
    net: CompiledNet,
    formula: str | Formula,
    names: Names | None = None,
    weak: Iterable[str] = (),
    strong: Iterable[str] = (),
    budget: Budget = UNLIMITED,
    earlier: EarlierSearches | None = None,
) -> Outcome:
    """Decide whether all fair runs of a net satisfy an LTL formula.

    Parameters
    ----------
    net : CompiledNet
        The net. It may be unbounded; then the result may be ``unknown``.
    names : Names, optional
        The elements that names refer to; by default places and transitions of the net.
    weak, strong : iterable of str
        Names of fair transitions; each transition of a name is fair separately. A run is weakly fair to a
        transition that is not enabled forever from some point on without being fired again, and strongly fair
        to one that is not enabled infinitely often without being fired infinitely often.
    earlier : EarlierSearches, optional
        Searches with fewer assumptions; this one is added.

    Returns
    -------
    Outcome
        ``violated`` has a run that was replayed by the firing rule, and on which the formula was evaluated to
        false (and the run found fair) by definition.

    Raises
    ------
    FormulaError
        It is not a formula, has an unknown name, or is too large.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 1, "busy": 0}, [("start", {"idle": 1}, {"busy": 1}), ("wait",)])
    >>> verdict = verify_ltl(net, "F (busy >= 1)")
    >>> verdict.status, [net.transitions[t] for t in verdict.loop]
    ('violated', ['wait'])
    >>> verify_ltl(net, "F (busy >= 1)", weak=["start"]).status
    'holds'
    """
    from dineros.analysis.logic.graphs.product import Product
    from dineros.analysis.logic.ltl.emptiness import Emptiness
    from dineros.analysis.logic.ltl.growing_runs import EndlessError, EndlessRuns, endless_text, watching
    from dineros.analysis.logic.ltl.shorter_lassos import shortened

    names = names or NetNames(net)
    budget = budget.begun()
    tree = parse(formula) if isinstance(formula, str) else formula
    atoms = BoundAtoms(net, tree, names)
    weak, strong = tuple(weak), tuple(strong)
    weakly, strongly = all_resolved(names, weak), all_resolved(names, strong)
    # A strongly fair run is weakly fair.
    weakly = [t for t in weakly if t not in strongly]
    budget.stage("the automaton of the formula")
    automaton = translate(negated(combined(tree)))
    conditions = [condition_of(atom, atoms.conditions) for atom in automaton.atoms]
    states = 0

    def search(limits: Budget, earlier: EarlierSearches | None = None) -> tuple[Product, ProductRun | None]:
        nonlocal states
        budget.stage("the product with the automaton")
        known = earlier and earlier.stored(net, tree, weakly, strongly)
        stored, rejected = known or (None, np.empty(0, dtype=np.intp))
        product = Product(net, automaton, conditions, weakly, strongly, limits, stored=stored)
        states = 1
        try:
            emptiness = Emptiness(product, limits, rejected)
            run = emptiness.run()
            if earlier is not None:
                earlier.record(tree, product, emptiness.rejected)
            return product, run
        finally:
            states = product.states

    try:
        try:
            product, run = search(watching(budget, net), earlier)
        except EndlessError as endless:
            budget.stage("runs whose tokens grow")
            runs = EndlessRuns(net, tree, atoms, names, weak, strong, verify_ltl)
            answer = runs.decide(ENDLESS.share(budget))
            if answer is not None:
                return replace(answer, seconds=budget.spent)
            if budget.seconds is None and budget.memory_bytes is None and budget.states is None:
                reason = f"states: {endless_text(net, endless.pumping)}"
                return Outcome("unknown", states=states, seconds=budget.spent, reason=reason)
            product, run = search(budget)
    except BudgetExceededError as limit:
        return Outcome("unknown", states=states, seconds=budget.spent, reason=str(limit))
    if run is None:
        return Outcome("holds", states=states, seconds=budget.spent)
    budget.stage("a shorter run")
    nearby = min(max(FEWEST_NEARBY, states), MOST_NEARBY, budget.states or MOST_NEARBY)
    run = shortened(run, Product(net, automaton, conditions, weakly, strongly, budget, product.cells), nearby)
    check_counterexample(net, tree, atoms, run.stem, run.loop, weakly, strongly)
    return Outcome("violated", run.stem, run.loop, states, budget.spent)
