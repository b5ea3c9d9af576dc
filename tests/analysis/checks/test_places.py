"""What places of a place/transition net may hold: one-safe, stable, against a plain search."""

from __future__ import annotations

import pytest
from hypothesis import assume, given, settings

from dineros.analysis.checks.check import check
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import to_model
from dineros.analysis.witnesses.findings import Report
from tests.analysis.covering.plain import plain_search
from tests.analysis.strategies import nets
from tests.support.systems.talker import talker

ONE_SAFE = "the net is one-safe: no place ever holds more than one token"
CHANGES = "no marking is stable: the tokens of every place can change"
OPEN = "whether the net is one-safe, whether a marking is stable"


def places(report: Report, rule: str) -> set[str]:
    """Return the places that a note is about."""
    return {place for found in report.findings if found.rule == rule for place in found.elements}


@settings(max_examples=40, deadline=None)
@given(nets())
def test_all_markings_say_the_same(net: CompiledNet) -> None:
    seen = plain_search(net, 2_000)
    assume(seen.is_complete)
    report = check(to_model(net, "net"))
    columns = dict(zip(net.places, zip(*seen.markings, strict=True), strict=True))
    assert places(report, "not-one-safe") == {p for p, tokens in columns.items() if max(tokens) > 1}
    assert places(report, "stable-marking") == {p for p, tokens in columns.items() if len(set(tokens)) == 1}
    assert (ONE_SAFE in report.proved) == (not places(report, "not-one-safe"))
    assert (CHANGES in report.proved) == (not places(report, "stable-marking"))


@pytest.mark.long
@settings(max_examples=3, deadline=None)
@given(nets())
def test_without_an_end_of_markings_nothing_wrong_is_said(net: CompiledNet) -> None:
    seen = plain_search(net, 500)
    assume(not seen.is_complete)
    report = check(to_model(net, "net"))
    if ONE_SAFE in report.proved:
        assert all(max(marking) <= 1 for marking in seen.markings)
    if CHANGES in report.proved:
        assert not any(found.rule == "stable-marking" for found in report.findings)
    if any(found.rule == "stable-marking" for found in report.findings):
        assert any(len(set(column)) == 1 for column in zip(*seen.markings, strict=True))


@pytest.mark.parametrize("tokens", [1, 2])
def test_a_counter_that_nothing_takes_from(tokens: int) -> None:
    net = CompiledNet.build({"a": tokens, "b": 0}, [("t", {"a": 1}, {"a": 1, "b": 1})])
    report = check(to_model(net, "net"))
    assert {"not-one-safe", "stable-marking"} <= {found.rule for found in report.findings}
    assert OPEN not in {each.question for each in report.unknown}


def test_system_models_are_asked_about_queues_instead() -> None:
    report = check(talker())
    assert not {ONE_SAFE, CHANGES} & set(report.proved)
    assert not any(found.rule in ("not-one-safe", "stable-marking") for found in report.findings)
