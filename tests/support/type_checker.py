"""Mypy as developers of a generated workspace run it: after `make install`, without any configuration."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CACHE = ROOT / ".mypy_cache/generated"
VARIABLES = ("MYPYPATH", "PYTHONPATH", "MYPY_CONFIG_FILE_DIR")


def strict_mypy(workspace: Path, *paths: str) -> str:
    """Return what ``mypy --strict`` says of some paths of a workspace."""
    plain = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    command = [sys.executable, "-m", "mypy", "--strict", "--cache-dir", str(CACHE), *paths]
    done = subprocess.run(command, cwd=workspace, env=plain, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr
