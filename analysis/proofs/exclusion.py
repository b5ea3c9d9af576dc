"""Conditions that no reachable marking fulfils, by the state equation and traps: alternatives one by one.

A condition is a conjunction of inequalities and of disjunctions. If the inequalities alone can be
fulfilled, the smallest disjunction is split, until all alternatives are excluded or too many were tried.
Excluded sets of inequalities are stored, as small as the proof allows: a later set that includes one of them
is excluded at once. A solution of a remaining alternative may leave an initially marked trap empty. Such a
trap is always marked, so this becomes one more inequality.

References
----------
J. Esparza, S. Melzer, *Verification of safety properties using integer programming: beyond the state
equation*, Formal Methods in System Design 16, 2000 (traps). J. P. Marques-Silva, K. A. Sakallah, *GRASP: a
search algorithm for propositional satisfiability*, IEEE Transactions on Computers 48, 1999 (what is learned).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from dineros.analysis.answers.evidence import Excluded, Row, Weighting
from dineros.analysis.logic.language.atoms import Condition, Linear, NoneEnabled, SomeEnabled
from dineros.analysis.logic.language.syntax import And, Atom, Constant, Deadlock, Formula, Not, Or
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.siphons import largest_trap, smaller_trap
from dineros.analysis.proofs.state_equation import StateEquation
from dineros.analysis.walks.firing_counts import firings

MOST_PROGRAMS = 200
MOST_ALTERNATIVES = 4_000
#: Alternatives that are looked at, whether a program is solved for them or not.
MOST_LOOKS = 20_000
#: Traps for one alternative.
MOST_TRAPS = 10
#: Places of a trap of which smaller ones are looked for.
LARGE_TRAP = 200


_Key = tuple[frozenset[tuple[int, int]], int]
"""An inequality, as something to look up."""


class _GivenUpError(Exception):
    """Too many alternatives, or no time left."""


@dataclass(frozen=True)
class _All:
    parts: tuple[_All | _Any | Row, ...]


@dataclass(frozen=True)
class _Any:
    parts: tuple[_All | _Any | Row, ...]


def excluded(
    equation: StateEquation,
    condition: Formula,
    conditions: Mapping[Atom, Condition],
    is_late: Callable[[], bool],
    met: Callable[[Sequence[Row]], bool] | None = None,
    most_traps: int = MOST_TRAPS,
) -> Excluded | None:
    """Return what proves that no reachable marking fulfils a condition in negation normal form, if anything.

    Parameters
    ----------
    condition : Formula
        As `dineros.analysis.logic.language.rewriting.simplified` returns it.
    met : callable
        Told what could not be excluded, inequalities that fulfil the condition; whether that is enough.
        Without it, one alternative that cannot be excluded ends the work.
    most_traps : int
        For one alternative.
    """
    try:
        wanted = _of(equation.net, condition, conditions)
        search = _ExclusionSearch(equation, is_late, met, most_traps)
        if not search.excludes({}, [wanted]):
            return None
        used = [trap for trap in search.traps if any(_token_in(trap) in case.rows for case in search.cases)]
        return Excluded(tuple(search.cases), tuple(used))
    except _GivenUpError:
        return None


class _ExclusionSearch:
    def __init__(
        self,
        equation: StateEquation,
        is_late: Callable[[], bool],
        met: Callable[[Sequence[Row]], bool] | None,
        most_traps: int,
    ) -> None:
        self.equation, self.is_late, self.met, self.most_traps = equation, is_late, met, most_traps
        self.programs = self.looks = 0
        self.cases: list[Weighting] = []
        self.traps: list[tuple[int, ...]] = []
        self._excluded: list[frozenset[_Key]] = []  # inequalities of the cases, but for those of traps

    def excludes(self, rows: Mapping[_Key, Row], more: Sequence[_All | _Any | Row]) -> bool:
        """Whether rows and more conditions cannot be fulfilled together."""
        self.looks += 1
        if self.looks > MOST_LOOKS or self.is_late():
            raise _GivenUpError
        rows, choices, todo = dict(rows), list[_Any](), list(more)
        before = len(rows)
        while todo:
            part = todo.pop()
            match part:
                case _All(parts):
                    todo += parts
                case _Any(parts) if len(parts) == 1:
                    todo += parts
                case _Any(parts):
                    if not parts:
                        return True
                    choices.append(part)
                case _:
                    if part[0] or part[1] > 0:
                        rows[_key(part)] = part
        forbidden = set[_Key]()
        for case in self._excluded:
            missing = case - rows.keys()
            if not missing:
                return True
            forbidden |= missing if len(missing) == 1 else set()
        if forbidden:
            left = [_without(choice, forbidden) for choice in choices]
            if any(len(new.parts) < 2 for new in left):
                return self.excludes(rows, left)
            choices = left
        if rows and (len(rows) > before or not choices) and self._excludes(rows):
            return True
        if not choices:
            if self.met is not None and self.met(list(rows.values())):
                raise _GivenUpError
            if self._excludes_by_traps(rows):
                return True
            if self.met is None:
                raise _GivenUpError
            return False
        choices.sort(key=lambda choice: len(choice.parts))
        first, *others = choices
        is_excluded = True
        for alternative in first.parts:
            # Also after one that could not be excluded: the next may be reached more easily.
            is_excluded &= self.excludes(rows, [alternative, *others])
        return is_excluded

    def _excludes(self, rows: Mapping[_Key, Row]) -> bool:
        self.programs += 1
        if self.programs > MOST_PROGRAMS or self.is_late():
            raise _GivenUpError
        case = self.equation.excludes([*rows.values(), *map(_token_in, self.traps)])
        if case is not None:
            self.cases.append(case)
            self._excluded.append(frozenset(map(_key, case.rows)) & rows.keys())
        return case is not None

    def _excludes_by_traps(self, rows: Mapping[_Key, Row]) -> bool:
        """Whether marked traps exclude what the state equation alone does not."""
        net = self.equation.net
        for _ in range(self.most_traps):
            counts = firings(net, [*rows.values(), *map(_token_in, self.traps)])
            if counts is None or self.is_late():
                return False
            marking = net.initial.copy()
            for t in counts.nonzero()[0].tolist():
                for place, tokens in net.delta[t].items():
                    marking[place] += tokens * counts[t]
            trap = self._marked_trap((marking <= 0).nonzero()[0].tolist())
            if not trap:
                return False
            if len(trap) <= LARGE_TRAP:
                trap = smaller_trap(net, trap)
            self.traps.append(trap)
            if self._excludes(rows):
                return True
        return False

    def _marked_trap(self, places: Sequence[int]) -> tuple[int, ...]:
        trap = largest_trap(self.equation.net, places)
        return trap if any(self.equation.net.initial[place] for place in trap) else ()


def _token_in(trap: Sequence[int]) -> Row:
    return dict.fromkeys(trap, 1), 1


def _key(row: Row) -> _Key:
    return frozenset((p, k) for p, k in row[0].items() if k), row[1]


def _without(choice: _Any, forbidden: set[_Key]) -> _Any:
    """Return a disjunction without the alternatives that something rules out."""

    def is_ruled_out(part: _All | _Any | Row) -> bool:
        match part:
            case _All(parts):
                return any(map(is_ruled_out, parts))
            case _Any(parts):
                return all(map(is_ruled_out, parts))
        return _key(part) in forbidden

    return _Any(tuple(part for part in choice.parts if not is_ruled_out(part)))


def _of(net: CompiledNet, formula: Formula, conditions: Mapping[Atom, Condition]) -> _All | _Any | Row:
    match formula:
        case Constant(value):
            return _All(()) if value else _Any(())
        case And(operands):
            return _All(tuple(_of(net, operand, conditions) for operand in operands))
        case Or(operands):
            return _Any(tuple(_of(net, operand, conditions) for operand in operands))
        case Deadlock():
            return _atom(net, NoneEnabled(), True)
        case Not(Deadlock()):
            return _atom(net, NoneEnabled(), False)
        case Atom():
            return _atom(net, conditions[formula], True)
        case Not(Atom() as atom):
            return _atom(net, conditions[atom], False)
    raise TypeError(f"no condition in normal form: {formula}")


_OPPOSITE = {"<": ">=", "<=": ">", "==": "!=", "!=": "==", ">=": "<", ">": "<="}


def _atom(net: CompiledNet, condition: Condition, is_positive: bool) -> _All | _Any | Row:
    match condition:
        case Linear(factors, symbol, bound):
            return _linear(factors, symbol if is_positive else _OPPOSITE[symbol], bound)
        case SomeEnabled(transitions):
            chosen = sorted(transitions)
        case NoneEnabled():
            chosen, is_positive = list(range(len(net.transitions))), not is_positive
        case _:
            raise TypeError(f"no condition on markings: {condition}")
    size = sum(len(net.pre.row(t)) + len(net.inhibitor.row(t)) for t in chosen)
    if size > MOST_ALTERNATIVES:
        raise _GivenUpError
    if is_positive:
        return _Any(tuple(_All(tuple(_enabling(net, t, True))) for t in chosen))
    return _All(tuple(_Any(tuple(_enabling(net, t, False))) for t in chosen))


def _enabling(net: CompiledNet, transition: int, is_positive: bool) -> list[_All | _Any | Row]:
    """Conditions that enable a transition (all must hold), or that disable it (one is enough)."""
    rows = [({place: 1}, ">=" if is_positive else "<", weight) for place, weight in net.pre.row(transition)]
    rows += [
        ({place: 1}, "<" if is_positive else ">=", weight) for place, weight in net.inhibitor.row(transition)
    ]
    return [_linear(*row) for row in rows]


def _linear(factors: Mapping[int, int], symbol: str, bound: int) -> _All | _Any | Row:
    minus = {place: -factor for place, factor in factors.items()}
    match symbol:
        case ">=":
            return factors, bound
        case ">":
            return factors, bound + 1
        case "<=":
            return minus, -bound
        case "<":
            return minus, 1 - bound
        case "==":
            return _All(((factors, bound), (minus, -bound)))
    return _Any(((factors, bound + 1), (minus, 1 - bound)))
