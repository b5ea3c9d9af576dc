"""A public report with answers that say success or failure (ros-controls/ros2_control#2071)."""

from __future__ import annotations

import pytest

from dineros.analysis.checks.check import check
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
