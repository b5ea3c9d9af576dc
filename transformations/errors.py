"""Faults in rules, found when the module that holds the rule is imported."""

from __future__ import annotations

import sys

from dineros.metamodel.errors import DinerosError, Location

_LANGUAGE = {
    f"dineros.transformations.{module}"
    for module in ("errors", "expressions", "functions", "patterns", "creation", "rule", "notation")
}


class RuleError(DinerosError):
    """A rule that cannot be right: unknown feature, wrong type, missing container, dangling lookup."""


class UnknownRoleError(RuleError, AttributeError):
    """A lookup of a role that the rule does not have."""


class CertificateError(DinerosError):
    """A flattened net lacks a place invariant that its rules guarantee: a fault in a rule."""


def rule_line() -> Location:
    """Return the file and line of the rule being written: the innermost frame outside the rule language."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__") in _LANGUAGE:
        frame = frame.f_back
    return Location(frame.f_code.co_filename, frame.f_lineno)
