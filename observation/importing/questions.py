"""Writes facts missing in a source as a file for users to complete: initially, all lines are comments."""

from __future__ import annotations

from itertools import groupby
from pathlib import Path

from dineros.observation.importing.building import Imported
from dineros.observation.systems import ObservedSystem


def to_be_given(imported: Imported, system: ObservedSystem, model: Path) -> str:
    """Return the text of a file of given facts that contains only comments.

    Parameters
    ----------
    imported : Imported
        The import with its assumptions.
    model : Path
        The file of the model.
    """
    lines = [
        f"# Facts about {model.name} that a graph or a recording does not show. Each line has the assumed "
        "value.",
        "# Remove the # of a line and of its [table], write what is true, and import again.",
        "# The actions of a callback, in order, as ['call /pose', 'publish /map ?', 'publish /log *']:",
        "# once, once or not at all (?), any number of times (*). Without an entry, the order is unknown.",
    ]
    for node, found in groupby(imported.assumed, key=lambda each: each.node):
        lines += ["", f'# [node."{node}"]']
        values = {each.key: each.value for each in found}
        lines += [f"# {key} = {value}" for key, value in values.items()]
    kinds = (
        ("topic", system.topics, ("publishers", "subscribers")),
        ("service", system.services, ("servers", "clients")),
    )
    for kind, recorded, ends in kinds:
        for each in recorded:
            if each.name in imported.recorded:
                lines += ["", f'# [{kind}."{each.name}"]', *(f"# {end} = []" for end in ends)]
    return "\n".join(lines) + "\n"
