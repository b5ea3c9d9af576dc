"""Prints which rule made an element of a flattened net, and what was made from an element of the model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from dineros.cli.console import say
from dineros.metamodel.errors import counted

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link
    from dineros.transformations.pictures.explaining import Explanation


def say_explanation(explanation: Explanation, id: str) -> None:
    """Print the sources of an element, and the elements made from it."""
    from dineros.transformations.pictures.explaining import origin_text, told
    from dineros.transformations.rules.catalogue import name_of

    origin, source, results = explanation.origin, explanation.source, explanation.results
    if origin is not None:
        say(f"{id}: {origin_text(origin)}")
    if source is None:
        return
    say(f"{told(source)}: {counted(len(results), 'element')} of the net made from it")
    rows = [(name_of(link.rule), link.role, link.target.id) for link in results]
    widths = [max((len(row[column]) for row in rows), default=0) for column in (0, 1)]
    for rule, role, target in rows:
        say(f"  {rule:{widths[0]}}  {role:{widths[1]}}  {target}")


def explained(explanation: Explanation, id: str) -> dict[str, Any]:
    """Return the same for JSON."""
    return {
        "id": id,
        "origin": _link(explanation.origin) if explanation.origin is not None else None,
        "source": type(explanation.source).__name__ if explanation.source is not None else None,
        "results": [_link(link) for link in explanation.results],
    }


def _link(link: Link) -> dict[str, Any]:
    from dineros.transformations.pictures.explaining import told

    return {
        "rule": link.rule,
        "role": link.role,
        "application": link.application,
        "instance": link.index,
        "sources": [told(source) for source in link.sources],
        "id": link.target.id,
        "class": type(link.target).__name__,
    }
