"""What is hidden for the time of an import is there afterwards, and nothing of it was imported."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

PROGRAM = """
import os, sys
from importlib import import_module
from dineros.cli.quick_start import FOR_COMPILATION, RARE, THREADS, UNUSED, start_quickly

start_quickly()
start_quickly()
print(sorted({"numba", *UNUSED, "yaml"} & sys.modules.keys()), os.environ.get(THREADS))
import pyecore.resources
print([name for name in (*RARE, FOR_COMPILATION) if sys.modules[name].__spec__])
import importlib.metadata, urllib.request
print(len(importlib.metadata.version("numba")) > 1, urllib.request.Request.__name__)
for name in ("scipy.linalg", "cffi", "yaml"):
    import_module(name)
import numpy as np
from numba import njit, typeof
print(typeof(np.zeros(1)), sys.modules["numpy.ma"].__spec__)
masked = np.ma.masked_array([1, 2], [True, False])
print(isinstance(masked, np.ma.MaskedArray), masked.sum(), sys.modules["numpy.ma"].__spec__ is not None)
print(njit(lambda number: np.zeros(number).size + np.full(1, 1).sum() + 1)(40))
print(sys.modules[FOR_COMPILATION].__spec__ is not None)
"""


@pytest.mark.long
@pytest.mark.parametrize(
    ("threads", "settings", "seen"),
    [
        (None, None, "['numba'] None"),
        ("3", None, "['numba'] 3"),
        (None, "developer_mode: 0\n", "['numba', 'yaml'] None"),
    ],
)
def test_what_is_hidden_comes_back(
    tmp_path: Path, threads: str | None, settings: str | None, seen: str
) -> None:
    if settings is not None:
        (tmp_path / ".numba_config.yaml").write_text(settings)
    environment = {"PATH": "", "HOME": str(tmp_path)}
    if threads is not None:
        environment["OPENBLAS_NUM_THREADS"] = threads
    command = [sys.executable, "-P", "-c", PROGRAM]
    run = subprocess.run(command, capture_output=True, text=True, check=True, cwd=tmp_path, env=environment)
    arrays = ["array(float64, 1d, C) None", "True 2 True"]
    assert (run.stdout.splitlines(), run.stderr) == ([seen, "[]", "True Request", *arrays, "42", "True"], "")
