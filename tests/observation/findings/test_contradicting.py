"""Proofs on a model whose code never continues rest on an assumption, unless the model shows that, too."""

from __future__ import annotations

import pytest

from dineros.analysis.witnesses.findings import Finding, Report
from dineros.observation.findings.code import FAULTS
from dineros.observation.findings.contradicting import NEVER_CONTINUE, contradicted

PROVED = ["every callback that has begun can end", "no deadlock"]


def of_code(rule: str = "code-waits-for-itself") -> Finding:
    return Finding(rule, "error", ("slow", "on_data"), "callback on_data sleeps on its own thread")


def test_rules_are_errors_of_code() -> None:
    assert {FAULTS[rule].severity for rule in NEVER_CONTINUE} == {"error"}


@pytest.mark.parametrize("rule", sorted(NEVER_CONTINUE))
def test_proofs_become_assumed(rule: str) -> None:
    found = contradicted(Report(proved=list(PROVED), assumed=["other"]), [of_code(rule)])
    assert (found.proved, found.assumed) == ([], ["other", *PROVED])
    (unknown,) = found.unknown
    assert "the proofs assume that the code continues, but callback on_data sleeps" in str(unknown.reason)


@pytest.mark.parametrize("rule", ["callback-deadlock", "callback-never-ends"])
def test_a_model_that_shows_it_proves_the_rest(rule: str) -> None:
    report = Report(findings=[Finding(rule, "error", (), "a circle")], proved=list(PROVED))
    assert contradicted(report, [of_code()]).proved == PROVED


def test_other_faults_of_code_change_nothing() -> None:
    sleeps = Finding("code-sleeps", "warning", ("slow", "on_data"), "callback on_data sleeps 2 s")
    report = Report(proved=list(PROVED))
    assert contradicted(report, [sleeps]) == report
