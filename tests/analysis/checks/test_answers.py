"""A public report with answers that say success or failure (ros-controls/ros2_control#2071)."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Overflow
from dineros.analysis.checks.properties import Properties
from dineros.analysis.checks.question import Checked
from tests.support.ros2_systems.late_answers import late_configure


def test_a_request_that_is_served_late_makes_the_next_one_fail() -> None:
    report = check(late_configure())
    assert {each.rule for each in report.findings if each.severity == "error"} == {"property-violated"}
    (found,) = (each for each in report.findings if each.rule == "property-violated")
    assert found.witness is not None
    text = " / ".join(str(each.to_dict()) for each in found.witness.steps)
    assert "gives up waiting" in text
    assert "answers client spawner (success=false)" in text


@pytest.mark.parametrize("timeout", [None, 10.0])
def test_its_remedies_are_proved(timeout: float | None) -> None:
    """A server that says yes once it is configured, or a client that waits as long as it takes."""
    report = check(late_configure(idempotent=timeout is not None, timeout=timeout))
    assert not report.unknown
    assert not [each for each in report.findings if each.severity == "error"]
    assert not [each for each in report.findings if "comes in time" in each.message], "answers come"


def test_properties_come_before_other_questions_once_all_markings_are_there(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """On a busy machine, the first short while decides nothing; then the diagram of all markings does."""
    model, told = late_configure(), list[set[str]]()
    ask_first, ask = Properties.ask_first, Overflow.ask
    rounds = iter([False, True])

    def ask_first_in_vain(self: Properties, checked: Checked) -> None:
        if next(rounds):
            ask_first(self, checked)

    def ask_overflow(self: Overflow, checked: Checked) -> None:
        told.append(set(checked.told))
        ask(self, checked)

    monkeypatch.setattr(Properties, "ask_first", ask_first_in_vain)
    monkeypatch.setattr(Overflow, "ask", ask_overflow)
    report = check(model)
    assert report.space is not None
    (known,) = told
    assert {f"property {each.id}" for each in model.properties} <= known
