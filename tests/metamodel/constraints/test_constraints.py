from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given

from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import CONSTRAINTS, Violation, all_constraints, validate
from dineros.metamodel.constraints.listing import limits_table, table
from dineros.metamodel.errors import Location
from dineros.metamodel.positions import remember
from tests.support.broken import CASES, small
from tests.support.broken.cases import Case
from tests.support.systems.models import plain_nets, system_models


@pytest.mark.parametrize("make", [small.plain, small.system, small.runtime, small.flat])
def test_small_models_are_valid(make: Callable[[], small.Small]) -> None:
    assert validate(make().net) == []


@pytest.mark.long
@pytest.mark.parametrize("case", CASES, ids=str)
def test_breaks_exactly_one_constraint(case: Case) -> None:
    broken = case.make()
    case.break_(broken)
    violations = validate(broken.net)
    assert [(violation.constraint, violation.message, violation.fix) for violation in violations] == [
        (case.constraint, case.message, case.fix)
    ]
    declared = {constraint.name: constraint for constraint in all_constraints()}[case.constraint]
    assert violations[0].severity == declared.severity
    assert isinstance(violations[0].element, declared.about)


def test_every_constraint_has_a_case_that_breaks_it() -> None:
    assert {constraint.name for constraint in all_constraints()} == {case.constraint for case in CASES}


def test_names_are_unique_and_every_part_is_there() -> None:
    names = [constraint.name for constraint in CONSTRAINTS]
    assert len(set(names)) == len(names)
    for constraint in CONSTRAINTS:
        assert constraint.says.endswith(".")
        assert constraint.message
        assert constraint.fix
        assert constraint.severity in ("error", "warning")


def test_the_guide_lists_all_constraints() -> None:
    page = Path(__file__).parents[3] / "docs" / "constraints.md"
    assert page.read_text(encoding="utf-8").endswith(f"\n\n{table()}")
    assert f"\n\n{limits_table()}\n" in page.read_text(encoding="utf-8")


@pytest.mark.long
@given(system_models(with_properties=True))
def test_valid_system_models_have_no_errors(model: sym.SystemModel) -> None:
    assert [violation for violation in validate(model) if violation.severity == "error"] == []


@given(plain_nets())
def test_valid_plain_nets_have_no_errors(net: pn.Net) -> None:
    assert [violation for violation in validate(net) if violation.severity == "error"] == []


def test_violations_come_in_model_order() -> None:
    broken = small.system()
    broken["ask"].instances = 0
    broken["Exit"].tokens = -1
    broken["Idle-Talk"].weight = 0
    broken["talker"].threads = 0
    assert [violation.constraint for violation in validate(broken.net)] == [
        "threads-positive",
        "arc-weight",
        "tokens-not-negative",
        "service-instances",
    ]


def test_a_violation_is_one_line_with_file_and_line() -> None:
    broken = small.system()
    broken["Idle-Talk"].weight = 0
    remember(broken["Idle-Talk"], Location("talk.xmi", 7))
    (violation,) = validate(broken.net)
    assert str(violation) == "talk.xmi:7: arc 'Idle-Talk' has the weight 0 (give it a weight of 1 or more)"


def test_a_part_stands_where_its_container_does() -> None:
    broken = small.system()
    broken["chatter"].publishers[0].limit = 0
    remember(broken["chatter"], Location("talk.xmi", 9))
    (violation,) = validate(broken.net)
    assert violation.location == Location("talk.xmi", 9)


def test_a_violation_without_file_has_no_place() -> None:
    violation = Violation("arc-weight", "error", pn.Arc(id="a"), "arc 'a' is wrong", "fix it")
    assert str(violation) == "arc 'a' is wrong (fix it)"


def test_names_with_line_breaks_and_braces_stay_on_one_line() -> None:
    broken = small.plain()
    broken["p"].id = "{p}\n"
    assert [str(violation) for violation in validate(broken.net)] == [
        "place '{p}\\n' has white space in its id (write the id without blanks, and put the readable text "
        "into the name)"
    ]


def test_an_incomplete_element_is_checked_no_further() -> None:
    broken = small.plain()
    broken["p-t"].source = None
    broken["p-t"].weight = -1
    assert [violation.constraint for violation in validate(broken.net)] == ["required-feature"]
