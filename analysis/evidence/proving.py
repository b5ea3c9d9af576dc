"""Finds certificates: facts that exclude what is asked for, by structure and by induction.

Of what is asked for, a marking is taken that no known fact excludes. The state equation excludes it, by a
weighting of the places; or a marked trap does that is empty in it; until nothing is left. Where that fails,
the clauses that what is asked for never holds may be inductive, with what is known by then.

References
----------
J. Esparza, S. Melzer, *Verification of safety properties using integer programming: beyond the state
equation*, Formal Methods in System Design 16(2), 2000 (traps). M. Sheeran, S. Singh, G. Stålmarck, *Checking
safety properties using induction and a SAT-solver*, FMCAD 2000.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from math import gcd, lcm
from typing import Any

import numpy as np

from dineros.analysis.answers.budget import UNLIMITED, Budget
from dineros.analysis.answers.evidence import Row
from dineros.analysis.evidence.checker import FORMAT, add_fact, refutation, sealed
from dineros.analysis.evidence.deciding import Decider, UndecidedError
from dineros.analysis.evidence.reading import Condition, Net, excluded, negated
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.linear_programs import LinearProgram
from dineros.analysis.nets.siphons import largest_trap
from dineros.analysis.proofs.state_equation import StateEquation
from dineros.metamodel.errors import DinerosError

Fact = dict[str, Any]
Certificate = dict[str, Any]

MOST_FACTS = 500
MOST_CLAUSES = 2_000
#: Sequences of firings that an induction over several steps may look at.
MOST_SEQUENCES = 2_000
MOST_STEPS = 3
#: Places of a trap of which smaller ones are looked for.
LARGE_TRAP = 200


@dataclass(frozen=True)
class Asked:
    """A question, as a certificate names it.

    Attributes
    ----------
    subject : Subject
        The net.
    kind : {"enabled", "marking", "ctl", "ltl"}
        What the text is: the name of a transition, a condition, a formula.
    text : str
    signals, overflow : str
        How a system model was flattened.
    settings : sequence of str
        How the model was changed.
    """

    subject: Subject
    kind: str
    text: str
    signals: str = "none"
    overflow: str = "weighted"
    settings: Sequence[str] = ()


def certify(asked: Asked, budget: Budget = UNLIMITED) -> Certificate | None:
    """Return a certificate of the answer to a question; None where none is found.

    Each is checked as a whole before it is returned.
    """
    net = Net.of(asked.subject.model, asked.signals, asked.overflow)
    for answer in ("unreachable",) if asked.kind in ("enabled", "marking") else ("holds", "violated"):
        try:
            goal = excluded(net, asked.kind, asked.text, answer)
        except DinerosError:  # of the question of a certificate; whoever answers says what is wrong with it
            continue
        facts = prove(net, asked.subject, goal, budget.begun())
        return None if facts is None else certificate_of(asked, net, goal, answer, facts)
    return None


def certificate_of(
    asked: Asked, net: Net, goal: Condition, answer: str, facts: Sequence[Fact]
) -> Certificate | None:
    """Return a certificate with facts of any origin; None where it would not stand."""
    certificate = sealed(
        {
            "format": FORMAT,
            "model": str(asked.subject.model.id),
            "settings": list(asked.settings),
            "signals": asked.signals,
            "overflow": asked.overflow,
            "net": net.digest,
            "question": {"kind": asked.kind, "text": asked.text},
            "answer": answer,
            "excluded": goal,
            "facts": list(facts),
        }
    )
    return None if refutation(certificate, asked.subject.model) else certificate


def prove(net: Net, subject: Subject, goal: Condition, budget: Budget) -> list[Fact] | None:
    """Return facts by which no reachable marking fulfils a condition; None where none are found."""
    search = _Search(net, subject, goal, budget)
    try:
        return search.facts if search.structure() else search.induction()
    except UndecidedError:
        return None


class _Search:
    def __init__(self, net: Net, subject: Subject, goal: Condition, budget: Budget) -> None:
        self.net, self.compiled, self.goal, self.budget = net, subject.net, goal, budget
        self.index = subject.place_index
        self.equation = StateEquation(self.compiled)
        self.facts: list[Fact] = []
        self.decider = Decider(lambda: budget.is_over)
        self.root = self.decider.encode(goal)

    def structure(self) -> bool:
        """Look for weightings and traps; whether they suffice."""
        while len(self.facts) < MOST_FACTS:
            marking = self.decider.marking([self.root])
            if marking is None:
                return True
            rows = [(self._indexed(row["sum"]), row["least"]) for row in _fulfilled(self.goal, marking)]
            fact = self._weights(rows) or self._trap(rows)
            if fact is None or add_fact(self.net, self.decider, fact):
                return False
            self.facts.append(fact)
        return False

    def induction(self) -> list[Fact] | None:
        """Look whether the clauses that exclude the goal are inductive; return all facts."""
        clauses = _clauses(negated(self.goal))
        if clauses is None:
            return None
        for steps in range(1, MOST_STEPS + 1):
            if steps > 1 and len(self.net.firings) ** steps > MOST_SEQUENCES:
                break
            decider = Decider(lambda: self.budget.is_over)
            found = [*self.facts, {"clauses": clauses, "steps": steps}]
            if not any(add_fact(self.net, decider, fact) for fact in found):
                return found
        return None

    def _weights(self, rows: Sequence[Row]) -> Fact | None:
        traps = [({self.index[p]: 1 for p in fact["trap"]}, 1) for fact in self.facts if "trap" in fact]
        found = self.equation.excludes([*rows, *traps])
        return {"weights": self._whole(found.weights)} if found and found.weights else None

    def _whole(self, weights: Mapping[int, Fraction]) -> dict[str, int]:
        scale = lcm(*(weight.denominator for weight in weights.values()))
        whole = {self.compiled.places[p]: int(weight * scale) for p, weight in weights.items()}
        common = gcd(*whole.values())
        return {name: weight // common for name, weight in whole.items()}

    def _trap(self, rows: Sequence[Row]) -> Fact | None:
        """Return a trap that is marked at first, and empty in a solution of the state equation."""
        marking = self._solution(rows)
        if marking is None:
            return None
        trap = self._marked_trap([p for p, tokens in enumerate(marking) if tokens < 1e-6])
        for place in trap if len(trap) <= LARGE_TRAP else ():
            if place in trap:
                trap = self._marked_trap([p for p in trap if p != place]) or trap
        return {"trap": [self.compiled.places[p] for p in trap]} if trap else None

    def _marked_trap(self, places: Sequence[int]) -> tuple[int, ...]:
        trap = largest_trap(self.compiled, places)
        return trap if any(self.compiled.initial[p] for p in trap) else ()

    def _solution(self, rows: Sequence[Row]) -> list[float] | None:
        """Return m0 + C x >= 0 that fulfils rows and known traps, with few tokens; of any x >= 0."""
        compiled, initial = self.compiled, self.compiled.initial
        traps = [({self.index[p]: 1 for p in fact["trap"]}, 1) for fact in self.facts if "trap" in fact]
        wanted = [*rows, *traps, *(({p: 1}, 0) for p in range(len(compiled.places)))]
        effects: list[dict[int, int]] = [{} for _ in compiled.places]
        for t, change in enumerate(compiled.delta):
            for p, gain in change.items():
                effects[p][t] = gain
        program, limits = [], []
        for weights, least in wanted:
            row: dict[int, float] = {}
            for p, weight in weights.items():
                for t, gain in effects[p].items():
                    row[t] = row.get(t, 0.0) - weight * gain
            program.append({t: value for t, value in row.items() if value})
            limits.append(float(sum(k * int(initial[p]) for p, k in weights.items()) - least))
        size = len(compiled.transitions)
        costs = np.array([float(sum(change.values())) for change in compiled.delta])
        firings = LinearProgram(program, size).solve(
            costs, np.array(limits), np.zeros(size), np.full(size, np.inf)
        )
        if firings is None:
            return None
        return [
            float(initial[p]) + sum(gain * firings[t] for t, gain in effects[p].items())
            for p in range(len(compiled.places))
        ]

    def _indexed(self, weights: Mapping[str, int]) -> dict[int, int]:
        return {self.index[p]: weight for p, weight in weights.items() if weight}


def _fulfilled(condition: Condition, marking: Mapping[str, int]) -> Iterator[Condition]:
    """Yield inequalities that hold in a marking, and by which a condition holds that does."""
    if "sum" in condition:
        yield condition
    elif "all" in condition:
        for part in condition["all"]:
            yield from _fulfilled(part, marking)
    else:
        yield from _fulfilled(next(part for part in condition["any"] if _holds(part, marking)), marking)


def _holds(condition: Condition, marking: Mapping[str, int]) -> bool:
    if "sum" in condition:
        return bool(sum(k * marking.get(p, 0) for p, k in condition["sum"].items()) >= condition["least"])
    if "all" in condition:
        return all(_holds(part, marking) for part in condition["all"])
    return any(_holds(part, marking) for part in condition["any"])


def _clauses(condition: Condition) -> list[list[Condition]] | None:
    """Return a condition as clauses; None where they would be too many."""
    if "sum" in condition:
        return [[condition]]
    ((key, parts),) = condition.items()
    found = [_clauses(part) for part in parts]
    known = [clauses for clauses in found if clauses is not None]
    if len(known) < len(found):
        return None
    if key == "all":
        together = [clause for clauses in known for clause in clauses]
        return together if len(together) <= MOST_CLAUSES else None
    size = 1
    for clauses in known:
        size *= len(clauses)
        if size > MOST_CLAUSES:
            return None
    return [[row for clause in chosen for row in clause] for chosen in product(*known)]
