"""Modules that have moved into a folder of their package are still found under their former names."""

from __future__ import annotations

import importlib
import sys
import warnings
from collections.abc import Mapping, Sequence
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:  # at run time it costs every command some milliseconds
    from importlib.abc import Loader


def find_moved(package: str, renamed: Mapping[str, str] | None = None) -> None:
    """Let imports of modules that a package had before find them where they are now, with a warning.

    Parameters
    ----------
    package : str
        Such as ``dineros.analysis``, or a package inside of it.
    renamed : mapping of str to str, optional
        Former name -> present one, of those that have another last part now, or another package: both without
        the package's name, the present one whole where it begins with ``dineros.``.
    """
    sys.meta_path.append(_Finder(package, renamed or {}))


class _Finder:
    """Asked after all others, so that it only sees names that nothing has any more."""

    def __init__(self, package: str, renamed: Mapping[str, str]) -> None:
        self._package = package
        self._renamed = renamed

    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        package, _, name = fullname.rpartition(".")
        if package != self._package or path is None:
            return None
        here = self._renamed.get(name) or _inside(path, name)
        loader = _Moved(here if here.startswith("dineros.") else f"{package}.{here}") if here else None
        return ModuleSpec(fullname, cast("Loader", loader)) if loader else None


def _inside(path: Sequence[str], name: str) -> str | None:
    """Return where below a package there is a module of this name, if there is just one."""
    if not name.isidentifier():  # it becomes a pattern of file names
        return None
    found = [
        ".".join(file.relative_to(folder).with_suffix("").parts)
        for folder in path
        for file in Path(folder).glob(f"**/{name}.py")
    ]
    return found[0] if len(found) == 1 else None


class _Moved:
    """Loads a module that is there under another name."""

    def __init__(self, present: str) -> None:
        self._present = present

    def create_module(self, spec: ModuleSpec) -> None:
        """Make none: there is one."""

    def exec_module(self, module: ModuleType) -> None:
        """Put the module that there is in the place of the new one."""
        text = f"{module.__name__} is {self._present} now"
        warnings.warn(text, DeprecationWarning, stacklevel=2)
        sys.modules[module.__name__] = importlib.import_module(self._present)
