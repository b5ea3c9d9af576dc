"""Where an outcome may have begun: a hint for those who read a witness, found from the witness alone.

* An **outcome** rests on literals of what was asked: for a violated formula, those without which it would
  not fail (`dineros.analysis.logic.language.explanation`); for a marking that was looked for, its
  comparisons; for a firing, what enables it; for a deadlock, what keeps transitions from firing that have
  some of their tokens.
* A literal has been as it is **since** the last firing that made it so, before the outcome rests on it.
* The **first cause** is, where the outcome rests on one marking, the earliest of these firings; where it
  rests on several, as when something never comes, the firing that made the first of these markings.
* Its **causes** are the firings in the causal past of the literals and of the first cause
  (`dineros.analysis.walks.causal_past`).

This does not mean that the outcome is unavoidable from there: other runs may avoid it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field

from dineros.analysis.logic.language.atoms import (
    BoundAtoms,
    Linear,
    NoneEnabled,
    SomeEnabled,
    SomeFired,
    Step,
)
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.explanation import explanation
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import (
    QUANTIFIERS,
    Atom,
    Comparison,
    Enabled,
    Exists,
    ForAll,
    Formula,
    Not,
)
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.witness import replay
from dineros.analysis.walks.causal_past import CausalPast, TokenNeed
from dineros.analysis.witnesses.token_levels import TokenLevels
from dineros.analysis.witnesses.witness import Witness

_ANSWERS = ("holds", "violated", "reachable", "conforms", "unknown")
_OPPOSITE = {">=": "<", "<": ">=", "<=": ">", ">": "<=", "==": "!=", "!=": "=="}


@dataclass(frozen=True)
class Cause:
    """Where an outcome may have begun. Firings are numbered from 1; 0 is before the first."""

    first: int
    """The first cause; 0 where all was so from the start."""
    steps: tuple[int, ...]
    """The firings in the causal past of the outcome, ascending. They can be fired without the others, and the
    literals are as they were.
    """
    decided: dict[str, tuple[int, int]]
    """The literals, as conditions: the firing since which each is true, and that up to which."""


@dataclass
class _Outcome:
    """The facts known so far about an outcome."""

    needs: list[TokenNeed] = field(default_factory=list)
    firings: set[int] = field(default_factory=set)
    decided: dict[str, tuple[int, int]] = field(default_factory=dict)
    begins: dict[int, int] = field(default_factory=dict)  # position -> the latest since of its literals
    earliest: int = 0  # of all literals that have not been so from the start

    def add(self, text: str, position: int, since: int, until: int) -> None:
        self.decided.setdefault(text, (since, until))
        self.begins[position] = max(self.begins.get(position, 0), since)
        if since and (not self.earliest or since < self.earliest):
            self.earliest = since

    @property
    def first(self) -> int:
        return self.earliest if len(self.begins) == 1 else self.begins[min(self.begins)]


def first_cause(witness: Witness, asked: str | None = None, verdict: str | None = None) -> Cause | None:
    """Return where the outcome of a witness may have begun.

    `asked`, `verdict`: what was asked: a formula or a condition; and the answer. If the answer is what
    kind of finding it is, the outcome is the last firing, or the deadlock after it.

    Returns
    -------
    Cause or None
        None if the witness has no firing, or what was asked is about more than one run (nested path
        quantifiers) or is not a condition (tokens that grow without bound).
    """
    if not witness.steps:
        return None
    assert witness.subject is not None, "witness_of() made it"
    search = _CauseSearch(witness.subject, witness)
    if verdict not in _ANSWERS:
        if witness.loop is not None:
            return None  # that tokens grow without bound rests on no marking
        return search.of_firing() if search.goes_on else search.of_deadlock()
    formula = _formula(asked)
    if formula is None:
        return None
    if isinstance(formula, Enabled):
        return search.of_firing()
    if verdict == "reachable":
        return search.of_formula(Not(formula), only_end=True)
    linear = _linear(formula, verdict)
    return None if linear is None else search.of_formula(linear)


def blocked_cause(witness: Witness, transition: str) -> Cause | None:
    """Return where it may have begun that a transition is not enabled after the firings of a witness.

    Parameters
    ----------
    witness : Witness
        The firing sequence, such as a run up to where it does not conform.
    transition : str
        Id of the transition in the flattened net.

    Returns
    -------
    Cause or None
        None if the transition is enabled or unknown, or if nothing has fired.
    """
    subject = witness.subject
    assert subject is not None, "witness_of() made it"
    if not witness.steps or transition not in subject.transition_index:
        return None
    return _CauseSearch(subject, witness).of_blocked(subject.transition_index[transition])


def _formula(asked: str | None) -> Formula | None:
    for logic in ("ltl", "ctl"):
        try:
            return None if asked is None else parse(asked, logic)
        except FormulaError:
            continue
    return None


def _linear(formula: Formula, verdict: str | None) -> Formula | None:
    """Return the formula of LTL that a witness violates; None if there is none."""
    wanted = {"violated": ForAll, "holds": Exists}.get(verdict or "")
    if isinstance(formula, QUANTIFIERS):
        if wanted is None or not isinstance(formula, wanted):
            return None
        formula = formula.operand
    elif verdict != "violated":
        return None
    if any(isinstance(part, QUANTIFIERS) for part in formula.subformulas()):
        return None
    return Not(formula) if wanted is Exists else formula


class _CauseSearch:
    """Finds the cause of one witness."""

    def __init__(self, subject: Subject, witness: Witness) -> None:
        self._subject, self._net = subject, subject.net
        self._sequence = [subject.transition_index[step.transition] for step in witness.steps]
        self._loop = witness.loop
        self._levels = TokenLevels(self._net, self._sequence)
        self._end = len(self._sequence)
        self._spans: dict[tuple[Atom, bool], tuple[int, int]] = {}

    @property
    def goes_on(self) -> bool:
        marking = self._levels.marking(self._end)
        return any(self._net.is_enabled(t, marking) for t in range(len(self._net.transitions)))

    def of_formula(self, formula: Formula, only_end: bool = False) -> Cause | None:
        """Return the cause of a run's violation of a formula, or of that of its last marking."""
        try:
            bound = BoundAtoms(self._net, formula, self._subject.names)
        except FormulaError:
            return None
        letters = [
            Step(tuple(m), t) for m, t in zip(replay(self._net, self._sequence), self._sequence, strict=False)
        ]
        last = Step(tuple(self._levels.marking(self._end)), None)
        back = self._end if self._loop is None else self._loop
        if only_end:
            letters, back = [], 0
        loop = [last] if self._loop is None or only_end else letters[back:]
        found = explanation(formula, letters[:back], loop, bound.is_true)
        outcome = _Outcome()
        for position, atom, value in found or []:
            self._occurrence(outcome, bound, atom, value, self._end if only_end else position)
        return self._cause(outcome)

    def of_firing(self) -> Cause | None:
        """Return the cause of the last firing: what enables it."""
        outcome, at = _Outcome(firings={self._end - 1}), self._end - 1
        for place, weight, at_least in self._asked(self._sequence[at]):
            self._level(outcome, place, weight, at, at_least)
        return self._cause(outcome)

    def of_blocked(self, transition: int) -> Cause | None:
        outcome, marking = _Outcome(), self._levels.marking(self._end)
        for place, weight, at_least in self._blockers(transition, marking):
            self._level(outcome, place, weight, self._end, at_least)
        return self._cause(outcome)

    def of_deadlock(self) -> Cause | None:
        """Return the cause of a deadlock at the end."""
        outcome = _Outcome()
        self._deadlock(outcome, self._end)
        return self._cause(outcome)

    def _deadlock(self, outcome: _Outcome, position: int) -> None:
        """Note what keeps transitions from firing that wait: they have some of their tokens, not all."""
        marking, waiting = self._levels.marking(position), False
        for t in range(len(self._net.transitions)):
            blockers = self._blockers(t, marking)
            waits = len(blockers) < len(self._asked(t))
            waiting |= waits
            for place, weight, at_least in blockers if waits else ():
                self._level(outcome, place, weight, position, at_least)
            outcome.needs.append(self._first_blocker(t, position))
        if not waiting:
            outcome.add("deadlock", position, position, self._end)

    def _cause(self, outcome: _Outcome) -> Cause | None:
        if not outcome.decided:
            return None
        firings = {*outcome.firings, *(range(self._loop, self._end) if self._loop is not None else ())}
        if outcome.first:
            firings.add(outcome.first - 1)
        past = CausalPast(self._net, self._sequence).of(outcome.needs, firings)
        return Cause(outcome.first, tuple(firing + 1 for firing in past), outcome.decided)

    def _asked(self, t: int) -> list[tuple[int, int, bool]]:
        """Return what enables a transition: place, weight, and whether at least that is needed, or less."""
        at_least = [(place, weight, True) for place, weight in self._net.pre.row(t)]
        return at_least + [(place, weight, False) for place, weight in self._net.inhibitor.row(t)]

    def _blockers(self, t: int, marking: Sequence[int]) -> list[tuple[int, int, bool]]:
        """Return what keeps a transition from firing: place, weight, and whether it holds too many."""
        return [
            (place, weight, not at_least)
            for place, weight, at_least in self._asked(t)
            if (marking[place] >= weight) != at_least
        ]

    def _first_blocker(self, t: int, position: int) -> TokenNeed:
        """Return the need that a transition is not enabled: that which has been so for the longest time."""
        blockers = self._blockers(t, self._levels.marking(position))
        place, weight, at_least = min(
            blockers, key=lambda one: self._levels.since(one[0], _test(one[1], one[2]), position)
        )
        return _need(place, position, at_least, weight)

    def _level(self, outcome: _Outcome, place: int, weight: int, position: int, at_least: bool) -> None:
        """Record that a place holds at least, or less than, a number of tokens."""
        test = _test(weight, at_least)
        since, until = self._levels.since(place, test, position), self._levels.until(place, test, position)
        text = f"{self._subject.place_text(place)} {'>=' if at_least else '<'} {weight}"
        outcome.add(text, position, since, until)
        outcome.needs.append(_need(place, position, at_least, weight))

    def _occurrence(
        self, outcome: _Outcome, bound: BoundAtoms, atom: Atom, value: bool, position: int
    ) -> None:
        """Note an atom's value that the violation of a formula rests on."""
        condition = bound.conditions[atom]
        if isinstance(condition, SomeFired) and value:
            outcome.add(str(atom), position, position + 1, position + 1)
            outcome.firings.add(position)
            return

        if isinstance(condition, NoneEnabled) and value:
            self._deadlock(outcome, position)
            return
        since, until = self._spans.get((atom, value), (0, -1))
        if not since <= position <= until:
            since, until = self._spans[atom, value] = self._span(bound, atom, value, position)
        outcome.add(_condition_text(atom, value), position, since, until)
        outcome.needs += self._needs(condition, value, position)

    def _span(self, bound: BoundAtoms, atom: Atom, value: bool, position: int) -> tuple[int, int]:
        """Return from which position to which an atom has the value that it has at a position."""
        near = self._levels.marking_near(position)

        def same(at: int) -> bool:
            letter = Step(tuple(near(at)), self._sequence[at] if at < self._end else None)
            return bound.is_true(atom, letter) == value

        since = until = position
        while since and same(since - 1):
            since -= 1
        while until < self._end and same(until + 1):
            until += 1
        return since, until

    def _needs(
        self, condition: Linear | SomeEnabled | SomeFired | NoneEnabled, value: bool, position: int
    ) -> Iterable[TokenNeed]:
        """Yield what keeps a condition's value at a position as it is."""
        marking = self._levels.marking(position)
        match condition:
            case Linear(factors, operator, bound):
                yield from _linear_needs(factors, operator, bound, value, marking, position)
            case SomeEnabled(transitions) if value:
                enabled = next(t for t in sorted(transitions) if self._net.is_enabled(t, marking))
                for place, weight, at_least in self._asked(enabled):
                    yield _need(place, position, at_least, weight)
            case SomeEnabled(transitions):
                for t in transitions:
                    yield self._first_blocker(t, position)
            case NoneEnabled():
                everything = SomeEnabled(frozenset(range(len(self._net.transitions))))
                yield from self._needs(everything, not value, position)


def _test(weight: int, at_least: bool) -> Callable[[int], bool]:
    return (lambda level: level >= weight) if at_least else (lambda level: level < weight)


def _need(place: int, position: int, at_least: bool, weight: int) -> TokenNeed:
    if at_least:
        return TokenNeed(place, position, "at least", weight)
    return TokenNeed(place, position, "at most")


def _linear_needs(
    factors: dict[int, int], operator: str, bound: int, value: bool, marking: Sequence[int], position: int
) -> Iterable[TokenNeed]:
    total = sum(factor * marking[place] for place, factor in factors.items())
    symbol = operator if value else _OPPOSITE[operator]
    large = symbol in (">=", ">", "==") or (symbol == "!=" and total > bound)
    small = symbol in ("<=", "<", "==") or (symbol == "!=" and total < bound)
    enough = None
    if large and len(factors) == 1 and symbol in (">=", ">"):
        (factor,) = factors.values()
        enough = -(-(bound + (symbol == ">")) // factor) if factor > 0 else None
    for place, factor in factors.items():
        if large in (small, factor > 0):
            yield TokenNeed(place, position, "at least", enough)
        if small in (large, factor > 0):
            yield TokenNeed(place, position, "at most")


def _condition_text(atom: Atom, value: bool) -> str:
    if value:
        return str(atom)
    if isinstance(atom, Comparison):
        return str(Comparison(atom.terms, _OPPOSITE[atom.operator], atom.bound))  # type: ignore[arg-type]
    return str(Not(atom))
