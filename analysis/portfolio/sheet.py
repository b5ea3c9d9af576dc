"""The questions about one net, with the answers known so far."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.evidence import Evidence, Excluded, Weighting, together
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.graphs.predicates import MarkingMatrix, Markings, is_condition, satisfied, total
from dineros.analysis.logic.language.atoms import BoundAtoms, Condition, Linear, SomeEnabled
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.syntax import OPERATORS, TRUE, And, Atom, Constant, Deadlock, Formula
from dineros.analysis.nets.bounds import Bound
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.global_properties import GlobalQuestions
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.properties.normal_form import folded, goal_of, initially, of_linear, parts_of
from dineros.analysis.properties.property import Property, PropertyAnswer

DEADLOCK = "ReachabilityDeadlock"
"""The contest's name for the question whether a deadlock is reachable."""


@dataclass
class Limits:
    """Lower and upper bound of the most tokens that places have together."""

    factors: dict[int, int]
    least: int
    most: int | None = None


@dataclass(frozen=True)
class Asked:
    """A question of a sheet, with the function that records its answer."""

    question: Reach
    note: Callable[[Outcome], None]


@dataclass
class Sheet:
    """All questions about a net.

    Attributes
    ----------
    answered : callable
        Called with each answer as soon as it is known.
    budget : Budget
        Budget of all questions together; its clock runs.
    patience : float
        Time for one question.
    """

    net: CompiledNet
    names: Names
    properties: Sequence[Property]
    answered: Callable[[PropertyAnswer], None]
    budget: Budget
    patience: float
    known: dict[Formula, bool] = field(default_factory=dict)  #: parts, by their value in the initial marking
    always: dict[Formula, bool] = field(default_factory=dict)  #: conditions that are constant
    evidence: dict[Formula, Evidence] = field(
        default_factory=dict
    )  #: why goals, or conditions, are never met
    answers: dict[str, PropertyAnswer] = field(default_factory=dict)
    formulas: dict[str, Formula] = field(default_factory=dict)
    limits: dict[str, Limits] = field(default_factory=dict)
    conditions: dict[Atom, Condition] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._began = time.perf_counter()
        self._folded = 0  #: constant conditions that formulas know of
        self._initial: dict[Formula, bool | None] = {}  #: values of conditions in the initial marking
        self._first = MarkingMatrix(self.net, self.net.initial[None, :])
        for one in self.properties:
            if one.kind == "bound":
                factors: dict[int, int] = {}
                for name in one.places:
                    for place in self.names.places(name):
                        factors[place] = factors.get(place, 0) + 1
                self.limits[one.id] = Limits(factors, int(total(self._first, factors)[0]))
            elif one.formula is not None:
                formula = of_linear(one.formula) if one.kind == "ltl" else one.formula
                self.formulas[one.id] = folded(formula, {})
        self._asked = dict(self.formulas)
        self.conditions = BoundAtoms(self.net, And((TRUE, *self.formulas.values())), self.names).conditions
        self.settle("initial marking")
        self.whole = GlobalQuestions(self.net, self._decide)

    def _decide(self, examination: str, value: bool, technique: str) -> None:
        """Answer the questions about the net as a whole with this name."""
        for one in self.properties:
            if one.kind == "global" and one.examination == examination:
                is_dead = (examination, value) == ("QuasiLiveness", False)
                self.answer(one.id, value, technique, *(self.whole.proof or ()) if is_dead else ())

    @property
    def seconds(self) -> float:
        """Seconds since the questions were asked."""
        return time.perf_counter() - self._began

    def open_formulas(self) -> dict[str, Formula]:
        """Return the undecided formulas, by id."""
        return {id: formula for id, formula in self.formulas.items() if id not in self.answers}

    def open_limits(self) -> dict[str, Limits]:
        """Return the unknown bounds, by id."""
        return {id: limits for id, limits in self.limits.items() if id not in self.answers}

    def open_globals(self) -> list[Property]:
        """Return the unanswered questions about the net as a whole."""
        return [one for one in self.properties if one.kind == "global" and one.id not in self.answers]

    def open_parts(self) -> list[Formula]:
        """Return the subformulas whose values may still decide a formula."""
        found = [part for formula in self.open_formulas().values() for part in parts_of(formula)]
        return [part for part in dict.fromkeys(found) if part not in self.known]

    def open_goals(self) -> list[tuple[Formula, Formula, bool]]:
        """Return subformulas decided by one reachable marking: subformula, condition, value if reachable."""
        goals = ((part, goal_of(part)) for part in self.open_parts())
        return [(part, *goal) for part, goal in goals if goal is not None]

    def open_questions(self) -> list[Asked]:
        """Return the reachability questions: goals, and a deadlock of the net."""
        asked = [
            Asked(Reach(self.net, condition, self.names, is_shown=False), partial(self._note, part, value))
            for part, condition, value in self.open_goals()
        ]
        if self.open_globals() and self.whole.is_open(DEADLOCK):
            stuck = Reach(self.net, Deadlock(), NetNames(self.net), is_shown=False)
            asked.append(Asked(stuck, self._note_deadlock))
        return asked

    def _note(self, part: Formula, value_if_met: bool, outcome: Outcome) -> None:
        if part in self.known:
            return
        if outcome.trace is not None:
            end = np.array(replay(self.net, outcome.trace)[-1:], dtype=np.int64)
            self.look(MarkingMatrix(self.net, end), outcome.by)
        if part not in self.known:
            self.known[part] = value_if_met if outcome.status == "reachable" else not value_if_met
            if outcome.status == "unreachable" and outcome.evidence is not None:
                self.evidence[part] = outcome.evidence
            self.settle(outcome.by)

    def _note_deadlock(self, outcome: Outcome) -> None:
        self.whole.tell(DEADLOCK, outcome.status == "reachable", outcome.by)

    @property
    def is_done(self) -> bool:
        """Whether all questions are answered."""
        return len(self.answers) == len(self.properties)

    def settle(self, technique: str) -> None:
        """Substitute known values into formulas, and record the answers that follow."""
        changed = len(self.always) > self._folded
        self._folded = len(self.always)
        for id, formula in self.open_formulas().items():
            if changed:
                self.formulas[id] = folded(formula, self.always)
            value = initially(self.formulas[id], self._value)
            if value is not None:
                self.answer(id, value, technique)
        for id, limits in self.open_limits().items():
            if limits.most is not None and limits.least >= limits.most:
                self.answer(id, limits.most, technique)

    def _value(self, part: Formula) -> bool | None:
        if part in self.known:
            return self.known[part]
        if part not in self._initial:
            is_plain = is_condition(part)
            values = satisfied(self._first, part, self.conditions) if is_plain else [None]
            self._initial[part] = None if values[0] is None else bool(values[0])
        return self._initial[part]

    def answer(
        self, id: str, value: bool | int, technique: str, dead: str = "", evidence: Evidence | None = None
    ) -> None:
        """Record and report an answer, with its evidence if that is known."""
        if id not in self.answers:
            evidence = self._evidence(id) if id in self.formulas else evidence
            known = PropertyAnswer(id, value, self.seconds, technique, evidence=evidence, dead=dead)
            self.answers[id] = known
            self.answered(known)

    def _evidence(self, id: str) -> Evidence | None:
        """Return the known evidence for the values of a formula's parts."""
        parts = dict.fromkeys([*self._asked[id].subformulas(), *self.formulas[id].subformulas()])
        found = [self.evidence[part] for part in parts if part in self.evidence]
        return together(found) if found else None

    def look(self, markings: Markings, technique: str) -> None:
        """Evaluate the open questions on some reachable markings."""
        found = False
        for part, condition, value in self.open_goals():
            if satisfied(markings, condition, self.conditions).any():
                self.known[part] = value
                found = True
        for limits in self.open_limits().values():
            most = int(total(markings, limits.factors).max(initial=0))
            if most > limits.least:
                limits.least, found = most, True
        if found:
            self.settle(technique)

    def constants(self, bounds: Sequence[Bound | None]) -> dict[Formula, bool]:
        """Return the atoms that bounds of places make constant in all reachable markings."""
        most = [np.inf if bound is None else bound.value for bound in bounds]
        found: dict[Formula, bool] = {}
        for atom, condition in self.conditions.items():
            if atom in self.always or isinstance(atom, Constant):
                continue
            if isinstance(condition, Linear):
                value = _decided(condition, most)
                if value is not None:
                    found[atom] = value
            elif isinstance(condition, SomeEnabled) and all(
                any(most[place] < weight for place, weight in self.net.pre.row(t))
                for t in condition.transitions
            ):
                found[atom] = False
        for atom, condition in self.conditions.items():
            if atom not in found:
                continue
            places = condition.factors if isinstance(condition, Linear) else self._inputs(condition)
            known = [(place, bound) for place in places if (bound := bounds[place]) is not None]
            cases = [Weighting.of_bound(place, bound.value, bound.weights) for place, bound in known]
            self.evidence[atom] = Excluded(tuple(cases))
        return found

    def _inputs(self, condition: Condition) -> list[int]:
        """Return the input places of the transitions in a condition."""
        transitions = sorted(condition.transitions) if isinstance(condition, SomeEnabled) else []
        return list(dict.fromkeys(place for t in transitions for place, _ in self.net.pre.row(t)))


def _decided(condition: Linear, most: Sequence[float]) -> bool | None:
    """The value of a comparison, if it is the same for all token counts between 0 and `most`, else None."""
    terms = [factor * most[place] for place, factor in condition.factors.items() if most[place]]
    high, low = sum(term for term in terms if term > 0), sum(term for term in terms if term < 0)
    compare, bound = OPERATORS[condition.operator], condition.bound
    if condition.operator in ("==", "!="):
        return condition.operator == "!=" if low > bound or high < bound else None
    # The other relations change at most once as the sum grows.
    return compare(low, bound) if compare(low, bound) == compare(high, bound) else None
