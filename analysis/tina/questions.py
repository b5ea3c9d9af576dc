"""Questions about a net that TINA's programs answer: is a marking reachable, does an LTL formula hold.

Nothing is believed that can be checked: a path or a counterexample is replayed on our net, and what the
programs make of runs that end is tried first (`dineros.analysis.tina.trial`). An answer without a path rests
on TINA, on that trial, and on how its manual is read here.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.explicit import Order
from dineros.analysis.logic.language.atoms import BoundAtoms, Step, all_resolved
from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Enabled, Formula, Name
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import ending_with_one_of
from dineros.analysis.tina.digest import read_counts
from dineros.analysis.tina.formulas import PARTIAL, always, fair_text, formula_text, not_
from dineros.analysis.tina.paths import lasso, read_sequence, to_goal
from dineros.analysis.tina.programs import TinaBudgetError, Workplace, workplace
from dineros.analysis.tina.trial import ask, try_reachability, try_temporal

#: How sift prints at which state it stopped: the manual numbers states, and does not define the format.
_STATE = re.compile(r"\bstate\s+(\d+)\b")


def find_enabled(
    net: CompiledNet,
    name: str,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
) -> Outcome:
    """Find a trace that ends with a transition of a name; asked and answered as `find_marking`."""
    wanted = names.transitions(name)
    answer = find_marking(net, Enabled(Name(name)), names, budget, order)
    if answer.trace is None:
        return answer
    return replace(answer, trace=ending_with_one_of(net, answer.trace, wanted))


def find_marking(
    net: CompiledNet,
    condition: str | Formula,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
) -> Outcome:
    """Find a trace to a marking that fulfils a condition.

    ``sift`` explores until it meets one, and writes the graph that it has seen; ``selt`` reports whether it
    contains one and whether the graph is complete; ``pathto``, or else a counterexample of ``selt``, leads
    there.

    Parameters
    ----------
    budget : Budget, optional
        Time that all programs together may take, as there is no end to an unbounded net, and the memory of
        each.
    order : {"breadth-first", "depth-first"}
        How ``sift`` goes.

    Raises
    ------
    FormulaError
        It is not a condition on markings, or names something unknown.
    TinaError
        A program is not there, failed, or answered what cannot be read or is not so.
    """
    tree = parse(condition, "state") if isinstance(condition, str) else condition
    atoms = BoundAtoms(net, tree, names)
    goal = formula_text(net, tree, atoms)

    def is_goal(marking: list[int]) -> bool:
        return holds_on_lasso(tree, [], [Step(tuple(marking), None)], atoms.is_true)

    with workplace(net, budget) as place:
        try:
            try_reachability(place)
            way = "-bf" if order == "breadth-first" else "-df"
            printed = place.run("sift", "-R", way, "net.net", "found.ktz", "-f", not_(goal)).stdout
            if ask(place, "found.ktz", always(not_(goal))):
                if ask(place, "found.ktz", always(not_(PARTIAL))):
                    return Outcome("unreachable")
                return Outcome("unknown", reason="sift stopped before it had explored all markings")
            trace, program = _path(net, place, printed, goal)
        except TinaBudgetError as limit:
            return Outcome("unknown", reason=limit.why)
    return Outcome("reachable", to_goal(net, trace, is_goal, program))


def verify(
    net: CompiledNet,
    formula: str | Formula,
    names: Names,
    weak: Iterable[str] = (),
    strong: Iterable[str] = (),
    budget: Budget = UNLIMITED,
) -> Outcome:
    """Decide whether all fair runs of a net satisfy an LTL formula, by ``tina`` and ``selt``.

    Parameters
    ----------
    weak, strong : iterable of str
        Names of fair transitions, each transition of a name on its own.
    budget : Budget, optional
        Time that all programs together may take, and the memory of each.

    Raises
    ------
    FormulaError
        The text is not an LTL formula, or names something unknown.
    TinaError
        A program is not there, failed, or answered what cannot be read or is not so.
    """
    budget = budget.begun()
    tree = parse(formula) if isinstance(formula, str) else formula
    atoms = BoundAtoms(net, tree, names)
    weakly, strongly = all_resolved(names, weak), all_resolved(names, strong)
    text = fair_text(net, formula_text(net, tree, atoms), weakly, strongly)
    states = 0

    def verdict(status: str, stem: Sequence[int] = (), loop: Sequence[int] = (), reason: str = "") -> Outcome:
        return Outcome(status, tuple(stem), tuple(loop), states, budget.spent, reason)

    with workplace(net, budget) as place:
        try:
            try_temporal(place)
            counts = read_counts(net, place.run("tina", "-R", "net.net", "net.ktz"))
            states = counts.states
            if not counts.is_bounded:
                return verdict("unknown", reason="tina does not find the net bounded")
            if ask(place, "net.ktz", text):
                return verdict("holds")
            shown = _counterexample(place, "net.ktz", text)
        except TinaBudgetError as limit:
            return verdict("unknown", reason=limit.why)
    if shown is None:
        return verdict("violated", reason="selt shows no run")
    stem, loop = lasso(net, read_sequence(net, shown, "selt"), tree, atoms, weakly, strongly)
    return verdict("violated", stem, loop)


def _path(net: CompiledNet, place: Workplace, printed: str, goal: str) -> tuple[list[int], str]:
    """Return a firing sequence to the state at which sift stopped, and which program wrote it."""
    states = set(_STATE.findall(printed))
    if len(states) == 1:
        program, text = "pathto", place.run("pathto", states.pop(), "-t", "found.ktz").stdout
    else:
        program, text = "selt", _counterexample(place, "found.ktz", always(not_(goal))) or ""
    return [t for row in read_sequence(net, text, program) for t in row], program


def _counterexample(place: Workplace, graph: str, text: str) -> str | None:
    """Let selt write a counterexample; None if it writes none."""
    place.run("selt", graph, "-f", text, "-q", "-s", "-wp", "0", "-S", "example.scn")
    try:
        shown = (place.folder / "example.scn").read_text("utf-8", errors="replace")
    except FileNotFoundError:
        return None
    return shown if shown.strip() else None
