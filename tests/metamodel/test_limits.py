"""Limits of sizes: what they are, how they are raised, and for which models they hold."""

import pytest

from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.limits import LIMITS, VARIABLE, most, raised
from tests.support.broken import small


def test_a_limit_is_what_the_environment_says(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv(VARIABLE, raising=False)
    assert most("instances") == LIMITS["instances"].most
    monkeypatch.setenv(VARIABLE, "tokens=7, instances=5000")
    assert (most("instances"), most("tokens"), most("length")) == (5000, 7, LIMITS["length"].most)


def test_later_limits_stand_for_earlier_ones(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "tokens=7,instances=5000")
    assert raised(("tokens=8", "length=9")) == "tokens=8,instances=5000,length=9"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("instance=5", "'instance=5' is not a limit of a size \\(did you mean 'instances'?"),
        ("instances", "for example instances=5000"),
        ("instances=-1", "for example instances=5000"),
        ("instances=" + "9" * 5000, "for example instances=5000"),
    ],
)
def test_what_is_no_limit_is_refused(text: str, says: str) -> None:
    with pytest.raises(DinerosError, match=says):
        raised((text,))


def test_a_raised_limit_lets_a_model_pass_with_a_warning(monkeypatch: pytest.MonkeyPatch) -> None:
    model = small.system()
    model["ask"].instances = 5000
    assert [violation.severity for violation in validate(model.net)] == ["error"]
    monkeypatch.setenv(VARIABLE, "instances=5000")
    assert [violation.severity for violation in validate(model.net)] == ["warning"]


def test_tokens_of_a_plain_net_are_a_number() -> None:
    model = small.plain()
    model["p"].tokens = 2**31 - 1
    model["p-t"].weight = 2**31 - 1
    assert validate(model.net) == []


def test_an_inhibitor_arc_moves_no_tokens() -> None:
    model = small.system()
    model["BusyHere-Talk-inhibitor"].weight = 2**31 - 1
    assert validate(model.net) == []
