"""Hypothesis strategies for the texts of clauses, each with its meaning as a Python function."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from dataclasses import dataclass

from hypothesis import strategies as st

Values = dict[str, bool]
NAMES = ["Sensor", "Danger", "left-arm.idle", "and", "two words", 'quo"te\\']
SPELLINGS = {"Sensor": "Sensor", "Danger": "Danger", "left-arm.idle": "left-arm.idle"} | {
    "and": '"and"',
    "two words": '"two words"',
    'quo"te\\': '"quo\\"te\\\\"',
}


@dataclass(frozen=True)
class Clause:
    """A text and what it means; `text` can stand in any context."""

    text: str
    holds: Callable[[Values], bool]


def assignments(names: list[str]) -> Iterator[Values]:
    """Yield every assignment of truth values to names."""
    for values in itertools.product([False, True], repeat=len(names)):
        yield dict(zip(names, values, strict=True))


def _signal(name: str) -> Clause:
    return Clause(SPELLINGS[name], lambda values: values[name])


_ATOMS = st.sampled_from(NAMES).map(_signal) | st.sampled_from(
    [Clause("true", lambda _: True), Clause("false", lambda _: False)]
)


@st.composite
def _negations(draw: st.DrawFn, clauses: st.SearchStrategy[Clause]) -> Clause:
    operand = draw(clauses)
    sign = draw(st.sampled_from(["!", "¬", "not ", "! "]))
    return Clause(f"{sign}({operand.text})", lambda values: not operand.holds(values))


@st.composite
def _operations(draw: st.DrawFn, clauses: st.SearchStrategy[Clause]) -> Clause:
    left, right = draw(clauses), draw(clauses)
    signs, meaning = draw(
        st.sampled_from(
            [
                (["&", "&&", "∧", "and"], lambda a, b: a and b),
                (["|", "||", "∨", "or"], lambda a, b: a or b),
                (["->", "→"], lambda a, b: b or not a),
                (["<->", "↔"], lambda a, b: a is b),
            ]
        )
    )
    sign, blank = draw(st.sampled_from(signs)), draw(st.sampled_from([" ", "  ", "\n"]))
    return Clause(
        f"({left.text}){blank}{sign}{blank}({right.text})",
        lambda values: meaning(left.holds(values), right.holds(values)),
    )


def clauses(size: int = 8) -> st.SearchStrategy[Clause]:
    """Return texts over `NAMES` of up to about `size` signals."""
    return st.recursive(_ATOMS, lambda inner: _negations(inner) | _operations(inner), max_leaves=size)
