"""Workspaces of the applications in `examples`, with the handlers that their developers wrote."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from dineros.generators import Options, generate
from dineros.metamodel import sym
from dineros.metamodel.files import load

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


def system_model(path: Path) -> sym.SystemModel:
    """Return the model in a file."""
    model = load(path)
    assert isinstance(model, sym.SystemModel)
    return model


def workspace(folder: Path, model: Path, handlers: Mapping[str, Path]) -> Path:
    """Generate a workspace around handlers, given by their package."""
    generate(system_model(model), folder, Options(source=model.name))
    for package, file in handlers.items():
        shutil.copy(file, folder / "src" / package / package / "handlers.py")
    return folder


def dineros(*arguments: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    """Run a command of DiNeROS."""
    return subprocess.run(
        [sys.executable, "-P", "-m", "dineros.cli.main", *map(str, arguments)],
        cwd=cwd,
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        stdin=subprocess.DEVNULL,
        capture_output=True,
        text=True,
        check=False,
        timeout=500,
    )
