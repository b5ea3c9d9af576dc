"""One road to every goal, whoever asks: ``find``, ``EF`` and ``AG`` of CTL, ``G`` of LTL (paper, Alg. 5).

1. the markings that are near, which is all there is of small nets;
2. structure: the state equation and traps, which exclude goals without a state space;
3. walks, which meet what is far away but not rare; diagrams of a net with limits where tokens may grow;
4. side by side and by turns, until one knows: explicit search, also of the reduced net; decision diagrams;
   bounded model checking with k-induction, and property directed reachability.

Where a shortest way is asked for and a longer one is known, the shortest is searched for only a while.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING

from dineros.analysis.answers.beside import first_of_two
from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.turns import HEAD_START, Member, first_answer
from dineros.analysis.covering.goals import with_goals
from dineros.analysis.explicit import Order
from dineros.analysis.explicit.goals import Goal
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.disjunctions import goals_of
from dineros.analysis.logic.language.names import Names, NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import (
    TEMPORAL,
    TRUE,
    Enabled,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Name,
    Not,
)
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.shortening import shortened
from dineros.analysis.nets.witness import ending_with_one_of, replay
from dineros.analysis.questions.reachability import INTERRUPTED, QUICK, search
from dineros.analysis.walks.first_round import first_round

if TYPE_CHECKING:
    from dineros.analysis.proofs.encoding import Sums

# Most goals are near, and need none of the engines that are imported where they are asked.
NEAR_STATES, NEAR_IF_SHORTEST = 20_000, 2_000_000
"""Markings looked at before anything else; more of them where a shortest way is asked for."""

STRUCTURE_SECONDS = 2.0
"""Seconds at most for what structure excludes."""

SHORTEST_SHARE, SHORTEST_SECONDS = 0.3, 20.0
"""Part of the time, and seconds at most, for the search for a shortest way where a longer one is known."""

LIMITS_SHARE, FIRST_WORK = 0.6, 3_000_000
"""Part of the time, and cache misses of saturation, about a second, for a net with limits before others."""

WALKS = "walks"
EXPLICIT, REDUCED, DIAGRAMS = "explicit search", "explicit search of the reduced net", "decision diagrams"
STATE_EQUATION, TRAPS = "state equation", "state equation and traps"


def find_enabled(
    net: CompiledNet,
    name: str,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
    is_shortest: bool = True,
) -> Outcome:
    """Find a trace that ends with a transition; of several of the name, whichever is nearest.

    A longer one may be found as `find_marking` says.

    Raises
    ------
    FormulaError
        No transition has the name.
    """
    transitions = names.transitions(name)
    goals = [Goal.enabled(net, *transitions)]
    is_shortest = is_shortest and order == "breadth-first"
    answer = _Road(net, Enabled(Name(name)), names, order, goals, is_shortest).run(budget)
    if answer.trace is None:
        return answer
    return replace(answer, trace=ending_with_one_of(net, answer.trace, transitions))


def find_marking(
    net: CompiledNet,
    condition: str | Formula,
    names: Names,
    budget: Budget = UNLIMITED,
    order: Order = "breadth-first",
    is_shortest: bool = True,
) -> Outcome:
    """Find a trace to a marking that fulfils a condition, a shortest one if the search goes breadth first.

    It may be longer where only the reduced net, or a decision diagram, is small enough, or where
    `is_shortest` is false: then the first way that anybody finds will do.

    Raises
    ------
    FormulaError
        The condition is none on markings, or names something unknown.
    """
    tree = parse(condition, "state") if isinstance(condition, str) else condition
    is_shortest = is_shortest and order == "breadth-first"
    return _Road(net, tree, names, order, goals_of(net, tree, names), is_shortest).run(budget)


def proof_against(net: CompiledNet, condition: Formula, names: Names, budget: Budget) -> Outcome | None:
    """Prove that no reachable marking fulfils a condition, without a state space; None where that fails.

    Parameters
    ----------
    condition : Formula
        On markings; that a transition is fired stands for that it may be.

    Raises
    ------
    FormulaError
        The condition names something unknown.
    """
    from dineros.analysis.proofs.induction import by_induction, sums_of
    from dineros.analysis.proofs.pdr import by_clauses

    if any(isinstance(part, (*TEMPORAL, ForAll, Exists)) for part in condition.subformulas()):
        return None
    budget, wanted = budget.begun(), _without_steps(condition)
    bound = BoundAtoms(net, wanted, names)
    share = budget.share(0.5)
    found = excluded_by_structure(net, wanted, bound, share.left)
    if found is not None or budget.is_over:
        return found
    known = sums_of(net)
    members = [
        Member(partial(engine, net, wanted, bound.conditions, known=known))
        for engine in (by_induction, by_clauses)
    ]
    answer = first_answer(members, budget, _is_answer) if known is not None else None
    return answer if answer is not None and answer.status == "unreachable" else None


def _without_steps(condition: Formula) -> Formula:
    """Return what a condition on markings and steps asks of markings: that what is fired is enabled."""
    made: dict[Formula, Formula] = {}
    wanted = simplified(condition)
    for part in wanted.subformulas():
        match part:
            case Fired(name):
                made[part] = Enabled(name)
            case Not(Fired()):
                made[part] = TRUE
            case _:
                made[part] = part.with_operands(tuple(made[operand] for operand in part.operands))
    return made[wanted]


def excluded_by_structure(
    net: CompiledNet, condition: Formula, bound: BoundAtoms, seconds: float | None
) -> Outcome | None:
    """Ask the state equation and traps; None where they do not exclude a condition."""
    from dineros.analysis.proofs.exclusion import excluded
    from dineros.analysis.proofs.state_equation import StateEquation

    clock = Budget(seconds=seconds).begun()
    found = excluded(StateEquation(net), simplified(condition), bound.conditions, lambda: clock.is_over)
    if found is None:
        return None
    by = TRAPS if found.traps else STATE_EQUATION
    return Outcome("unreachable", seconds=clock.spent, by=by, evidence=found)


@dataclass(frozen=True)
class _Road:
    """A goal and the way to its answer; `goals` is None where these would be too many.

    Where a shortest way is asked for, a longer one is the answer only if the search for it gives up.
    """

    net: CompiledNet
    condition: Formula
    names: Names
    order: Order
    goals: list[Goal] | None
    is_shortest: bool

    @cached_property
    def bound(self) -> BoundAtoms:
        return BoundAtoms(self.net, self.condition, self.names)

    def run(self, budget: Budget) -> Outcome:
        budget = budget.begun()
        first = replace(self, is_shortest=self.order == "breadth-first")
        share = budget.share(most_bytes=QUICK, most_states=_least(NEAR_STATES, budget.states))
        near = first._search(share, is_near=True)
        if _is_answer(near) or near.reason == INTERRUPTED or budget.is_over:
            return near
        if budget.states is not None and budget.states <= NEAR_STATES:
            return near
        left = budget.left
        seconds = STRUCTURE_SECONDS if left is None else min(STRUCTURE_SECONDS, left / 10)
        found = excluded_by_structure(self.net, self.condition, self.bound, seconds)
        if found is not None:
            return replace(found, seconds=budget.spent)
        way = self._walked(budget)
        if self.is_shortest:
            return self._shortest(budget, near, way)
        return self._far(budget, near) if way is None else way

    def _shortest(self, budget: Budget, near: Outcome, way: Outcome | None) -> Outcome:
        """Search on for a shortest way; for a while, where a longer one is known."""
        if way is None:
            share = budget.share(most_bytes=QUICK, most_states=_least(NEAR_IF_SHORTEST, budget.states))
        else:
            share = _at_most(budget.share(SHORTEST_SHARE), SHORTEST_SECONDS)
        near = self._search(replace(share, memory_bytes=_least(QUICK, share.memory_bytes)))
        if _is_answer(near) or near.reason == INTERRUPTED:
            return near
        if way is not None or budget.is_over:
            return near if way is None else way
        return self._far(budget, near)

    def _walked(self, budget: Budget) -> Outcome | None:
        """Walk to one of the goals."""
        if self.goals is None:
            return None
        asked = with_goals(self.net, self.goals)
        if asked is None:
            return None
        found = first_round(asked.net, budget, asked.transitions, any(g.is_deadlock for g in self.goals))
        ways = [asked.way(found.ways[t][:-1]) for t in asked.transitions if t in found.ways]
        if found.deadlock is not None and self.holds(replay(self.net, asked.way(found.deadlock))[-1]):
            ways.append(asked.way(found.deadlock))
        return self._reached(min(ways, key=len), WALKS) if ways else None

    def _far(self, budget: Budget, near: Outcome) -> Outcome:
        """Ask the engines side by side."""
        if budget.states is not None and budget.states <= NEAR_STATES:
            return near
        if not self.is_shortest and self.goals is not None:
            with suppress(BudgetExceededError):
                known = self._with_limits(budget.share(LIMITS_SHARE), FIRST_WORK)
                if known is not None:
                    return known
            # What is met everywhere far away is met at once.
            deep = replace(self, order="depth-first")._search(budget.share(most_states=NEAR_STATES))
            if _is_answer(deep) or deep.reason == INTERRUPTED or budget.is_over:
                return deep
        head_start = HEAD_START if self.is_shortest else 0.0
        members = [
            Member(self._explicit, head_start=head_start),
            Member(self._drawn),
            # Both ask solvers, and have the time of one.
            Member(self._inductive, weight=0.5),
            Member(self._clausal, weight=0.5),
        ]

        def is_final(answer: Outcome) -> bool:
            # A way that is found breadth first is a shortest one; others wait for it.
            is_short = answer.by == EXPLICIT or not self.is_shortest
            return answer.status == "unreachable" or answer.reason == INTERRUPTED or is_short

        answer = first_of_two(members, budget, is_final)
        return answer or Outcome("unknown", reason="time ran out", states=near.states)

    def holds(self, marking: Sequence[int]) -> bool:
        """Whether a marking is one that is looked for, by definition."""
        return holds_on_lasso(self.condition, [], [Step(tuple(marking), None)], self.bound.is_true)

    def _search(self, budget: Budget, is_near: bool = False) -> Outcome:
        """Search markings one by one, for each goal or for a run that never meets the condition."""
        if self.goals is None:
            return self._by_temporal_logic(budget)
        each = partial(search, self.net, order=self.order, is_shortest=self.is_shortest, is_near=is_near)
        return _nearest((each(goal, budget=budget) for goal in self.goals), EXPLICIT)

    def _by_temporal_logic(self, budget: Budget) -> Outcome:
        """Ask for a run on which the condition never holds: a counterexample leads to it."""
        from dineros.analysis.logic.ltl.verification import verify_ltl

        answer = verify_ltl(self.net, Globally(Not(self.condition)), self.names, budget=budget)
        if answer.status == "violated":
            trace = shortened(self.net, answer.stem + answer.loop, self.holds)
            return Outcome("reachable", trace, by=EXPLICIT)
        return replace(answer, status="unreachable", by=EXPLICIT) if answer.status == "holds" else answer

    def _explicit(self, budget: Budget) -> Outcome | None:
        """Search the net, and where it is too large the net reduced for the condition."""
        from dineros.analysis.properties.reduced import reduced

        answer = self._search(budget.share(most_bytes=QUICK))
        if _is_answer(answer) or answer.reason == INTERRUPTED or budget.is_over or budget.memory <= QUICK:
            return answer
        smaller = reduced(self.net, simplified(self.condition), self.names)
        if smaller is None:
            return self._search(budget)
        goals = goals_of(smaller.net, smaller.formula, NetNames(smaller.net))
        if goals is None:
            return self._search(budget)
        answer = _nearest((search(smaller.net, goal, budget, self.order, False) for goal in goals), REDUCED)
        if answer.trace is None:
            return answer
        index = {name: number for number, name in enumerate(self.net.transitions)}
        names = smaller.reduction.expand([smaller.net.transitions[number] for number in answer.trace])
        return self._reached([index[name] for name in names], REDUCED)

    def _inductive(self, budget: Budget) -> Outcome | None:
        """Ask a satisfiability solver, ever deeper."""
        from dineros.analysis.proofs.induction import by_induction

        return self._asked(by_induction, budget)

    def _clausal(self, budget: Budget) -> Outcome | None:
        """Learn clauses that keep the goal away."""
        from dineros.analysis.proofs.pdr import by_clauses

        return self._asked(by_clauses, budget)

    @cached_property
    def _sums(self) -> Sums | None:
        from dineros.analysis.proofs.induction import sums_of

        return sums_of(self.net)

    def _asked(self, engine: Callable[..., Outcome], budget: Budget) -> Outcome | None:
        if self._sums is None:
            return None
        answer = engine(self.net, self.condition, self.bound.conditions, budget, self._sums)
        if answer.trace is not None:
            return self._reached(answer.trace, answer.by)
        return answer if _is_answer(answer) else None

    def _drawn(self, budget: Budget) -> Outcome | None:
        """Ask the decision diagram of all markings, or where these may have no end of a net with limits."""
        from dineros.analysis.logic.ctl.checking import check_ctl

        known = self._with_limits(budget)
        if known is not None:
            return known
        way = Exists(Finally(self.condition))
        answer = check_ctl(self.net, way, self.names, budget, engine="symbolic")
        if answer.status == "holds" and answer.trace is not None and not answer.reason.startswith("a run"):
            return self._reached(answer.trace, DIAGRAMS)
        if answer.status == "violated":
            return Outcome("unreachable", states=answer.states, by=DIAGRAMS)
        return None

    def _with_limits(self, budget: Budget, most_work: int | None = None) -> Outcome | None:
        """Ask the decision diagram of a net in which what may grow without bound has limits."""
        from dineros.analysis.logic.ctl.limits import decide_with_limits

        way = Exists(Finally(self.condition))
        known = decide_with_limits(self.net, way, self.names, budget, most_work)
        if known is None or known.trace is not None:
            return known and self._reached(known.stem, known.by)
        return replace(known, status="unreachable")

    def _reached(self, trace: Sequence[int], by: str) -> Outcome:
        """Replay a trace, and leave out what the condition does not need."""
        return Outcome("reachable", shortened(self.net, trace, self.holds), by=by)


def _is_answer(answer: Outcome) -> bool:
    return answer.status != "unknown"


def _least(one: int, other: int | None) -> int:
    return one if other is None else min(one, other)


def _at_most(budget: Budget, seconds: float) -> Budget:
    """Return a budget of so many seconds at most."""
    left = budget.left
    return replace(budget, started=None, seconds=seconds if left is None else min(seconds, left)).begun()


def _nearest(answers: Iterable[Outcome], by: str) -> Outcome:
    """Return the best of the answers for some goals, each of which will do."""
    known: list[Outcome] = []
    for answer in answers:
        known.append(answer)
        if answer.reason == INTERRUPTED:
            break
    best = replace(min(known, key=_rank, default=Outcome("unreachable", states=0)), by=by)
    states = [answer.states for answer in known if answer.states is not None]
    return best if best.status == "reachable" else replace(best, states=max(states, default=None))


def _rank(answer: Outcome) -> tuple[int, int]:
    """Order answers: short traces first, then unknown, then unreachable."""
    return ["reachable", "unknown", "unreachable"].index(answer.status), len(answer.stem)
