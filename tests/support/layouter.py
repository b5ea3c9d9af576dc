"""The layouter in tests: with ``DINEROS_LAYOUTER=dies`` in the environment it is killed at every use."""

from __future__ import annotations

import os

import pytest

from dineros.views.javascript.server import DIES

VARIABLE = DIES
LINE = "the layouter ended (SIGSEGV)\n"
"""How the line ends that says so."""

dies = os.environ.get(VARIABLE) == "dies"
needs_layouter = pytest.mark.skipif(
    dies, reason=f"{VARIABLE}=dies: the test is about what ELK or the pages' scripts draw"
)


def without_line(text: str) -> str:
    """Return what a command printed; where the layouter dies, without the line that says so."""
    return "".join(line for line in text.splitlines(keepends=True) if not (dies and line.endswith(LINE)))
