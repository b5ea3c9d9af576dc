"""Errors in rules, found when the module of a rule is imported."""

from __future__ import annotations

import sys

from dineros.metamodel.errors import DinerosError, Location

LANGUAGE = {
    f"{__package__}.{module}"
    for module in ("errors", "expressions", "functions", "patterns", "creation", "rule")
}
"""Modules that are skipped when locating an error, as rules call them; rule shorthands add theirs."""


class RuleError(DinerosError):
    """An invalid rule: unknown feature, wrong type, missing container, dangling lookup."""


class UnknownRoleError(RuleError, AttributeError):
    """A lookup of a role that the rule does not have."""


def rule_line() -> Location:
    """Return the file and line of the rule being written: the innermost frame outside the rule language."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__") in LANGUAGE:
        frame = frame.f_back
    return Location(frame.f_code.co_filename, frame.f_lineno)
