"""Speeds up the start of the engines for commands that often answer within a second."""

from __future__ import annotations

import gc
import os
import sys
from importlib import import_module
from pathlib import Path
from types import ModuleType

from dineros.metamodel.files import require_file

#: Objects made between two looks for garbage: more than imports and the flattening of an ordinary model make.
#: The default of 700 looks hundreds of times meanwhile, and each look at 100 000 takes 50 ms.
OBJECTS_BETWEEN_COLLECTIONS = 400_000
#: What Numba imports only to find out whether it is there, and what no kernel uses: linear algebra, functions
#: of C libraries, the measurement of tests.
UNUSED = ("scipy", "scipy.linalg", "cffi", "coverage")
#: What Numba and pyecore import for what no command uses: extensions of Numba, and models at web addresses.
RARE = ("importlib.metadata", "urllib.request")
#: What cached kernels name as the source of their arrays, and what only compilation uses.
FOR_COMPILATION = "numba.np.arrayobj"
#: Numba asks of each kind of array whether it is one of these. Commands make none.
MASKED_ARRAYS, MASKED_ARRAY, ASKS = "numpy.ma", "MaskedArray", "numba.core.typing.typeof"
#: What NumPy imports only to write docstrings.
DOCSTRINGS = ("numpy._core._add_newdocs", "numpy._core._add_newdocs_scalars")
#: Numba reads this file of the current folder, for which it needs YAML.
NUMBA_SETTINGS = Path(".numba_config.yaml")
#: The threads of NumPy's linear algebra start, and spin, as soon as it is imported.
THREADS = "OPENBLAS_NUM_THREADS"


def start_quickly(model: Path | None = None) -> None:
    """Import the run time of the compiler without parts that the engines never use, which halves its time.

    During this import, some packages appear to be absent. This is for the command line, which owns its
    process; the library leaves it to the caller.

    Raises
    ------
    ModelFileError
        The file does not exist. In this case, nothing is imported.
    """
    if model is not None:
        require_file(model)
    gc.set_threshold(OBJECTS_BETWEEN_COLLECTIONS, 20, 20)
    if "numba" in sys.modules:
        return
    for name in RARE:
        _import_when_used(name)
    unused = UNUSED if NUMBA_SETTINGS.exists() else (*UNUSED, "yaml")
    hidden = [name for name in unused if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]
    for name in DOCSTRINGS:
        sys.modules.setdefault(name, ModuleType(name))
    is_set = THREADS in os.environ
    os.environ.setdefault(THREADS, "1")
    try:
        import numba.core.typing.cffi_utils  # noqa: F401

        # Else the first kernel looks for extensions of Numba in every installed package.
        sys.modules["numba.core.entrypoints"].__dict__["_already_initialized"] = True
        _import_when_used(FOR_COMPILATION)
        _import_when_used(MASKED_ARRAYS)
    finally:
        if not is_set:
            del os.environ[THREADS]
        for name in hidden:
            del sys.modules[name]


class _NoArray:
    """A class without objects."""


def _import_when_used(name: str) -> None:
    """Import a module of a package at the first use of one of its attributes."""
    if name in sys.modules:
        return
    stand_in = ModuleType(name)

    def attribute(wanted: str) -> object:
        if wanted == MASKED_ARRAY and sys._getframe(1).f_globals.get("__name__") == ASKS:
            return _NoArray
        if sys.modules.get(name) is stand_in:
            del sys.modules[name]
        return getattr(import_module(name), wanted)

    stand_in.__dict__["__getattr__"] = attribute
    sys.modules[name] = stand_in
    package, _, short = name.rpartition(".")
    setattr(import_module(package), short, stand_in)
