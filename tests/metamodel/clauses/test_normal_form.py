import itertools
import time

import pytest
from hypothesis import given

from dineros.metamodel.clauses import MAX_DISJUNCTIONS, Not, Signal, SignalLiteral, parse, to_cnf
from dineros.metamodel.clauses.normal_form import NormalForm
from dineros.metamodel.errors import ClauseError
from tests.support.clauses import NAMES, Clause, assignments, clauses


def read(form: str) -> NormalForm:
    """Read a form such as ``a | !b; c``; a lone dash is the empty disjunction."""
    disjunctions = [part.split("|") for part in form.split(";")] if form else []
    return tuple(
        tuple(SignalLiteral(name.strip(" !"), "!" in name) for name in literals if name.strip() != "-")
        for literals in disjunctions
    )


@pytest.mark.parametrize(
    ("text", "form"),
    [
        ("Sensor", "Sensor"),
        ("Sensor & !Sensor", "Sensor; !Sensor"),
        ("Sensor | !Sensor", ""),
        ("true", ""),
        ("false", "-"),
        ("a & false", "-"),
        ("a | false", "a"),
        (
            "(RobotIsIdle | RobotHasFinished) & !ObjectIsPicked",
            "RobotIsIdle | RobotHasFinished; !ObjectIsPicked",
        ),
        ("a & b | c", "a | c; b | c"),
        ("!(a | !b)", "!a; b"),
        ("b -> a", "!b | a"),
        ("b <-> a", "!b | a; b | !a"),
        ("!(a <-> b)", "!a | !b; a | b"),
        ("a | a | b", "a | b"),
        ("(a | b) & (b | a)", "a | b"),
        ("(a | b | c) & (d | b) & (a | b)", "d | b; a | b"),
    ],
)
def test_brings_into_normal_form(text: str, form: str) -> None:
    expected = read(form)
    found = to_cnf(parse(text))
    assert [set(disjunction) for disjunction in found] == [set(disjunction) for disjunction in expected]


def test_literals_follow_the_text() -> None:
    assert to_cnf(parse("(z | a | !m) & (m | z)")) == (
        (SignalLiteral("z"), SignalLiteral("a"), SignalLiteral("m", negated=True)),
        (SignalLiteral("z"), SignalLiteral("m")),
    )


@given(clauses())
def test_is_equivalent_simplified_and_over_the_same_signals(clause: Clause) -> None:
    form = to_cnf(parse(clause.text))
    for values in assignments(NAMES):
        holds = all(any(values[name] is not negated for name, negated, _ in literals) for literals in form)
        assert holds is clause.holds(values)
    for literals in form:
        names = [literal.signal for literal in literals]
        assert len(set(names)) == len(names)
    for left, right in itertools.permutations(form, 2):
        assert not set(left) <= set(right)


def test_takes_forms_up_to_the_limit() -> None:
    pairs = [f"x{i} & y{i}" for i in range(12)]
    assert len(to_cnf(parse(" | ".join(pairs)))) == MAX_DISJUNCTIONS


@pytest.mark.long
@pytest.mark.parametrize(
    "text",
    [
        " | ".join(f"x{i} & y{i}" for i in range(13)),
        " | ".join(f"x{i} & y{i} & z{i % 7}" for i in range(2000)),
        " <-> ".join(f"x{i}" for i in range(90)),
        " & ".join(f"x{i}" for i in range(MAX_DISJUNCTIONS + 1)),
        " | ".join(f"({'&'.join(f'x{(i + 1) * (j + 1) % 97}' for j in range(20))})" for i in range(700)),
    ],
)
def test_stops_before_a_form_grows_too_large(text: str) -> None:
    start = time.process_time()
    with pytest.raises(ClauseError, match="limit 4096 disjunctions"):
        to_cnf(parse(text))
    assert time.process_time() - start < 20


def test_refuses_a_tree_that_is_too_deep() -> None:
    tree = Not(Signal("a"))
    for _ in range(200):
        tree = Not(tree)
    with pytest.raises(ClauseError, match="nests 201 operators"):
        to_cnf(tree)
