"""The layouter in tests: with ``DINEROS_LAYOUTER=dies`` in the environment it is killed at every use."""

from __future__ import annotations

from dineros.views.javascript.server import DIES

VARIABLE = DIES
LINE = "the layouter ended (SIGSEGV)\n"
"""How the line ends that says so."""
