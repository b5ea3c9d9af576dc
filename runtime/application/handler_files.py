"""Python files with the handlers of an application, for runs without a generated workspace.

Such a file defines ``configure(net)``, which is called once for each node before it starts; ``net.id`` is the
id of the node. For runs in one process it may also define ``simulate(application)``, which is called before
that. It sets up the environment of the application, such as simulated machines that set signals
(`LocalApplication.every`).
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING

from dineros.metamodel.errors import DinerosError, Location, ModelFileError
from dineros.metamodel.files.reading import read_bytes

if TYPE_CHECKING:
    from dineros.runtime.application.simulation import LocalApplication
    from dineros.runtime.nodes.net import Net


class HandlerFileError(DinerosError):
    """A file with handlers cannot be loaded, or fails when it is used."""


@dataclass(frozen=True)
class HandlerFile:
    """A file with handlers."""

    path: Path
    module: ModuleType

    def configure(self, net: Net) -> None:
        """Register the handlers of a node.

        Raises
        ------
        HandlerFileError
            The function fails, for example because of an unknown transition.
        """
        self._call("configure", net)

    def simulate(self, application: LocalApplication) -> None:
        """Set up the environment of the application, if the file defines `simulate`.

        Raises
        ------
        HandlerFileError
            The function fails.
        """
        if hasattr(self.module, "simulate"):
            self._call("simulate", application)

    def _call(self, name: str, argument: object) -> None:
        function: Callable[[object], object] = getattr(self.module, name)
        try:
            function(argument)
        except Exception as error:
            raise _failure(self.path, error) from error


def load_handler_file(path: Path) -> HandlerFile:
    """Load a file with handlers; it can import modules next to it if their names are not taken.

    Raises
    ------
    HandlerFileError
        The file does not exist, fails, or does not define ``configure(net)``.
    """
    if path.suffix != ".py":
        raise HandlerFileError(
            "is not a Python file", location=Location(path), hint="name a file such as handlers.py"
        )
    try:
        source = read_bytes(path)
    except ModelFileError as error:
        raise HandlerFileError(error.message, location=error.location, hint=error.hint) from None
    path = path.resolve()
    module = ModuleType(f"dineros_handlers_{path.stem}")
    module.__file__ = str(path)
    sys.modules[module.__name__] = module
    # At the end: a `resource.py` next to the handlers must not hide Python's module from all other code.
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
    try:
        exec(compile(source, str(path), "exec"), module.__dict__)
    except Exception as error:
        raise _failure(path, error) from error
    if not callable(getattr(module, "configure", None)):
        raise HandlerFileError(
            "defines no function configure(net)",
            location=Location(path),
            hint="define it; it is called for each node, net.id says which",
        )
    return HandlerFile(path, module)


def _failure(path: Path, error: Exception) -> HandlerFileError:
    """Return an error with the innermost line of the file on the stack."""
    if isinstance(error, SyntaxError) and error.filename == str(path):
        return HandlerFileError(f"no Python: {error.msg}", location=Location(path, error.lineno))
    lines = [
        frame.lineno for frame in traceback.extract_tb(error.__traceback__) if frame.filename == str(path)
    ]
    said = str(error) if isinstance(error, DinerosError) else f"{type(error).__name__}: {error}"
    return HandlerFileError(said, location=Location(path, lines[-1] if lines else None))
