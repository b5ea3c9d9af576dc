"""Speeds up the start of the engines for commands that often answer within a second."""

from __future__ import annotations

import gc
import os
import sys
from pathlib import Path

#: Objects made between two looks for garbage: more than imports and the flattening of an ordinary model make.
#: The default of 700 looks hundreds of times meanwhile, and each look at 100 000 takes 50 ms.
OBJECTS_BETWEEN_COLLECTIONS = 400_000
#: What Numba imports only to find out whether it is there, and what no kernel uses: linear algebra, functions
#: of C libraries, the measurement of tests.
UNUSED = ("scipy.linalg", "cffi", "coverage")
#: Numba reads this file of the current folder, for which it needs YAML.
NUMBA_SETTINGS = Path(".numba_config.yaml")
#: The threads of NumPy's linear algebra start, and spin, as soon as it is imported.
THREADS = "OPENBLAS_NUM_THREADS"


def start_quickly() -> None:
    """Import the run time of the compiler without parts that the engines never use, which halves its time.

    During this import, some packages appear to be absent. This is for the command line, which owns its
    process; the library leaves it to the caller.
    """
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, 20, 20)
    if "numba" in sys.modules:
        return
    unused = UNUSED if NUMBA_SETTINGS.exists() else (*UNUSED, "yaml")
    hidden = [name for name in unused if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    is_set = THREADS in os.environ
    os.environ.setdefault(THREADS, "1")
    try:
        import numba.core.typing.cffi_utils  # noqa: F401
    finally:
        if not is_set:
            del os.environ[THREADS]
        for name in hidden:
            del sys.modules[name]
