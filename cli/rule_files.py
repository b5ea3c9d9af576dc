"""Reads rules of users: a Python file that lists them in ``RULES``."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dineros.transformations.language.rule import Rule


def load_rules(path: Path | None) -> list[type[Rule]]:
    """Run a Python file and return its list ``RULES``; without a file there are none.

    The file may import modules next to it.

    Raises
    ------
    DinerosError
        The file cannot be read or run, or does not list rules; with the line in the file.
    """
    if path is None:
        return []
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.files.programs import run_file
    from dineros.transformations.language.rule import Rule

    module = run_file(path, f"rules in {path.name}")
    rules = getattr(module, "RULES", None)
    where = Location(path)
    if not isinstance(rules, (list, tuple)):
        raise DinerosError("has no list RULES", location=where, hint="end it with RULES = [MyRule]")
    for rule in rules:
        if not (isinstance(rule, type) and issubclass(rule, Rule)):
            raise DinerosError(
                f"RULES holds {rule!r}, which is not a rule", location=where, hint="class MyRule(Rule)"
            )
    return list(rules)
