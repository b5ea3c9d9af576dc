"""Patterns in words: compared with what they mean, step by step along a run; what is wrong with a text."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Atom, Comparison, Fired
from dineros.analysis.requirements.patterns import read_pattern

Letter = frozenset[str]
LETTERS = st.frozensets(st.sampled_from("pqrs"))
WORDS = st.tuples(st.lists(LETTERS, max_size=5), st.lists(LETTERS, min_size=1, max_size=4))
PATTERNS = ["never P", "always P", "P happens", "P until S", "P leads to S", "P only after S"]
TIMES = [f"at most {times} P" for times in ("once", "twice", "3 times")]
SCOPES = ["", "before R: ", "after Q: ", "between Q and R: ", "after Q until R: "]


def is_true(atom: Atom, letter: Letter) -> bool:
    assert isinstance(atom, Comparison | Fired)
    (name,) = [name for _, name in atom.terms] if isinstance(atom, Comparison) else [atom.name]
    return name.text in letter


def intervals(scope: str, word: list[Letter], begins: bool, ends: bool) -> list[tuple[int, int]]:
    """Return where a scope holds, in a word so long that nothing new comes after it.

    Whether it begins and ends with a step tells whether it begins after, and ends with that letter.
    """
    size = len(word)

    def first(name: str, start: int) -> int | None:
        return next((place for place in range(start, size) if name in word[place]), None)

    if not scope:
        return [(0, size)]
    if scope.startswith("before"):
        end = first("r", 0)
        return [] if end is None else [(0, end + ends)]
    if scope == "after Q: ":
        begin = first("q", 0)
        return [] if begin is None else [(begin + begins, size)]
    after = [place + begins for place in range(size - begins) if "q" in word[place]]
    found = []
    for begin in after:
        if "r" in word[begin] and not ends:
            continue
        end = first("r", begin)
        if end is not None:
            found.append((begin, end + ends))
        elif scope.startswith("after"):
            found.append((begin, size))
    return found


def is_fulfilled(pattern: str, word: list[Letter], begin: int, end: int, is_step: bool, settled: int) -> bool:
    """Return whether a pattern holds in a part of a word."""
    part = word[begin:end]
    p, s = ["p" in letter for letter in part], ["s" in letter for letter in part]
    match pattern.split():
        case ["never", _]:
            return not any(p)
        case ["always", _]:
            return all(p)
        case [_, "happens"]:
            return any(p)
        case [_, "until", _]:
            return any(s) and all(p[: s.index(True)])
        case [_, "leads", *_]:
            last = len(part) if end < len(word) else max(0, settled - begin)
            return all(any(s[place + is_step :]) for place in range(last) if p[place])
        case [_, "only", *_]:
            return not any(p) or any(s[: p.index(True) + 1])
    times = {"once": 1, "twice": 2, "3": 3}[pattern.split()[2]]
    if is_step:
        return sum(p) <= times
    return sum(now and not before for before, now in zip([False, *p], p, strict=False)) <= times


@given(
    WORDS,
    st.sampled_from(SCOPES),
    st.sampled_from([*PATTERNS, *TIMES]),
    st.tuples(st.booleans(), st.booleans(), st.booleans()),
)
def test_a_pattern_means_what_its_words_say(
    lasso: tuple[list[Letter], list[Letter]], scope: str, pattern: str, steps: tuple[bool, bool, bool]
) -> None:
    (stem, loop), (is_step, begins, ends) = lasso, steps
    word = [*stem, *loop * 6]
    settled = len(stem) + 4 * len(loop)  # what comes later comes again after this
    places = [
        (begin, end)
        for begin, end in intervals(scope, word, begins, ends)
        if begin < settled or end < len(word)
    ]
    expected = all(
        is_fulfilled(pattern, word, *place, is_step, settled) for place in places if place[0] < settled
    )
    text = scope + pattern
    text = text.replace("Q", "fired(q)" if begins else "q >= 1")
    text = text.replace("R", "fired(r)" if ends else "r >= 1").replace("S", "s >= 1")
    text = text.replace("P", "fired(p)" if is_step else "p >= 1")
    reading = read_pattern(text)

    assert reading.logic == "ltl" and not reading.is_negated
    assert holds_on_lasso(reading.formula, stem, loop, is_true) == expected


@pytest.mark.parametrize(
    ("text", "formula"),
    [
        ("never a >= 1", "G !(a >= 1)"),
        ("  always  a >= 1 ", "G (a >= 1)"),
        ("fired(T) leads to b >= 1", "G (fired(T) -> X F (b >= 1))"),
        ("fired(T) only\n after b >= 1", "!fired(T) W (b >= 1)"),
        ("after fired(T): never fired(T)", "!fired(T) W (fired(T) & X G !fired(T))"),
        ('never "a happens: until" >= 1', 'G !("a happens: until" >= 1)'),
        ("never (a >= 1 and b >= 1)", "G !(a >= 1 & b >= 1)"),
        (
            "between a >= 1 and (b >= 1 and c >= 1): d >= 1 happens",
            "G (a >= 1 -> (!(b >= 1 & c >= 1) -> (F (b >= 1 & c >= 1)"
            " -> !(b >= 1 & c >= 1) U (d >= 1 & !(b >= 1 & c >= 1)))))",
        ),
        ("at most once fired(T)", "!fired(T) W (fired(T) & X G !fired(T))"),
    ],
)
def test_the_formula_of_a_pattern(text: str, formula: str) -> None:
    assert read_pattern(text).formula == parse(formula)


def test_what_is_possible() -> None:
    possible = read_pattern("fired(T) is possible")
    assert (possible.logic, possible.formula, possible.is_negated) == ("ltl", parse("G !fired(T)"), True)
    stays = read_pattern("a >= 1 stays possible")
    assert (stays.logic, stays.formula, stays.is_negated) == ("ctl", parse("AG EF a >= 1", "ctl"), False)


@pytest.mark.parametrize(
    ("text", "message", "column"),
    [
        ("", "this is not a pattern", 1),
        ("a >= 1", "this is not a pattern", 1),
        ("never", "a condition is missing", 6),
        ("never a", "the formula ends too early", 8),
        ("never G a >= 1", "no temporal operators", 6),
        ("somewhen a >= 1: never b >= 1", "'somewhen a >= 1' is not a scope", 1),
        ("before a >= 1 never b >= 1", "this is not a pattern", 1),
        ("between a >= 1: never b >= 1", "there is no 'and'", 8),
        ("between a >= 1 and b >= 1 and c >= 1: never d >= 1", "'and' splits this in 2 possible ways", 8),
        ("after a >= 1: b >= 1 is possible", "possibility cannot have a scope", 1),
        ("fired(T) stays possible", "fired(T) is not a condition on markings", 1),
        ("at most 21 times fired(T)", "from 1 to 20 times", 9),
        ("at most often fired(T)", "how often?", 8),
        ("never a >= 1 )", "", 14),
        ("never " + "a" * 70_000, "70006 characters", 1),
    ],
)
def test_what_is_no_pattern(text: str, message: str, column: int) -> None:
    with pytest.raises(FormulaError) as caught:
        read_pattern(text)
    assert message in caught.value.message
    assert caught.value.column == column


@pytest.mark.long
@given(st.text(max_size=60), st.sampled_from([*PATTERNS, *TIMES, *SCOPES]))
def test_no_text_ends_in_another_error(text: str, words: str) -> None:
    for whole in (text, words + text, text + words):
        try:
            read_pattern(whole)
        except FormulaError as error:
            assert error.column is None or 1 <= error.column <= len(whole) + 1
