"""Formulas written for selt, read back by a reader of its language and compared by their meaning."""

from __future__ import annotations

import itertools
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import (
    OPERATORS,
    Atom,
    Comparison,
    Deadlock,
    Enabled,
    Fired,
    ForAll,
    Formula,
    Globally,
    Name,
    SignalTrue,
    WeakUntil,
)
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.tina.formulas import fair_text, formula_text
from dineros.analysis.tina.programs import TinaError
from tests.analysis.logic.generated import random_ltl
from tests.analysis.tina.selt_language import read

PLACES = ["a", "{odd} \\ name", "3", "U", "S.a"]
NET = CompiledNet.build(
    dict.fromkeys(PLACES, 0),
    [
        Transition("a", {"3": 1}, {"U": 1}),  # also a place
        Transition("[] t", {"U": 2}, {}, {"a": 1}, {"S.a": 1}),
        Transition("dead", {"a": 1, "3": 1}, {}, {"U": 2}),
    ],
)
NAMES = NetNames(NET)


def atoms() -> list[Atom]:
    rng = random.Random(7)
    made: list[Atom] = [Comparison((), "<", 1), Deadlock(), SignalTrue(Name("U"))]
    for transition in NET.transitions:
        made += [Enabled(Name(transition)), Fired(Name(transition))]
    for operator in OPERATORS:
        for _ in range(3):
            places = rng.sample(PLACES, rng.randrange(1, 4))
            terms = tuple((rng.choice([-3, -1, 1, 2]), Name(place)) for place in places)
            made.append(Comparison(terms, operator, rng.randrange(-3, 4)))  # type: ignore[arg-type]
    return made


ATOMS = atoms()
STEPS = st.builds(
    Step, st.tuples(*[st.integers(0, 3)] * len(PLACES)), st.sampled_from([None, *range(len(NET.transitions))])
)


def is_true_there(atom: Atom, step: Step) -> bool:
    """What selt says of an atom, by the manual."""
    match atom:
        case Comparison(terms, operator, bound):
            return OPERATORS[operator](sum(k * step.marking[PLACES.index(n.text)] for k, n in terms), bound)
        case Fired(name):
            return step.transition is not None and NET.transitions[step.transition] == name.text
        case Deadlock():
            return not any(NET.is_enabled(t, step.marking) for t in range(len(NET.transitions)))
    raise AssertionError(atom)


def written(formula: Formula) -> tuple[str, BoundAtoms]:
    bound = BoundAtoms(NET, formula, NAMES)
    return formula_text(NET, formula, bound), bound


@pytest.mark.parametrize("atom", ATOMS, ids=str)
def test_atoms_mean_the_same_at_every_step(atom: Atom) -> None:
    text, bound = written(atom)
    back = read(text)
    for marking in itertools.product(range(3), repeat=len(PLACES)):
        for event in (None, *range(len(NET.transitions))):
            step = Step(marking, event)
            assert holds_on_lasso(back, [], [step], is_true_there) == bound.is_true(atom, step), (text, step)


@settings(max_examples=300, deadline=None)
@given(
    st.randoms(use_true_random=False), st.lists(STEPS, max_size=3), st.lists(STEPS, min_size=1, max_size=3)
)
def test_the_meaning_stays(rng: random.Random, stem: list[Step], loop: list[Step]) -> None:
    formula = random_ltl(rng, rng.randrange(1, 12), ATOMS)
    text, bound = written(formula)
    here = holds_on_lasso(formula, stem, loop, bound.is_true)
    assert holds_on_lasso(read(text), stem, loop, is_true_there) == here, text


@settings(max_examples=100, deadline=None)
@given(
    st.sets(st.integers(0, 2)),
    st.sets(st.integers(0, 2)),
    st.lists(STEPS, max_size=2),
    st.lists(STEPS, min_size=1, max_size=3),
)
def test_fairness_is_said_in_the_formula(
    weak: set[int], strong: set[int], stem: list[Step], loop: list[Step]
) -> None:
    def is_fair() -> bool:
        def enabled(t: int) -> list[bool]:
            return [NET.is_enabled(t, step.marking) for step in loop]

        fired = {step.transition for step in loop}
        return all(t in fired or not all(enabled(t)) for t in weak) and all(
            t in fired or not any(enabled(t)) for t in strong
        )

    text = fair_text(NET, "F", sorted(weak), sorted(strong))
    assert holds_on_lasso(read(text), stem, loop, is_true_there) == (not is_fair())


@pytest.mark.parametrize(
    ("formula", "text"),
    [
        ("G F fired(dead)", "([] (<> E.dead))"),
        ("{S.a} >= 1", "(S.{S.a} >= 1)"),
        ('a - 2*U < "3"', "(S.a + 1 <= 2 * S.U + S.3)"),
        ("a != -1", "(- (S.a + 1 = 0))"),
        ('"\\{odd\\} \\\\ name" > 0', "(S.{\\{odd\\} \\\\ name} >= 1)"),
        ("a - a >= 1 | true", "(F \\/ T)"),
        ('enabled("[] t")', "((S.U >= 2) /\\ (S.{S.a} >= 1) /\\ (S.a <= 0))"),
        ("a >= 1 & 3 <= a & deadlock", "((S.a >= 1) /\\ (S.a >= 3) /\\ L.dead)"),
    ],
)
def test_how_it_is_written(formula: str, text: str) -> None:
    if formula.startswith('"\\{'):
        formula = formula.replace("\\{", "{").replace("\\}", "}")
    assert written(parse(formula, "ltl"))[0] == text


def test_what_selt_does_not_have_is_refused() -> None:
    with pytest.raises(TinaError, match="no exact equivalent of") as error:
        written(ForAll(Globally(Deadlock())))
    assert error.value.hint == "use another engine"


def test_what_becomes_too_long_is_refused() -> None:
    formula: Formula = Deadlock()
    for _ in range(30):
        formula = WeakUntil(formula, Deadlock())
    with pytest.raises(TinaError, match="more than 100,000 characters"):
        written(formula)
