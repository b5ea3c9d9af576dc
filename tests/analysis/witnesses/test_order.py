"""Runs that need messages out of order say so."""

from __future__ import annotations

import pytest

from dineros.analysis.model.subject import subject_of
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.witnesses.witness import witness_of
from tests.transformations.flattening.test_guards import sends_in_order


@pytest.mark.parametrize("limit", [2, 1_000_000_000])
def test_a_run_that_needs_another_order_names_the_queue(limit: int) -> None:
    model, after, wrong = sends_in_order(limit)
    subject = subject_of(model, "none")
    possible = find_marking(subject.net, f"{after.id} >= 1", subject.names)
    assert possible.trace is not None
    ordered = witness_of(subject, possible.trace)
    assert ordered.disorder == "" and "disorder" not in ordered.to_dict()
    other = find_marking(subject.net, f"{wrong.id} >= 1", subject.names)
    if limit == 2:
        assert other.status == "unreachable"  # such a queue keeps the order
        return
    assert other.trace is not None
    found = witness_of(subject, other.trace)
    assert found.disorder == "reader history of P1 (topic /c)"
    assert found.to_dict()["disorder"] == found.disorder
