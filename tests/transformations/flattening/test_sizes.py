"""What rules would make is counted before it is made."""

from __future__ import annotations

import pytest

from dineros.metamodel.limits import VARIABLE, SizeLimitError
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.language import creation
from tests.support.broken.small import system


def test_a_rule_that_would_make_too_much_makes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def copied(*_: object, **__: object) -> None:
        raise AssertionError("it was made")

    monkeypatch.setattr(creation, "deep_copy", copied)
    small = system()
    small["ask"].instances = 2**31 - 1
    with pytest.raises(SizeLimitError, match="with S4, the rules create more than 200000 elements"):
        flatten(small.net)


def test_every_element_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    small = system()
    flat = flatten(small.net).net
    made = len(flat.pages[0].objects) + len(flat.pages[0].arcs)
    monkeypatch.setenv(VARIABLE, f"elements={2 * made}")
    flatten(small.net)
    monkeypatch.setenv(VARIABLE, f"elements={made // 3}")
    with pytest.raises(SizeLimitError, match="the rules create more than"):
        flatten(small.net)
