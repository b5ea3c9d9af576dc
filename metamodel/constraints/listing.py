"""All constraints as a table for the guide; ``python -m dineros.metamodel.constraints.listing`` prints it."""

from __future__ import annotations

from collections.abc import Iterator

from dineros.metamodel.constraints import all_constraints
from dineros.metamodel.constraints.wording import words_for


def table() -> str:
    """Return a Markdown table of all constraints: name, about, severity and what each says."""
    return "\n".join(_rows()) + "\n"


def _rows() -> Iterator[str]:
    yield "| constraint | about | severity | says |"
    yield "|---|---|---|---|"
    for constraint in all_constraints():
        about = words_for(constraint.about)
        yield f"| `{constraint.name}` | {about} | {constraint.severity} | {constraint.says} |"


if __name__ == "__main__":
    print(table(), end="")
