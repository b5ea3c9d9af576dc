"""Which faults are absent when a model is analysed again; rule and elements identify a fault."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.witnesses.findings import Finding, Report

Key = tuple[str, tuple[str, ...]]
"""Distinguishes a fault from others of a model: its rule and its elements."""


def key_of(finding: Finding) -> Key:
    """Return the key of a fault."""
    return finding.rule, finding.elements


def faults_of(report: Report) -> set[Key]:
    """Return the faults of a report, notes aside."""
    return {key_of(finding) for finding in report.findings if finding.severity != "note"}


def is_in(finding: Finding, some: Sequence[Finding]) -> bool:
    """Return whether a finding is one of some; equal ones are not."""
    return any(finding is each for each in some)


def gone_from(again: Report, some: Sequence[Finding], known: Sequence[Finding]) -> list[Finding]:
    """Return the faults that are known to be absent, or that a later report neither has nor leaves open."""
    still = faults_of(again)
    return [
        each
        for each in some
        if is_in(each, known) or (key_of(each) not in still and each.rule not in again.open_rules)
    ]
