"""Reading formulas: precedence, spelling, names, and what is said about mistakes."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import MAX_LENGTH, Logic, parse
from dineros.analysis.logic.language.syntax import Comparison, Finally, Fired, Globally, Implies, Name
from tests.analysis.logic.generated import PROPOSITIONS, random_ctl, random_ltl


@pytest.mark.parametrize(
    ("text", "same", "logic"),
    [
        ("Shown >= 2", "Shown>=2", "state"),
        ("PickReqL + PickReqR <= 1", "1 >= PickReqL + PickReqR", "state"),
        ("2*A - B == 3", "2 * A = B + 3", "state"),
        ("2*(A - 3) - B > -1", "2*A - B > 5", "state"),
        ("A + A - 2*A >= 1", "B - B >= 1", "state"),
        ("1 <= A <= 3", "A >= 1 & A <= 3", "state"),
        ("A ≥ 1 ∧ ¬(B ≠ 2) ∨ C ≤ 3", "A >= 1 and not B != 2 or C <= 3", "state"),
        ("A >= 1 && B >= 1 || deadlock", "(A >= 1 & B >= 1) | deadlock", "state"),
        ("A >= 1 -> B >= 1 -> C >= 1", "A >= 1 → (B >= 1 → C >= 1)", "state"),
        ("A >= 1 <-> B >= 1 <-> C >= 1", "(A >= 1 ↔ B >= 1) ↔ C >= 1", "state"),
        ("G A >= 1 -> B >= 1", "(G (A >= 1)) -> (B >= 1)", "ltl"),
        ("A >= 1 & B >= 1 U C >= 1", "A >= 1 & ((B >= 1) U (C >= 1))", "ltl"),
        ("A >= 1 U B >= 1 R C >= 1 W true", "A >= 1 U (B >= 1 R (C >= 1 W true))", "ltl"),
        ("GF A >= 1 & XX false", "G F A >= 1 & X X false", "ltl"),
        ("[] <> fired(t)", "G F fired(t)", "ltl"),
        ("G >= 1 & 2*F + U < X & enabled(W)", '"G" >= 1 & 2*"F" + "U" < "X" & enabled("W")', "ltl"),
        ("AG EF A >= 1", "A[true U (A >= 1)] -> AG EF A >= 1 | AG EF A >= 1", "ctl"),
        ("android >= 1 or nothing >= 1", "android>=1|nothing>=1", "state"),
        (
            '"a b" >= 1 & {x.y-z} >= 1 & Pick[2].PickRun >= 1',
            '"Pick[2].PickRun" >= 1 & "a b">=1 & "x.y-z">=1',
            "state",
        ),
    ],
)
def test_spellings(text: str, same: str, logic: Logic) -> None:
    one, other = parse(text, logic), parse(same, logic)
    if logic == "ctl" or "Pick" in text:
        assert {str(part) for part in one.subformulas()} & {str(part) for part in other.subformulas()}
    else:
        assert one == other or (str(one), str(other)) == ("0 >= 1", "0 >= 1")


def test_the_tree() -> None:
    left, right = Comparison(((1, Name("PickReqL")),), ">=", 1), Comparison(((1, Name("PickResL")),), ">=", 1)
    assert parse("G (PickReqL >= 1 -> F PickResL >= 1)") == Globally(Implies(left, Finally(right)))
    assert parse('fired("a \\" b")') == Fired(Name('a " b'))


@given(st.integers(0, 2**32), st.integers(1, 12), st.booleans())
def test_printed_formulas_are_read_back(seed: int, size: int, is_ltl: bool) -> None:
    rng = random.Random(seed)
    formula = (random_ltl if is_ltl else random_ctl)(rng, size, PROPOSITIONS)
    once = parse(str(formula), "ltl" if is_ltl else "ctl")
    assert parse(str(once), "ltl" if is_ltl else "ctl") == once
    assert str(once) == str(formula)


@pytest.mark.parametrize(
    ("text", "logic", "column", "part"),
    [
        ("", "ltl", 1, "empty"),
        ("A >= 1 &", "ltl", 9, "too early"),
        ("p & q", "ltl", 3, "a name alone is not a formula"),
        ("[] <> p", "ltl", 8, "a name alone is not a formula"),
        ("enabled(3)", "state", 9, "a name is expected"),
        ("A$ >= 1", "state", 2, "'$' is not allowed here"),
        ("AG A >= 1", "ltl", 1, "belongs to CTL"),
        ("AG G A >= 1", "ctl", 4, "write A or E before it"),
        ("A >= 1 U B >= 1", "ctl", 8, "write A or E before it"),
        ("A[A >= 1]", "ctl", 1, "needs a temporal operator"),
        ("EF fired(t)", "ctl", 10, "about a step"),
        ("F A >= 1", "state", 1, "is not allowed here"),
        ("A >= 1234567890123", "state", 6, "'1' is not allowed here"),
        ("B >= 2000000 * (900000000000 * A)", "state", 1, "too large"),
        ("A[A >= 1 U B >= 1] | (A >= 1 U B >= 1)", "ctl", 30, "write A or E before it"),
        ("!" * 200 + "true", "ltl", 1, "nests more than"),
        ("(" * 70_000, "ltl", MAX_LENGTH + 1, "characters"),
    ],
)
def test_mistakes_have_a_column(text: str, logic: Logic, column: int, part: str) -> None:
    with pytest.raises(FormulaError) as caught:
        parse(text, logic)
    assert caught.value.column == column
    assert part in str(caught.value)
    assert str(caught.value).startswith(f"column {column}: ")
    assert "\n" not in str(caught.value)


def test_many_parentheses_are_no_nesting() -> None:
    assert parse("(" * 5000 + "A >= 1" + ")" * 5000) == parse("A >= 1")


@given(st.text(alphabet='AEGFXURW ()[]&|!->=<>123ab"{}∧', max_size=30))
def test_any_text_is_read_or_refused(text: str) -> None:
    for logic in ("ltl", "ctl", "state"):
        try:
            formula = parse(text, logic)
        except FormulaError:
            continue
        assert str(formula)
