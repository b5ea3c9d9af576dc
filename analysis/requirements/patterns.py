"""Properties in words: the patterns and scopes of Dwyer et al., as formulas.

==========================  ====================================================
``never P``                 absence
``always P``                universality
``P happens``               existence
``P until Q``               Q happens, and P holds until then
``P leads to Q``            response
``P only after Q``          precedence
``at most 2 times P``       bounded existence
``P is possible``           some run has it
``P stays possible``        from every marking, some run has it
==========================  ====================================================

``never``, ``always``, ``happens`` and ``leads to`` may end with ``within 0.05``, without a scope. The last
one bounds the time from each P to the next Q, the others the time from the start. Only questions
with times know that.

Each but the last two may have a scope in front of it: ``before R:``, ``after Q:``, ``between Q and R:`` and
``after Q until R:``. A scope holds from the marking Q on, or after the step Q, and ends with the next R:
before that marking, or with that step, which is part of it. ``before`` and ``between`` require nothing if
no R follows. What a step leads to comes after it. ``P``, ``Q`` and ``R`` are conditions on markings and
steps, without temporal operators.

References
----------
M. B. Dwyer, G. S. Avrunin, J. C. Corbett, *Patterns in property specifications for finite-state
verification*, ICSE 1999.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from typing import Literal

from dineros.analysis.logic.language.bounded import Bounded, Window, number
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import MAX_LENGTH, parse
from dineros.analysis.logic.language.syntax import (
    TEMPORAL,
    And,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Implies,
    Next,
    Not,
    Or,
    Until,
    WeakUntil,
)

MOST_TIMES = 20
"""Largest number of a bounded existence: its formula grows with it."""

_WITHIN = "never P within 5; always P within 5; P happens within 5; P leads to Q within 5"
_TIMES = {"once": 1, "twice": 2}
_HINT = (
    "never P; always P; P happens; P until Q; P leads to Q; P only after Q; at most 2 times P; "
    "P is possible; P stays possible; before that: before R:, after Q:, between Q and R:, after Q until R:"
)


@dataclass(frozen=True)
class Reading:
    """A property as a formula."""

    logic: Literal["ltl", "ctl"]
    formula: Formula
    is_negated: bool = False
    """Whether the property holds where the formula does not: a run that violates it shows the property."""

    def as_formula(self) -> tuple[Literal["ltl", "ctl"], Formula]:
        """Return a formula that holds where the property does, and its logic."""
        match self.formula:
            case Globally(Not(condition)) if self.is_negated:
                return "ctl", Exists(Finally(condition))
        return self.logic, self.formula


def read_pattern(text: str) -> Reading:
    """Read a property in words.

    Raises
    ------
    FormulaError
        The text is not a pattern; `column` is the position of the fault.
    """
    if len(text) > MAX_LENGTH:
        raise FormulaError(f"the property has {len(text)} characters, more than {MAX_LENGTH}", column=1)
    within = _found(_PatternText(text, 0), r"\bwithin\s+(\d+(?:\.\d+)?(?:/\d+)?)\s*$")
    if within is not None:
        return Reading("ltl", _within(_PatternText(text, 0).before(within), within))
    body, scope = _PatternText(text, 0), None
    colon = _found(body, ":")
    if colon is not None:
        scope, body = body.before(colon), body.after(colon)
    possible = re.search(r"\b(is|stays)\s+possible\s*$", body.text)
    if possible is None:
        return Reading("ltl", _scoped(scope, body))
    if scope is not None:
        raise FormulaError("possibility cannot have a scope", column=1, hint="write never P with the scope")
    return _possible(body.before(possible), possible[1] == "stays")


@dataclass(frozen=True)
class _PatternText:
    """A piece of the text, and where it begins, from 0."""

    text: str
    start: int

    def before(self, match: re.Match[str]) -> _PatternText:
        return _PatternText(self.text[: match.start()], self.start)

    def after(self, match: re.Match[str]) -> _PatternText:
        return _PatternText(self.text[match.end() :], self.start + match.end())


def _within(body: _PatternText, match: re.Match[str]) -> Bounded:
    """Return what a pattern requires of a period that begins at the start, or with each cause."""
    column = match.start(1) + 1
    if _found(body, ":") is not None:
        raise FormulaError("within a time goes without a scope", column=1, hint=_WITHIN)
    window = Window(Fraction(0), number(match[1], column))
    first = re.match(r"\s*(never|always)\b", body.text)
    if first is not None:
        condition = _condition(body.after(first))
        return Bounded(window, Not(condition) if first[1] == "never" else condition, always=True)
    happens = re.search(r"\bhappens\s*$", body.text)
    if happens is not None:
        return Bounded(window, _condition(body.before(happens)))
    leads = _found(body, r"\bleads\s+to\b")
    if leads is None:
        raise FormulaError("this pattern does not support a time", column=column, hint=_WITHIN)
    cause, effect = _sides(body, leads)
    return Bounded(window, effect, trigger=cause, is_after_step=_is_step(cause))


def _possible(part: _PatternText, stays: bool) -> Reading:
    if not stays:
        return Reading("ltl", Globally(Not(_condition(part))), is_negated=True)
    condition = _condition(part)
    steps = next((each for each in condition.subformulas() if isinstance(each, Fired)), None)
    if steps is not None:
        raise FormulaError(
            f"{steps} is not a condition on markings",
            column=part.start + 1,
            hint=f"say enabled({steps.name})",
        )
    return Reading("ctl", ForAll(Globally(Exists(Finally(condition)))))


def _scoped(scope: _PatternText | None, body: _PatternText) -> Formula:
    if scope is None:
        return _pattern(body, _Scope(None))
    words = re.match(r"\s*(before|after|between)\b", scope.text)
    if words is None:
        raise FormulaError(
            f"{scope.text.strip()!r} is not a scope",
            column=scope.start + 1,
            hint="before R, after Q, between Q and R, after Q until R",
        )
    rest = scope.after(words)
    if words[1] == "before":
        end = _condition(rest)
        return Implies(Finally(end), _pattern(body, _Scope(end)))
    if words[1] == "after" and _found(rest, r"\buntil\b") is None:
        begin = _condition(rest)
        return WeakUntil(Not(begin), And((begin, _then(begin, _pattern(body, _Scope(None))))))
    begin, end = _two(rest, "and" if words[1] == "between" else "until")
    within = _pattern(body, _Scope(end))
    if words[1] == "between":
        within = Implies(Finally(end), within)
    if not _is_step(end):
        within = Implies(Not(end), within)
    return Globally(Implies(begin, _then(begin, within)))


def _then(begin: Formula, scope: Formula) -> Formula:
    """Return what holds from a beginning on: after it, if it is a step."""
    return Next(scope) if _is_step(begin) else scope


def _is_step(condition: Formula) -> bool:
    return any(isinstance(part, Fired) for part in condition.subformulas())


def _two(part: _PatternText, word: str) -> tuple[Formula, Formula]:
    """Read two conditions with a word between them, which may be part of either, too."""
    found: list[tuple[Formula, Formula]] = []
    wrong: FormulaError | None = None
    for match in _all_found(part, rf"\b{word}\b"):
        try:
            pair = _sides(part, match)
        except FormulaError as error:
            wrong = wrong or error
        else:
            found.append(pair)
    if len(found) == 1:
        return found[0]
    if found:
        raise FormulaError(
            f"{word!r} splits this in {len(found)} possible ways",
            column=part.start + 1,
            hint="put ( ) around conditions",
        )
    raise wrong or FormulaError(f"there is no {word!r}", column=part.start + 1)


def _pattern(body: _PatternText, scope: _Scope) -> Formula:
    """Return what a pattern requires from now on, in a scope."""
    first = re.match(r"\s*(never|always|at\s+most)\b", body.text)
    if first is not None and first[1] in ("never", "always"):
        condition = _condition(body.after(first))
        return scope.throughout(Not(condition) if first[1] == "never" else condition)
    if first is not None:
        return _bounded(body.after(first), scope)
    happens = re.search(r"\bhappens\s*$", body.text)
    if happens is not None:
        return scope.some_time(_condition(body.before(happens)))
    for words, make in (
        ("leads to", scope.response),
        ("only after", scope.precedence),
        ("until", scope.until),
    ):
        match = _found(body, r"\b" + words.replace(" ", r"\s+") + r"\b")
        if match is not None:
            return make(*_sides(body, match))
    raise FormulaError("this is not a pattern", column=body.start + 1, hint=_HINT)


def _sides(part: _PatternText, match: re.Match[str]) -> tuple[Formula, Formula]:
    """Read the conditions before and after what parts them."""
    return _condition(part.before(match)), _condition(part.after(match))


@dataclass(frozen=True)
class _Scope:
    """From now on, until an end that comes, or forever."""

    end: Formula | None
    """The marking before which it ends, or the step that is its last."""

    @property
    def ends_with_step(self) -> bool:
        return self.end is not None and _is_step(self.end)

    def ended(self, condition: Formula) -> Formula | None:
        """Return that the scope ends here, if a condition is to hold until then."""
        return And((self.end, condition)) if self.end is not None and self.ends_with_step else self.end

    def goes_on(self, condition: Formula) -> Formula:
        """Return that a condition holds here and the scope does not end."""
        return condition if self.end is None else And((condition, Not(self.end)))

    def within(self, condition: Formula) -> Formula:
        """Return that a condition holds here, in the scope."""
        return condition if self.ends_with_step else self.goes_on(condition)

    def throughout(self, condition: Formula) -> Formula:
        ended = self.ended(condition)
        return Globally(condition) if ended is None else WeakUntil(condition, ended)

    def some_time(self, condition: Formula) -> Formula:
        return Finally(condition) if self.end is None else Until(Not(self.end), self.within(condition))

    def response(self, cause: Formula, effect: Formula) -> Formula:
        follows = self.some_time(effect)
        if _is_step(cause):
            follows = And((Not(self.end), Next(follows))) if self.end is not None else Next(follows)
        return self.throughout(Implies(cause, follows))

    def precedence(self, effect: Formula, cause: Formula) -> Formula:
        ended = self.ended(Not(effect))
        return WeakUntil(Not(effect), cause if ended is None else Or((cause, ended)))

    def until(self, during: Formula, then: Formula) -> Formula:
        return Until(self.goes_on(during), self.within(then))

    def as_long(self, condition: Formula, then: Formula) -> Formula:
        """Return that a condition holds until something else does, or as long as the scope lasts."""
        ended = self.ended(condition)
        return WeakUntil(self.goes_on(condition), then if ended is None else Or((ended, then)))


def _bounded(part: _PatternText, scope: _Scope) -> Formula:
    """Return that something happens some times at most: steps count, or how often markings become so."""
    words = re.match(r"\s*(once|twice|\d{1,9}\s+times?)\b", part.text)
    if words is None:
        raise FormulaError("how often?", column=part.start + 1, hint="at most once, twice, 3 times ...")
    times = _TIMES.get(words[1]) or int(words[1].split()[0])
    if not 1 <= times <= MOST_TIMES:
        raise FormulaError(f"from 1 to {MOST_TIMES} times", column=part.start + words.start(1) + 1)
    condition = _condition(part.after(words))
    formula = scope.throughout(Not(condition))
    for _ in range(times):
        if _is_step(condition):
            then: Formula = Next(formula)
            if scope.end is not None and scope.ends_with_step:
                then = Or((scope.end, then))
        else:
            then = scope.as_long(condition, And((scope.within(Not(condition)), formula)))
        formula = scope.as_long(Not(condition), And((scope.within(condition), then)))
    return formula


def _condition(part: _PatternText) -> Formula:
    if not part.text.strip():
        raise FormulaError("a condition is missing", column=part.start + 1, hint=_HINT)
    formula = parse(" " * part.start + part.text)  # so that columns are those of the whole text
    if any(isinstance(each, TEMPORAL) for each in formula.subformulas()):
        raise FormulaError(
            "a pattern's conditions have no temporal operators",
            column=part.start + 1,
            hint="write the whole property in LTL",
        )
    return formula


_OPAQUE = re.compile(r'"(?:[^"\\]|\\.)*"|\{(?:[^{}\\]|\\.)*\}')


def _found(part: _PatternText, pattern: str) -> re.Match[str] | None:
    return next(iter(_all_found(part, pattern)), None)


def _all_found(part: _PatternText, pattern: str) -> list[re.Match[str]]:
    """Return the position of something outside of quotes, braces and parentheses."""
    flat = list(_OPAQUE.sub(lambda match: "\0" * len(match[0]), part.text))
    depth = 0
    for place, letter in enumerate(flat):
        depth += letter == "("
        if depth:
            flat[place] = "\0"
        depth -= letter == ")" and depth > 0
    return list(re.finditer(pattern, "".join(flat)))
