"""``dineros validate``: all constraints of the metamodels."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from dineros.cli.console import say, say_json, summarise, warn
from dineros.cli.models import load_named, violations_of
from dineros.cli.options import flag, json_option, model_argument, settings_option
from dineros.cli.supervising import reading_command
from dineros.metamodel.errors import counted
from dineros.metamodel.files.remarks import remarks_of

if TYPE_CHECKING:
    from dineros.metamodel.constraints import Violation

STYLES = {"error": "red", "warning": "yellow"}


@reading_command(
    "dineros validate sorting.sym.xmi",
    "dineros validate sorting.sym.xmi --set 'TStop.clause=Danger & !RobotIsIdle' --json",
    "dineros validate --list",
)
@model_argument(required=False)
@settings_option
@flag("--strict", "Count warnings as violations.")
@flag("--list", "List the constraints instead of checking them.", into="list_constraints")
@json_option
def validate(
    model: Path | None, settings: tuple[str, ...], strict: bool, list_constraints: bool, as_json: bool
) -> int:
    """Check a model against all constraints.

    Prints each violation with its element, a fix and the name of the constraint. The exit status is 1 if
    there is an error (with --strict: or a warning), 2 if MODEL cannot be read.
    """
    if list_constraints:
        return _list(as_json)
    if model is None:
        raise click.MissingParameter(param_hint="'MODEL'", param_type="argument")
    from dineros.metamodel.errors import CollectedModelFileError

    try:
        net = load_named(model, settings)
    except CollectedModelFileError as found:
        for error in found.errors:
            warn(str(error))
        return 2
    violations = violations_of(net)
    errors = sum(violation.severity == "error" for violation in violations)
    warnings = len(violations) - errors
    if as_json:
        say_json(
            {
                "model": str(model),
                "errors": errors,
                "warnings": warnings,
                **({"notes": list(remarks)} if (remarks := remarks_of(net)) else {}),
                "violations": [_as_json(violation) for violation in violations],
            }
        )
    else:
        for violation in violations:
            say(_line(violation, model), STYLES[violation.severity])
        counts = f"{counted(errors, 'error')}, {counted(warnings, 'warning')}"
        summarise(f"{model}: {counts if violations else 'valid'}", None if violations else "green")
    return 1 if errors or (strict and warnings) else 0


def _line(violation: Violation, model: Path) -> str:
    where = str(violation.location or "") or str(model)
    fix = f" ({violation.fix})" if violation.fix else ""
    return f"{where}: {violation.severity}: {violation.message}{fix} [{violation.constraint}]"


def _as_json(violation: Violation) -> dict[str, Any]:
    location = violation.location
    return {
        "constraint": violation.constraint,
        "severity": violation.severity,
        "element": getattr(violation.element, "id", None),
        "message": violation.message,
        "fix": violation.fix,
        "file": str(location.file) if location and location.file else None,
        "line": location.line if location else None,
    }


def _list(as_json: bool) -> int:
    from dineros.metamodel.constraints import CONSTRAINTS

    rows = [
        {
            "constraint": constraint.name,
            "severity": constraint.severity,
            "about": constraint.about.__name__,
            "says": constraint.says,
        }
        for constraint in CONSTRAINTS
    ]
    if as_json:
        say_json({"constraints": rows})
        return 0
    width = max(len(row["constraint"]) for row in rows)
    for row in rows:
        say(f"{row['constraint']:{width}}  {row['severity']:7}  {row['says']}")
    return 0
