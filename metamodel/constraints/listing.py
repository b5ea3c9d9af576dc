"""Limits of sizes and all constraints, as tables for the guide.

``python -m dineros.metamodel.constraints.listing`` prints both.
"""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel.constraints import all_constraints
from dineros.metamodel.constraints.wording import words_for
from dineros.metamodel.limits import LIMITS


def table() -> str:
    """Return a Markdown table of all constraints: name, element, severity and statement."""
    return "\n".join(_rows()) + "\n"


def limits_table() -> str:
    """Return a Markdown table of the limits of sizes: name, of what, usual, limit."""
    head = ["| limit | of | warning above | error above |", "|---|---|---|---|"]
    rows = (
        f"| `{name}` | {of.says} | {'' if of.usual is None else format(of.usual, ',')} | {of.most:,} |"
        for name, of in LIMITS.items()
    )
    return "\n".join([*head, *rows]) + "\n"


def _rows() -> Iterator[str]:
    yield "| constraint | about | severity | says |"
    yield "|---|---|---|---|"
    for constraint in all_constraints():
        about = words_for(constraint.about)
        yield f"| `{constraint.name}` | {about} | {constraint.severity} | {constraint.says} |"


if __name__ == "__main__":
    print(limits_table(), table(), sep="\n", end="")
