from collections.abc import Iterator

import pytest
from hypothesis import given

from dineros.metamodel import pn, sym
from dineros.metamodel.clauses import cnf_text, evaluate, parse, remove_clause, set_clause, to_cnf
from dineros.metamodel.errors import ClauseError, UnknownElementError
from tests.support.clauses import NAMES, Clause, assignments, clauses


def transition_with(*names: str) -> sym.Transition:
    """Return a transition of a node net that has signals of these names."""
    node_net = sym.NodeNet(id="sensorics")
    node_net.signals.extend([sym.InputSignal(id=f"s{i}", name=name) for i, name in enumerate(names)])
    node_net.objects.append(inner := pn.Page(id="inner"))
    inner.objects.append(transition := sym.Transition(id="TSense"))
    return transition


def literals(clause: sym.InputClause) -> Iterator[sym.Literal]:
    for disjunction in clause.disjunctions:
        yield from disjunction.literals


def test_stores_text_name_and_normal_form() -> None:
    transition = transition_with("Sensor", "Danger")
    clause = set_clause(transition, "Sensor  ∧ (Danger → Sensor)", name="safe")
    assert transition.clause is clause
    assert (clause.name, clause.text) == ("safe", "Sensor  ∧ (Danger → Sensor)")
    assert cnf_text(clause) == "Sensor"
    assert [literal.signal.id for literal in literals(clause)] == ["s0"]


def test_calls_a_signal_without_name_by_its_id() -> None:
    transition = transition_with("Sensor")
    node_net = transition.page.page  # type: ignore[union-attr]
    node_net.signals.append(sym.InputSignal(id="Danger"))  # type: ignore[union-attr]
    assert cnf_text(set_clause(transition, "!Danger | Sensor")) == "!Danger | Sensor"


@pytest.mark.parametrize(
    ("text", "stored"),
    [
        ("Sensor & !Sensor", "Sensor & !Sensor"),
        ("true", "true"),
        ("false", "false"),
        ("(Sensor | Danger) & !Danger", "(Sensor | Danger) & !Danger"),
        ("Danger -> Sensor", "!Danger | Sensor"),
        ('"two words" & Sensor', '"two words" & Sensor'),
    ],
)
def test_prints_the_normal_form(text: str, stored: str) -> None:
    assert cnf_text(set_clause(transition_with("Sensor", "Danger", "two words"), text)) == stored


def test_prints_an_empty_disjunction_among_others() -> None:
    transition = transition_with("Sensor")
    clause = set_clause(transition, "Sensor")
    clause.disjunctions.append(sym.Disjunction())
    assert cnf_text(clause) == "Sensor & false"


@given(clauses())
def test_stored_form_means_what_the_text_says(clause: Clause) -> None:
    stored = set_clause(transition_with(*NAMES), clause.text)
    for values in assignments(NAMES):
        assert evaluate(stored, values) is clause.holds(values)
    assert {frozenset(part) for part in to_cnf(parse(cnf_text(stored)))} == {
        frozenset(part) for part in to_cnf(parse(clause.text))
    }


def test_a_new_clause_takes_the_place_of_the_old_one() -> None:
    transition = transition_with("Sensor", "Danger")
    node_net = transition.page.page  # type: ignore[union-attr]
    set_clause(transition, "Sensor & Danger")
    set_clause(transition, "Danger")
    assert [len(signal.literals) for signal in node_net.signals] == [0, 1]  # type: ignore[union-attr]
    remove_clause(transition)
    assert transition.clause is None
    assert [len(signal.literals) for signal in node_net.signals] == [0, 0]  # type: ignore[union-attr]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("Sensr", "the node net 'sensorics' has no signal 'Sensr' (did you mean 'Sensor'?)"),
        ("xyz", "the node net 'sensorics' has no signal 'xyz' (its signals are Sensor)"),
        ("Sensor &", "column 9: expected a signal"),
    ],
)
def test_after_an_error_nothing_has_changed(text: str, message: str) -> None:
    transition = transition_with("Sensor")
    before = set_clause(transition, "Sensor")
    with pytest.raises(ClauseError) as caught:
        set_clause(transition, text)
    assert message in str(caught.value)
    assert caught.value.element == "TSense"
    assert transition.clause is before


def test_a_transition_outside_of_node_nets_has_no_signals() -> None:
    transition = sym.Transition(id="free")
    with pytest.raises(ClauseError, match="'free' is not in a node net"):
        set_clause(transition, "Sensor")
    assert cnf_text(set_clause(transition, "true")) == "true"


def test_a_signal_without_value_is_named() -> None:
    clause = set_clause(transition_with("Sensor"), "Sensor")
    with pytest.raises(UnknownElementError, match="the signal 'Sensor' has no value"):
        evaluate(clause, {"Senso": True})
