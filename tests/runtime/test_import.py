"""The engine runs on a robot: it needs the metamodel and nothing of analysis, rules or big libraries."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from dineros.metamodel.files import save
from dineros.transformations.flattening.split import split
from tests.runtime.tiny import ROOT, case_study

PROGRAM = """
import sys
from pathlib import Path
import dineros.runtime, dineros.runtime.application.simulation
from dineros.runtime import Net
net = Net.load(sys.argv[1])
with net:
    net.inspect()
heavy = {"numpy", "numba", "scipy", "pyarrow", "jinja2", "click", "rich", "rclpy", "pysat"}
rooms = ("dineros.transformations", "dineros.analysis", "dineros.generators", "dineros.views", "dineros.cli")
print([name for name in sys.modules if name.split(".")[0] in heavy or name.startswith(rooms)])
"""


def test_importing_and_running_needs_the_metamodel_only(tmp_path: Path) -> None:
    path = tmp_path / "executor.rtm.xmi"
    save(next(node for node in split(case_study()) if node.node.id == "executor"), path)
    result = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(path)], capture_output=True, text=True, check=False, cwd=ROOT
    )
    assert (result.returncode, result.stdout.strip()) == (0, "[]"), result.stderr
