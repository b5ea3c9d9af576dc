import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel.clauses import (
    MAX_LENGTH,
    And,
    Constant,
    Equivalent,
    Expression,
    Implies,
    Not,
    Or,
    Signal,
    SignalIs,
    parse,
    signal_names,
)
from dineros.metamodel.errors import ClauseError
from tests.support.clauses import NAMES, Clause, assignments, clauses

a, b, c = Signal("a"), Signal("b"), Signal("c")


@pytest.mark.parametrize(
    ("text", "expression"),
    [
        ("a", a),
        ("!a & b", And((Not(a), b))),
        ("not a and b", And((Not(a), b))),
        ("¬a∧b", And((Not(a), b))),
        ("a&&b||c", Or((And((a, b)), c))),
        ("a or b and c", Or((a, And((b, c))))),
        ("a & b & c", And((a, b, c))),
        ("(a & b) & c", And((And((a, b)), c))),
        ("a->b", Implies(a, b)),
        ("a -> b -> c", Implies(a, Implies(b, c))),
        ("a<->b<->c", Equivalent(Equivalent(a, b), c)),
        ("a | b -> c <-> a", Equivalent(Implies(Or((a, b)), c), a)),
        ("true & !false", And((Constant(True), Not(Constant(False))))),
        ("left-arm.idle_1 | 2nd", Or((Signal("left-arm.idle_1"), Signal("2nd")))),
        (
            "android | oracle | nothing | trueish",
            Or(tuple(map(Signal, ["android", "oracle", "nothing", "trueish"]))),
        ),
        ("not-a", Signal("not-a")),
        ('"and" & "a b" & "\\"\\\\"', And((Signal("and"), Signal("a b"), Signal('"\\')))),
        ("((((a))))", a),
        ("a orb", Or((a, b))),
        ("or & and", And((Signal("or"), Signal("and")))),
        ("!\"a\" <> ' v' ∨ b='w'", Or((Not(Not(SignalIs("a", " v"))), SignalIs("b", "w")))),
        ("(a -> b) -> c <-> !(a | b)", Equivalent(Implies(Implies(a, b), c), Not(Or((a, b))))),
        ("a & b | b & c & a", Or((And((a, b)), And((b, c, a))))),
    ],
)
def test_reads(text: str, expression: Expression) -> None:
    assert parse(text) == expression


@pytest.mark.parametrize(
    ("text", "column", "message"),
    [
        ("", 1, "expected a signal, '!' or '(', found the end"),
        ("a & ", 5, "expected a signal, '!' or '(', found the end"),
        ("a & )", 5, "expected a signal, '!' or '(', found ')'"),
        ("(a", 3, "expected an operator or ')', found the end"),
        ("a)", 2, "expected an operator or the end, found ')'"),
        ("(a b", 4, "expected an operator or ')', found 'b' (put a name"),
        ("a # b", 3, "expected an operator, found '#'"),
        ("true = 'v'", 6, "expected an operator or the end, found '='"),
        ("a = b", 5, "expected a value in single quotes, found 'b'"),
        ("a b", 3, "found 'b' (put a name with blanks or special characters into double quotes)"),
        ("a-->b", 2, "found '-' (put a name with blanks or special characters into double quotes)"),
        ('a & "b', 5, "the quote that opens here is not closed"),
        ("a &\n & b", 2, "line 2, column 2: expected a signal, '!' or '(', found '&'"),
    ],
)
def test_says_where_a_text_is_wrong(text: str, column: int, message: str) -> None:
    with pytest.raises(ClauseError) as caught:
        parse(text)
    assert caught.value.column == column
    assert f"column {column}" in str(caught.value)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("(" * 100_000 + "a" + ")" * 100_000, f"200001 characters, more than {MAX_LENGTH}"),
        ("!" * 60_000 + "a", "nests 60000 operators, more than 100"),
        (" -> ".join(["a"] * 5000), "nests 4999 operators, more than 100"),
        ("(" * 60_000, "found the end"),
    ],
    ids=["parentheses", "negations", "implications", "open parentheses"],
)
def test_bounds_length_and_depth(text: str, message: str) -> None:
    with pytest.raises(ClauseError, match=message):
        parse(text)


def test_parentheses_alone_do_not_nest() -> None:
    assert parse("(" * 30_000 + "a" + ")" * 30_000) == a


def test_names_come_in_order_of_first_use() -> None:
    assert signal_names("c & !(a | c) -> b & a") == ["c", "a", "b"]
    assert signal_names("true") == []


@given(clauses())
def test_means_what_it_says(clause: Clause) -> None:
    expression = parse(clause.text)
    for values in assignments(NAMES):
        assert expression.evaluate(values) is clause.holds(values)


_signals = st.one_of(st.sampled_from(NAMES), st.text(max_size=4)).map(Signal)
_trees: st.SearchStrategy[Expression] = st.recursive(
    _signals | st.booleans().map(Constant),
    lambda trees: st.one_of(
        trees.map(Not),
        st.lists(trees, min_size=2, max_size=4).map(lambda parts: And(tuple(parts))),
        st.lists(trees, min_size=2, max_size=4).map(lambda parts: Or(tuple(parts))),
        st.tuples(trees, trees).map(lambda pair: Implies(*pair)),
        st.tuples(trees, trees).map(lambda pair: Equivalent(*pair)),
    ),
    max_leaves=12,
)


@given(_trees)
def test_reads_back_what_it_prints(tree: Expression) -> None:
    assert parse(str(tree)) == tree


@given(st.text(alphabet='ab&|!()-<>=" \\\n.∧∨¬→'))
def test_reads_any_text_or_says_what_is_wrong(text: str) -> None:
    try:
        expression = parse(text)
    except ClauseError as error:
        assert error.column is not None
        assert 1 <= error.column <= len(text) + 1
    else:
        assert parse(str(expression)) == expression
