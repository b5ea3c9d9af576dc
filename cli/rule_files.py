"""Reading a user's own rules: a Python file that lists them in ``RULES``."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from dineros.transformations.language.rule import Rule


def load_rules(path: Path) -> list[type[Rule]]:
    """Run a Python file and return its list ``RULES``.

    The file may import what stands beside it.

    Raises
    ------
    DinerosError
        The file cannot be read or run, or does not list rules; with the line in the file.
    """
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.transformations.language.rule import Rule

    module = _run(path)
    rules = getattr(module, "RULES", None)
    where = Location(path)
    if not isinstance(rules, (list, tuple)):
        raise DinerosError("has no list RULES", location=where, hint="end it with RULES = [MyRule]")
    for rule in rules:
        if not (isinstance(rule, type) and issubclass(rule, Rule)):
            raise DinerosError(
                f"RULES holds {rule!r}, which is no rule", location=where, hint="class MyRule(Rule)"
            )
    return list(rules)


def _run(path: Path) -> ModuleType:
    from dineros.metamodel.errors import DinerosError, Location
    from dineros.metamodel.files.reading import read_bytes

    source = read_bytes(path)
    module = ModuleType(f"rules in {path.name}")
    module.__file__ = str(path)
    # At the end: a `resource.py` beside the rules must not take the place of Python's.
    before = list(sys.path)
    sys.path.append(str(path.parent))
    try:
        exec(compile(source, str(path), "exec"), module.__dict__)
    except DinerosError:
        raise
    except SyntaxError as error:
        raise DinerosError(f"is no Python: {error.msg}", location=Location(path, error.lineno)) from error
    except Exception as error:
        lines = [
            frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
        ]
        text = f"{type(error).__name__}: {error}"
        raise DinerosError(text, location=Location(path, lines[-1] if lines else None)) from error
    finally:
        sys.path[:] = before
    return module
