"""CTL on nets, by the methods of the portfolio; `logic.ctl.checking` defines the meaning of a formula."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.turns import HEAD_START
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.methods.diagrams import DecisionDiagrams
from dineros.analysis.portfolio.methods.endless_net import EndlessNet
from dineros.analysis.portfolio.methods.limits import NetWithLimits
from dineros.analysis.portfolio.methods.markings import FarMarkings, StoredMarkings
from dineros.analysis.portfolio.plans import FIRST_WORK, KNOWN_DIAGRAM
from dineros.analysis.portfolio.satisfies import NO_BOUNDS, Question, Satisfies
from dineros.analysis.portfolio.scheduler import Plan, Side, SoFar, Together, Turn, answered

if TYPE_CHECKING:
    from dineros.analysis.symbolic.order_cache import OrderCache

Engine = Literal["auto", "explicit", "symbolic"]

FEW_STATES = 500_000
"""Number of markings stored one by one before diagrams are tried."""


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
    names : Names, optional
        The elements that names refer to; by default places and transitions of the net.
    engine : {"auto", "explicit", "symbolic"}
        Representation of sets of markings: one by one, which gives shortest witnesses, or as decision
        diagrams. ``auto`` begins explicitly, and continues with both in turns if there are many markings.

    Returns
    -------
    Outcome
        With a replayed path or lasso for the outermost operator if one shows the answer: a counterexample to
        ``AG``, a witness of ``EF``, and so on. If a limit is exceeded during the search for it, the answer is
        valid without it, and the reason reports this.

    Raises
    ------
    FormulaError
        It is not a formula, or has an unknown name.

    Examples
    --------
    >>> net = CompiledNet.build({"idle": 1, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})])
    >>> check_ctl(net, "AG EF idle >= 1")
    Outcome(status='violated', trace=(0,), loop=(), states=2, ...)
    """
    tree = parse(formula, "ctl") if isinstance(formula, str) else formula
    question = Satisfies(net, tree, names or NetNames(net), orders, seed)
    _ = question.bound  # raises if a name is unknown
    plan: Plan = PLANS[engine]
    if engine == "auto" and budget.states is not None and budget.states <= FEW_STATES:
        plan = (LIMITS_FIRST, STORED)
    return answered(question, plan, budget)


def _has_no_bounds(question: Question, so_far: SoFar) -> bool:
    return so_far.last is not None and so_far.last.reason == NO_BOUNDS


STORED = Turn(StoredMarkings())
# If the state space may be infinite, storing markings one by one usually fails.
LIMITS_FIRST = Turn(NetWithLimits(FIRST_WORK), time=0.6)

PLANS: dict[Engine, Plan] = {
    "explicit": (STORED,),
    "symbolic": (Turn(DecisionDiagrams()),),
    "auto": (
        KNOWN_DIAGRAM,
        LIMITS_FIRST,
        Turn(StoredMarkings(), most_states=FEW_STATES),
        Together(
            (
                Side((Turn(DecisionDiagrams()),), head_start=HEAD_START),
                Side((Turn(FarMarkings(), time=0.1, most_seconds=2.0), Turn(NetWithLimits()))),
                Side((STORED,)),
            )
        ),
        Turn(EndlessNet(check_ctl), _has_no_bounds),
        Turn(StoredMarkings(), _has_no_bounds),
    ),
}
"""For each engine, the plan to decide a formula."""
