"""Checks certificates that no reachable marking fulfils a condition. No analysis engine is used.

The checker consists of this module and the readers of models and formulas. A certificate has facts about all
reachable markings m of a net with the initial marking m0, and the conditions that they exclude:

* ``never``: inequalities A . m >= b that no m fulfils together, with factors f >= 0 and a weighting y whose
  sum no firing increases. If f . A <= y and y . m0 < f . b, they cannot: f . b <= f . A . m <= y . m <= y .
  m0.
  This is checked in integers.
* ``clauses`` of inequalities and a number of ``steps``: in all markings of fewer steps, the clauses hold and
  the condition does not; and this is preserved by a firing if it was so in the last ``steps`` markings. With
  0 steps, the ``never`` facts suffice. This is checked by a SAT solver: literal n of a place means that it
  has n or more tokens.

References
----------
A. Schrijver, *Theory of linear and integer programming*, Wiley, 1986, section 7.3 (Farkas' lemma). M.
Sheeran, S. Singh, G. Stålmarck, *Checking safety properties using induction and a SAT-solver*, FMCAD 2000.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from operator import index
from typing import Any

from pysat.card import CardEnc, EncType
from pysat.solvers import Cadical153

from dineros.analysis.logic.language import atoms, syntax
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.model.subject import Subject
from dineros.metamodel.errors import DinerosError

MOST_SUMMANDS = 1_000
"""Maximum value of a sum of tokens that is encoded for the solver."""

Row = tuple[tuple[tuple[int, int], ...], int]
"""Pairs of a place and a non-zero factor, and the least value of their sum."""


def refutation(certificate: Mapping[str, Any], subject: Subject) -> str:
    """Return what is wrong with a certificate about a net; empty if it is valid.

    Parameters
    ----------
    certificate : mapping
        Result of `dineros.analysis.evidence.certificate.read_certificate`.
    subject : Subject
        The net of the model, changed and flattened as the certificate states.

    Raises
    ------
    DinerosError
        The question is not valid for the net.
    """
    known: list[list[Row]] = []
    try:
        for number, fact in enumerate(certificate["never"], 1):
            rows = [_row(subject, one["sum"], one["least"]) for one in fact["rows"]]
            if wrong := _wrong_with(subject, rows, fact["factors"], _row(subject, fact["weights"], 0)[0]):
                return f"fact {number}: {wrong}"
            known.append([_negated(row) for row in rows])
        clauses = [
            [_row(subject, one["sum"], one["least"]) for one in clause] for clause in certificate["clauses"]
        ]
    except KeyError as error:
        return f"the net has no place {error}"
    asked, steps = certificate["question"], certificate["steps"]
    goal = excluded(asked["kind"], asked["text"], certificate["answer"])
    for is_first, count in [*((True, number) for number in range(steps)), (False, steps)]:
        markings = _Markings(subject, goal, known, is_first)
        if markings.lead_to_it(count, clauses if steps else []):
            return "the goal is not excluded" + (f", after {count} steps" if steps else "")
    return ""


def excluded(kind: str, text: str, answer: str) -> syntax.Formula:
    """Return the condition that no reachable marking may fulfil if an answer is correct.

    Raises
    ------
    DinerosError
        The formula is invalid, or is not about unreachable markings.
    """
    match kind, answer:
        case "enabled", "unreachable":
            return syntax.Enabled(syntax.Name(text))
        case "marking", "unreachable":
            return parse(text, "state")
        case ("ltl", "holds") | ("ctl", "holds" | "violated"):
            return _against(parse(text, kind), answer == "holds")
    raise DinerosError(f"certificates do not support the answer '{answer}' to {kind}")


def _against(formula: syntax.Formula, value: bool) -> syntax.Formula:
    match formula:
        case syntax.Not(operand):
            return _against(operand, not value)
        case syntax.And(parts) | syntax.Or(parts) if isinstance(formula, syntax.And) == value:
            return syntax.Or(tuple(_against(part, value) for part in parts))
        case syntax.ForAll(syntax.Globally(operand)) | syntax.Globally(operand) if value:
            return syntax.Not(operand)
        case syntax.Exists(syntax.Finally(operand)) | syntax.Finally(operand) if not value:
            return operand
    raise DinerosError(f"no certificate can show that this is {str(value).lower()}: {formula}")


def _wrong_with(
    subject: Subject, rows: Sequence[Row], factors: Sequence[int], weighting: Sequence[tuple[int, int]]
) -> str:
    """Return what is wrong with a proof that inequalities are never fulfilled together."""
    net, weights, total = subject.net, dict(weighting), dict[int, int]()
    for name, change in zip(net.transitions, net.delta, strict=True):
        if sum(weights.get(p, 0) * gain for p, gain in change.items()) > 0:
            return f"firing {name} raises the weighted sum"
    if len(factors) != len(rows) or any(factor < 0 for factor in factors):
        return "the factors are not those of its inequalities"
    for factor, (terms, _) in zip(factors, rows, strict=True):
        for p, k in terms:
            total[p] = total.get(p, 0) + factor * k
    if any(total.get(p, 0) > weights.get(p, 0) for p in total | weights):
        return "the weighting is less than the inequalities require"
    needed = sum(factor * least for factor, (_, least) in zip(factors, rows, strict=True))
    return "" if sum(k * int(net.initial[p]) for p, k in weighting) < needed else "the inequalities can hold"


class _Markings:
    """Markings at several times as a propositional formula; the ``never`` facts are added at each time."""

    def __init__(
        self, subject: Subject, goal: syntax.Formula, known: Sequence[Sequence[Row]], is_first: bool
    ) -> None:
        self.net, self.goal, self.known, self.is_first = subject.net, goal, known, is_first
        self.conditions = atoms.BoundAtoms(subject.net, goal, subject.names).conditions
        self.sat: Any = Cadical153()
        self.last = 1  # variable 1 is true
        self.add(1)
        self.numbers: dict[tuple[int, int], dict[int, int]] = {}
        self.sums: dict[tuple[int, Row], int] = {}
        self.bounds: dict[int, int] = {}
        for [(terms, least), *others] in filter(None, known):
            if not others and len(terms) == 1 and terms[0][1] < 0:
                p, bound = terms[0][0], least // terms[0][1]
                self.bounds[p] = min(bound, self.bounds.get(p, bound))

    def lead_to_it(self, steps: int, clauses: Sequence[Sequence[Row]]) -> bool:
        """Whether the last marking may fulfil the goal or violate a clause while the earlier ones do not."""
        for time in reversed(range(steps + 1)):
            met = self.literal(time)
            held = [self.any(self.at_least(time, row) for row in clause) for clause in clauses]
            for clause in self.known:
                self.add(*(self.at_least(time, row) for row in clause))
            if time == steps:
                self.add(met, *(-literal for literal in held))
            else:
                for literal in (-met, *held):
                    self.add(literal)
                self.step(time)
        if self.is_first:
            for (time, p), numbers in self.numbers.items():
                for number, literal in numbers.items() if time == 0 else ():
                    self.add(literal if self.net.initial[p] >= number else -literal)
        return bool(self.sat.solve())

    def new(self) -> int:
        self.last += 1
        return self.last

    def add(self, *clause: int) -> None:
        self.sat.add_clause(clause)

    def any(self, literals: Iterable[int]) -> int:
        found, wanted = self.new(), list(literals)
        self.add(-found, *wanted)
        for literal in wanted:
            self.add(found, -literal)
        return found

    def all(self, literals: Iterable[int]) -> int:
        return -self.any(-literal for literal in literals)

    def holds(self, time: int, place: int, number: int) -> int:
        """Return the literal for a place with at least this number of tokens."""
        if number <= 0 or number > self.bounds.get(place, number):
            return 1 if number <= 0 else -1
        known = self.numbers.setdefault((time, place), {})
        if number not in known:
            less, more = [n for n in known if n < number], [n for n in known if n > number]
            known[number] = self.new()
            self.add(-known[number], known[max(less)] if less else 1)
            self.add(known[number], -known[min(more)] if more else 1)
        return known[number]

    def at_least(self, time: int, row: Row) -> int:
        """Return the literal of an inequality; for a sum without bounds, it is unconstrained."""
        terms, least = row
        if not terms or terms[0][1] < 0:
            return -self.at_least(time, _negated(row)) if terms else 1 if least <= 0 else -1
        if len(terms) == 1:
            return self.holds(time, terms[0][0], -(-least // terms[0][1]))
        if least == 1 and all(k > 0 for _, k in terms):
            return self.any(self.holds(time, p, 1) for p, _ in terms)
        if (time, row) not in self.sums:
            self.sums[time, row] = found = self.new()
            if any(p not in self.bounds for p, _ in terms):
                return found
            size = sum(abs(k) * self.bounds[p] for p, k in terms)
            least -= sum(min(k, 0) * self.bounds[p] for p, k in terms)
            if not 0 < least <= size <= MOST_SUMMANDS:
                self.add(found if least <= 0 else -found) if size <= MOST_SUMMANDS else None
                return found
            tokens = [(self.holds(time, p, n + 1), k) for p, k in terms for n in range(self.bounds[p])]
            of_sum = [literal if k > 0 else -literal for literal, k in tokens for _ in range(abs(k))]
            for encode, bound, guard in (
                (CardEnc.atleast, least, -found),
                (CardEnc.atmost, least - 1, found),
            ):
                self.add_all(encode(of_sum, bound, self.last, encoding=EncType.seqcounter), guard)
        return self.sums[time, row]

    def add_all(self, encoded: Any, *others: int) -> None:
        self.last = max(self.last, encoded.nv)
        for clause in encoded.clauses:
            self.add(*others, *clause)

    def step(self, time: int) -> None:
        """Fire one transition, from a time to the next; all literals of the next time exist."""
        net = self.net
        fires = [self.new() for _ in net.transitions]
        self.add(*fires)
        self.add_all(CardEnc.atmost(fires, 1, self.last, encoding=EncType.seqcounter))
        for t, fired in enumerate(fires):
            self.add(-fired, self.enabled(time, t))
        for p, changing in enumerate(net.changing):
            numbers = [
                *self.numbers.get((time + 1, p), ()),
                *([self.bounds[p] + 1] if p in self.bounds else []),
            ]
            for number in numbers:
                literal, still = self.holds(time + 1, p, number), self.holds(time, p, number)
                for before, after in ((still, literal), (-still, -literal)):
                    self.add(-before, after, *(fires[t] for t in changing))
                for t in changing:
                    before = self.holds(time, p, number - net.delta[t][p])
                    self.add(-fires[t], -before, literal)
                    self.add(-fires[t], before, -literal)

    def enabled(self, time: int, transition: int) -> int:
        needed = [self.holds(time, p, k) for p, k in self.net.pre.row(transition)]
        return self.all([*needed, *(-self.holds(time, p, k) for p, k in self.net.inhibitor.row(transition))])

    def literal(self, time: int) -> int:
        """Return the literal of the goal; a `fired(t)` atom is over-approximated by `enabled(t)`."""
        found: dict[syntax.Formula, int] = {}
        for part in self.goal.subformulas():
            operands = [found[operand] for operand in part.operands]
            match part:
                case syntax.Constant(value):
                    found[part] = 1 if value else -1
                case syntax.Atom():
                    found[part] = self.condition(time, self.conditions[part])
                case syntax.Not():
                    found[part] = -operands[0]
                case syntax.And():
                    found[part] = self.all(operands)
                case syntax.Or():
                    found[part] = self.any(operands)
                case syntax.Implies():
                    found[part] = self.any([-operands[0], operands[1]])
                case syntax.Equivalent():
                    found[part] = self.any([self.all(operands), self.all(-one for one in operands)])
                case _:
                    raise DinerosError(f"no condition on markings: {part}")
        return found[self.goal]

    def condition(self, time: int, condition: atoms.Condition) -> int:
        match condition:
            case atoms.Linear(factors, symbol, bound):
                terms = tuple(sorted(factors.items()))
                least, more = self.at_least(time, (terms, bound)), self.at_least(time, (terms, bound + 1))
                same = self.all([least, -more])
                return {">=": least, ">": more, "<": -least, "<=": -more, "==": same, "!=": -same}[symbol]
            case atoms.SomeEnabled(transitions):
                return self.any(self.enabled(time, t) for t in sorted(transitions))
            case atoms.SomeFired(transitions):
                fired = self.new()
                self.add(-fired, *(self.enabled(time, t) for t in sorted(transitions)))
                return fired
        return -self.any(self.enabled(time, t) for t in range(len(self.net.transitions)))


def _row(subject: Subject, weights: Mapping[str, int], least: int) -> Row:
    """Return an inequality with place names resolved; raises `KeyError` for an unknown place."""
    return tuple(sorted((subject.place_index[p], index(k)) for p, k in weights.items() if k)), index(least)


def _negated(row: Row) -> Row:
    return tuple((p, -k) for p, k in row[0]), 1 - row[1]
