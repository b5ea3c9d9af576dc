"""TINA of LAAS as an engine, if it is on the PATH: counting, reachability, LTL.

The net goes out as a ``.net`` file; ``tina``, ``sift``, ``selt`` and ``pathto`` are run on it, and what they
print is read back. The programs and their output are used as TINA's manual describes them; this project has
no copy of TINA to try it with. Unreadable output raises a `TinaError`; it is never guessed.

References
----------
B. Berthomieu, P.-O. Ribet, F. Vernadat, *The tool TINA: construction of abstract state spaces for Petri nets
and time Petri nets*, International Journal of Production Research 42(14), 2004. Manual pages ``tina``,
``sift``, ``selt``, ``pathto`` and ``formats`` of TINA 3.7.
"""

from dineros.analysis.tina.digest import TinaCounts, count, read_digest
from dineros.analysis.tina.programs import TinaBudgetError, TinaError, tool
from dineros.analysis.tina.questions import find_enabled, find_marking, verify
from dineros.analysis.tina.state_classes import count_classes

__all__ = [
    "TinaBudgetError",
    "TinaCounts",
    "TinaError",
    "count",
    "count_classes",
    "find_enabled",
    "find_marking",
    "read_digest",
    "tool",
    "verify",
]
