"""Confirms answers that depend on all markings: by another engine, or by diagrams with another order.

The answer of one engine does not protect against its own bugs. Explicit search and decision diagrams have
only the net in common. If search would be too expensive, diagrams with two different variable orders have no
node in common.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass
from typing import TypeVar

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share, fairly
from dineros.analysis.logic.ctl.fixpoints import basic, satisfying
from dineros.analysis.logic.ctl.symbolic_sets import SymbolicSets
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import (
    And,
    Comparison,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Name,
    Not,
)
from dineros.analysis.logic.language.syntax import Enabled as AtomEnabled
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.budgets import GIVEN_UP
from dineros.analysis.portfolio.count import LevelOrder, StateSpace
from dineros.analysis.properties.normal_form import is_linear, of_linear
from dineros.analysis.properties.property import Property, PropertyAnswer, said_of_all
from dineros.analysis.questions.net_questions import Branching, Enabled, Linear, Marking, Question
from dineros.analysis.symbolic.engine import SymbolicStateSpace, symbolic_state_space
from dineros.analysis.symbolic.saturation import DiagramMemoryError

V = TypeVar("V")

ONE_ENGINE = "only one engine decides this kind of formula"
SEARCH, DIAGRAMS, OTHER_ORDER = "explicit search", "decision diagrams", "decision diagrams in another order"

SEARCH_SHARE = Share(time=0.4)
"""Share of explicit search; the rest is for diagrams."""


@dataclass(frozen=True)
class Confirmation:
    """The result of a confirmation.

    Attributes
    ----------
    agrees : bool or None
        Whether all engines that decided agree; None: too few did.
    by : tuple of str
        The confirming engines, each with its time.
    reason : str
        Why there is no confirmation, or the different answers.
    """

    agrees: bool | None
    by: tuple[str, ...] = ()
    reason: str = ""

    def __str__(self) -> str:
        if self.agrees is None:
            return f"not confirmed: {self.reason}"
        return f"confirmed by {' and '.join(self.by)}" if self.agrees else f"engines disagree: {self.reason}"

    def to_dict(self) -> dict[str, object]:
        """Return it for JSON."""
        return {"agrees": self.agrees, "by": list(self.by), "reason": self.reason}


@dataclass(frozen=True)
class Figures:
    """The compared figures of a state space; None: unknown.

    Attributes
    ----------
    never_enabled : frozenset of str or None
        Transitions that are enabled in no marking.
    """

    markings: int | None
    arcs: int | None
    deadlocks: int | None
    most_in_place: int | None
    most_in_marking: int | None
    never_enabled: frozenset[str] | None = None

    def compared(self, other: Figures) -> Figures:
        """Return the other's figures; those unknown on either side are replaced by this object's."""
        pairs = zip(astuple(self), astuple(other), strict=True)
        return Figures(*(mine if mine is None or theirs is None else theirs for mine, theirs in pairs))

    def __str__(self) -> str:
        known = {name: value for name, value in asdict(self).items() if value is not None}
        never = known.pop("never_enabled", frozenset())
        named = [f"never enabled {', '.join(sorted(never))}"] if never else []
        return ", ".join([*(f"{name.replace('_', ' ')} {value}" for name, value in known.items()), *named])


def rests_on_markings(answer: Outcome) -> bool:
    """Return whether an answer depends on all markings: it has neither a run nor a structural proof."""
    if answer.evidence is not None:
        return False
    return answer.status not in ("unknown", "reachable") and not answer.trace and not answer.loop


def confirm_answer(question: Question, answer: Outcome, budget: Budget = UNLIMITED) -> Confirmation:
    """Confirm an answer by explicit search and diagrams; one of them may have given the answer.

    If search cannot decide it, diagrams with two orders are used.
    """
    formula = _formula(question)
    if formula is None:
        return Confirmation(None, reason=ONE_ENGINE)
    words = (
        ("holds", "violated") if isinstance(question, Linear | Branching) else ("reachable", "unreachable")
    )
    return _confirm_formula(question.net, question.names, formula, answer.status, words, budget)


def confirm_claims(
    net: CompiledNet, names: Names, claims: Sequence[Formula], budget: Budget = UNLIMITED
) -> list[Confirmation]:
    """Confirm formulas by explicit search and diagrams: all at once, or one by one if not all hold.

    Returns
    -------
    list of Confirmation
        One for each formula.
    """
    budget = budget.begun()

    def confirmed(formula: Formula, share: Budget) -> Confirmation:
        return _confirm_formula(net, names, formula, "right", ("right", "wrong"), share)

    together = confirmed(And(tuple(claims)) if len(claims) > 1 else claims[0], budget)
    if together.agrees is not False or len(claims) == 1:
        return [together] * len(claims)
    return [confirmed(one, share) for one, share in fairly(claims, budget)]


def confirm_properties(
    net: CompiledNet,
    names: Names,
    properties: Sequence[Property],
    answers: Mapping[str, PropertyAnswer],
    budget: Budget = UNLIMITED,
) -> dict[str, Confirmation]:
    """Confirm the answers to properties that depend on all markings.

    Returns
    -------
    dict
        By property id; answers with other evidence have no entry.
    """
    said: dict[str, Confirmation] = {}
    claims: dict[bool, dict[str, Formula]] = {True: {}, False: {}}
    for one in properties:
        answer = answers.get(one.id)
        if answer is None or answer.value is None or not answer.rests_on_markings:
            continue
        formula = _claim(one, answer.value, net)
        if formula is None:
            said[one.id] = Confirmation(None, reason=ONE_ENGINE)
        else:
            claims[one.kind == "global"][one.id] = formula
    for is_global, wanted in claims.items():
        if wanted:
            named = NetNames(net) if is_global else names
            confirmed = confirm_claims(net, named, list(wanted.values()), budget)
            said |= dict(zip(wanted, confirmed, strict=True))
    return said


def confirm_space(space: SymbolicStateSpace, budget: Budget = UNLIMITED) -> Confirmation:
    """Confirm the figures of complete diagrams by explicit search, or by diagrams with another order."""
    return _confirm_figures(space.net, _figures_of(space), "symbolic", space.order, budget)


def confirm_counts(net: CompiledNet, counted: StateSpace, budget: Budget = UNLIMITED) -> Confirmation:
    """Confirm the counts of a complete state space by another engine, or by diagrams with another order."""
    most = (counted.max_tokens_in_place, counted.max_tokens_in_marking)
    figures = Figures(counted.states, counted.arcs, counted.deadlocks, *most)
    return _confirm_figures(net, figures, counted.engine, counted.levels, budget)


def _confirm_figures(
    net: CompiledNet, figures: Figures, engine: str, order: LevelOrder, budget: Budget
) -> Confirmation:
    def search(share: Budget) -> Figures:
        from dineros.analysis.explicit import explore

        space = explore(net, Share(most_bytes=share.memory).share(share))
        if not space.complete:
            raise BudgetExceededError(space.reason or "unknown")
        never = frozenset(name for t, name in enumerate(net.transitions) if not space.enabled[t])
        most = (max(space.largest_place, default=0), space.largest_total)
        return figures.compared(Figures(space.markings, space.arcs, space.deadlocks, *most, never))

    def of_space(space: SymbolicStateSpace, share: Budget) -> Figures:
        return figures.compared(_figures_of(space))

    orders = [order] if order else []
    return _confirmed(net, figures, search, of_space, engine, orders, budget)


def _figures_of(space: SymbolicStateSpace) -> Figures:
    never = frozenset(name for name in space.net.transitions if not space.enabled(name))
    most = (max(space.largest_place(), default=0), space.largest_total())
    return Figures(space.markings, space.arcs(), space.deadlocks(), *most, never)


def _formula(question: Question) -> Formula | None:
    """Return a CTL formula with the answer to a question; None: there is none."""
    match question:
        case Enabled(name=name):
            return Exists(Finally(AtomEnabled(Name(name))))
        case Marking(condition=text):
            return Exists(Finally(parse(text, "state")))
        case Branching(formula=text):
            return parse(text, "ctl")
        case Linear(formula=text, weak=(), strong=()):
            return _in_branching_time(parse(text))
    return None


def _claim(one: Property, value: bool | int, net: CompiledNet) -> Formula | None:
    """Return a formula that holds exactly if the answer to a property is correct; None: there is none.

    Its names are those of the property; for a question about the net as a whole, those of the net.
    """
    if one.kind == "bound":
        tokens = tuple((1, Name(name)) for name in one.places)
        never_more = ForAll(Globally(Comparison(tokens, "<=", value)))
        return And((never_more, Exists(Finally(Comparison(tokens, ">=", value)))))
    said = one.formula or said_of_all(one.examination, net)
    if one.kind == "ltl":
        found = _in_branching_time(said)
        if found is None:
            return None
        said = found
    return said if value else Not(said)


def _in_branching_time(formula: Formula) -> Formula | None:
    """Return "all runs satisfy an LTL formula" as a CTL formula, if there is one."""
    found = of_linear(formula)
    parts = found.operands if isinstance(found, And) else (found,)
    steps = (isinstance(atom, Fired) for part in parts for atom in part.subformulas())
    return None if any(is_linear(part) for part in parts) or any(steps) else found


def _confirm_formula(
    net: CompiledNet, names: Names, formula: Formula, expected: str, words: tuple[str, str], budget: Budget
) -> Confirmation:
    """Have other engines decide a formula; the result is one of two words."""
    wanted, atoms = basic(formula), BoundAtoms(net, formula, names)

    def word(holds: bool) -> str:
        return words[0] if holds else words[1]

    def search(share: Budget) -> str:
        found = check_ctl(net, formula, names, share, engine="explicit")
        if found.status == "unknown":
            raise BudgetExceededError(found.reason)
        return word(found.status == "holds")

    def of_space(space: SymbolicStateSpace, share: Budget) -> str:
        sets = SymbolicSets(space, atoms, share)
        return word(sets.initially(satisfying(wanted, sets)[wanted]))

    return _confirmed(net, expected, search, of_space, None, [], budget)


def _confirmed(
    net: CompiledNet,
    expected: V,
    search: Callable[[Budget], V],
    of_space: Callable[[SymbolicStateSpace, Budget], V],
    engine: str | None,
    orders: list[LevelOrder],
    budget: Budget,
) -> Confirmation:
    """Have other engines decide: one besides the engine that answered, or two if that is unknown.

    `orders` are the orders of diagrams that have decided already; another order is tried only if there are
    some.
    """
    budget, said, by, why = budget.begun(), [("the answer", expected)], list[str](), list[str]()

    def diagrams(share: Budget) -> V:
        known = tuple(reversed(orders[0])) if orders else None
        space = symbolic_state_space(net, share, seed=1 + len(orders), order=known)
        if not space.complete:
            raise DiagramMemoryError
        if space.order in orders:
            raise BudgetExceededError("no other order gives diagrams that are small enough")
        orders.append(space.order)
        return of_space(space, share)

    ways: list[tuple[str, Callable[[Budget], V]]] = [(OTHER_ORDER, diagrams)]
    if engine != "symbolic":
        ways.insert(0, (DIAGRAMS, diagrams))
    if engine != "explicit":
        ways.insert(0, (SEARCH, search))
    enough = 2 if engine is None else 1
    for name, decide in ways:
        if len(by) == enough or (name == OTHER_ORDER and not orders):
            break
        began = budget.spent
        try:
            budget.check_time()
            found = decide(SEARCH_SHARE.share(budget) if name == SEARCH else budget)
        except GIVEN_UP as limit:
            why.append(f"{name}: {str(limit) or 'memory ran out'}")
            continue
        said.append((name, found))
        by.append(f"{name} ({budget.spent - began:.2f} s)")
    if any(value != expected for _, value in said):
        return Confirmation(False, tuple(by), "; ".join(f"{name}: {value}" for name, value in said))
    return Confirmation(True, tuple(by)) if len(by) >= enough else Confirmation(None, (), "; ".join(why))
