"""A quick start of the engines for commands that often answer in a second."""

from __future__ import annotations

import gc
import sys

#: Objects made between two looks for garbage; the default of 700 looks hundreds of times while importing.
OBJECTS_BETWEEN_COLLECTIONS = 100_000


def start_quickly() -> None:
    """Import the compiler's run time without what the engines never use.

    Numba imports all of SciPy's linear algebra, only to find out whether it is there: a quarter of a second.
    No kernel multiplies matrices, so for the time of that import it is made to look absent. This is for the
    command line, whose process is its own; the library leaves it to the caller.
    """
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, 20, 20)
    hidden = "scipy.linalg"
    if hidden in sys.modules or "numba.np.arraymath" in sys.modules:
        return
    sys.modules[hidden] = None  # type: ignore[assignment]
    try:
        import numba.np.arraymath  # noqa: F401
    finally:
        del sys.modules[hidden]
