"""Properties that models store: asked under assumptions, by `check` too; which are refused, and how."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.requirements.patterns import Reading
from dineros.analysis.requirements.stored import asked, property_named
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from tests.support.systems.door import ask, door


def status(property: sym.Property) -> str:
    return asked(property).answer(Budget()).status


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("always Closed + Opened + Jammed == 1", "holds"),
        ("never Jammed >= 1", "violated"),
        ("fired(Open) leads to Closed >= 1", "violated"),
        ("fired(Close) only after fired(Open)", "holds"),
        ("at most once fired(Open)", "violated"),
        ("after fired(Jam) until fired(Free): never fired(Close)", "holds"),
        ("Jammed >= 1 is possible", "holds"),
        ("Jammed >= 2 is possible", "violated"),
        ("fired(Free) is possible", "holds"),
        ("Closed >= 1 stays possible", "holds"),
        ("Closed >= 2 stays possible", "violated"),
    ],
)
def test_words(text: str, expected: str) -> None:
    assert status(ask(door(), text)) == expected


def test_what_is_possible_is_shown_by_a_run() -> None:
    answer = asked(property := ask(door(), "fired(Free) is possible")).answer(Budget())
    subject = asked(property).subject
    names = [subject.net.transitions[t] for t in [*answer.stem, *answer.loop]]
    assert "Free" in names and answer.status == "holds"


def test_formulas() -> None:
    assert status(ask(door(), "G F fired(Open)", language="ltl")) == "violated"
    assert status(ask(door(), "EF AG Jammed == 0", language="ctl")) == "violated"


def test_fairness() -> None:
    model = door()
    property = ask(model, "fired(Open) leads to Closed >= 1")
    model.assumptions.append(fair := sym.Fairness(id="fair", of="Close"))
    assert status(property) == "violated"  # opened and jammed by turns: never enabled all the time
    fair.strong = True
    assert status(property) == "holds"


def test_branching_time_under_fairness() -> None:
    model = door()
    model.assumptions.append(sym.Fairness(id="fair", of="all"))
    assert status(ask(model, "Closed >= 1 stays possible")) == "holds"
    with pytest.raises(FormulaError, match="fair runs"):
        asked(ask(model, "AF Opened >= 1", language="ctl"))


def test_exclusive_signals() -> None:
    model = door()
    both = "signal(Button) and signal(Calm)"
    property = ask(model, f"never ({both})", signals="fullyEnabled")
    possible = ask(model, f"{both} is possible", signals="fullyEnabled")
    stays = ask(model, "Closed >= 1 stays possible", signals="fullyEnabled")
    assert [status(property), status(possible)] == ["violated", "holds"]
    signals = model.pages[0].signals  # type: ignore[attr-defined]
    model.assumptions.append(sym.ExclusiveSignals(id="apart", signals=list(signals)))
    assert [status(property), status(possible)] == ["holds", "violated"]
    with pytest.raises(FormulaError, match="exclusive signals"):
        asked(stays)
    assert status(ask(model, "Closed >= 1 stays possible")) == "holds"  # there are no signals


def test_signals_of_a_net_that_has_none() -> None:
    with pytest.raises(FormulaError):
        asked(ask(door(), "never signal(Button)"))


def test_a_column_is_one_of_the_whole_text() -> None:
    with pytest.raises(FormulaError, match="'Opend'") as caught:
        asked(ask(door(), "after fired(Open): never Opend >= 1"))
    assert caught.value.column == 26


def test_a_property_is_found_by_id_and_by_name() -> None:
    model = door()
    first, second = ask(model, "never Jammed >= 2"), ask(model, "never Jammed >= 1", name="no jam")
    assert property_named(model, "property0") is first
    assert property_named(model, "no jam") is second
    first.name = "no jam"
    with pytest.raises(FormulaError, match="2 properties are named 'no jam'"):
        property_named(model, "no jam")
    with pytest.raises(FormulaError, match="no property 'jam'"):
        property_named(model, "jam")


def test_a_formula_that_says_the_same() -> None:
    assert Reading("ltl", parse("G !(a >= 1)"), True).as_formula() == ("ctl", parse("EF a >= 1", "ctl"))
    assert Reading("ltl", parse("G !(a >= 1)")).as_formula() == ("ltl", parse("G !(a >= 1)"))


def test_a_check_asks_all_of_them() -> None:
    model = door()
    for text in ("never Jammed >= 1", "never Jammed >= 2", "never Jamed >= 2"):
        ask(model, text)
    ask(model, "never Opened >= 1", expected=False)
    ask(model, "never Opened >= 2", expected=False)
    report = check(model)
    found = {finding.elements[0]: finding for finding in report.findings}
    assert {name: finding.rule for name, finding in found.items()} == {
        "property0": "property-violated",
        "property2": "property-unreadable",
        "property4": "property-holds",
    }
    assert found["property0"].witness is not None and len(found["property0"].witness.steps) >= 2
    assert "property property1 holds: never Jammed >= 2" in report.proved
    assert "property property3 does not hold, as expected: never Opened >= 1" in report.proved
    assert "column 7: no place is named 'Jamed'" in found["property2"].message


def test_a_check_asks_them_where_there_is_no_state_space() -> None:
    """A net without bounds closes the questions about its markings, not those answered on the way."""
    model = door()
    node = model.pages[0]
    grown = sym.Place(id="Grown", page=node)
    flow(find(model, "Open", sym.Transition), grown)
    ask(model, "never Grown >= 3")
    report = check(model)
    assert "property-violated" in [finding.rule for finding in report.findings]


def test_what_is_not_known_stays_open() -> None:
    model = door()
    ask(model, "never Jammed >= 1")
    report = check(model, Budget(seconds=0.0))
    assert any("propert" in unknown.question for unknown in report.unknown)
