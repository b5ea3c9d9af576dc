"""Walks of small nets start soon: their cached kernels import little."""

from __future__ import annotations

import subprocess
import sys

PROGRAM = """
import sys
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.walks.scouting import Scout
scout = Scout(CompiledNet.build({"idle": 1, "busy": 0}, [("start", {"idle": 1}, {"busy": 1})]))
modules = [name for name in ("scipy.linalg", "numba.np.arraymath") if name in sys.modules]
print(scout.walk(), scout.ways, modules)
"""


def test_cached_kernels_of_walks_import_no_scipy() -> None:
    runs = [
        subprocess.run([sys.executable, "-c", PROGRAM], capture_output=True, text=True, check=True)
        for _ in range(2)  # the first one may compile them
    ]
    assert runs[1].stdout == "True {0: (0,)} []\n"
