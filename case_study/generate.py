"""The case study's workspace, made from its model around what its developers wrote.

The repository holds the developers' files only, and the manifest, which has the hash of every other file.
``python case_study/generate.py`` makes those; `make install` does it. If they would not be what the
manifest says, nothing is written: `make regenerate` (option ``--anew``) writes the manifest, too.
"""

from __future__ import annotations

import sys
from pathlib import Path

from dineros.generators import Comparison, Options, check, generate, read_manifest
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files import load
from dineros.metamodel.settings import apply

HOME = Path(__file__).resolve().parent
MODEL = HOME / "sorting.sym.xmi"
WORKSPACE = HOME / "workspace"
RULES = "middleware=ros2"
"""Its nodes run on ROS 2, whose queues are not those of the paper."""
OPTIONS = Options(MODEL.name, settings=(RULES,))


def compare() -> Comparison:
    """Return how the workspace differs from what it should hold.

    Raises
    ------
    DinerosError
        What is generated now is not what the manifest says.
    """
    comparison = check(model(), WORKSPACE, OPTIONS)
    if comparison.manifest != read_manifest(WORKSPACE):
        raise DinerosError(
            "is not what the model and the generators make now",
            location=Location(WORKSPACE),
            hint="make regenerate",
        )
    return comparison


def model() -> sym.SystemModel:
    found = load(MODEL)
    assert isinstance(found, sym.SystemModel)
    apply(found, RULES)
    return found


def main(anew: bool = False) -> int:
    """Make what is missing."""
    try:
        if anew or compare().changes:
            generate(model(), WORKSPACE, OPTIONS)
    except DinerosError as error:
        print(error, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main("--anew" in sys.argv[1:]))
