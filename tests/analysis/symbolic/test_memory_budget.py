"""The symbolic engine stays within its memory, measured by the peak of a process."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

#: What the engine's own Python objects, page granularity and the trials of the order search may add.
MARGIN = 32 << 20

SCRIPT = """
import json, sys
from dineros.analysis.nets.memory import peak_memory
from dineros.analysis.answers.budget import Budget
from dineros.analysis.symbolic.engine import symbolic_state_space
from tests.analysis import classic_nets as classic
from tests.analysis.reference_case_study import reference_case_study
warm = symbolic_state_space(classic.kanban(2))
warm.deadlocks(), warm.arcs(), warm.largest_total()
net = reference_case_study((int(sys.argv[2]),) * 3, "io")
before = peak_memory()
space = symbolic_state_space(net, Budget(int(sys.argv[1])))
if space.complete:
    space.deadlocks(), space.arcs(), space.largest_total()
after = peak_memory()
print(json.dumps([space.complete, space.reason, after - before]))
"""


@pytest.mark.long
@pytest.mark.parametrize(("memory", "objects", "complete"), [(1 << 20, 6, False), (16 << 20, 3, True)])
def test_peak_memory(memory: int, objects: int, complete: bool) -> None:
    command = [sys.executable, "-c", SCRIPT, str(memory), str(objects)]
    run = subprocess.run(command, capture_output=True, text=True, timeout=300, check=True)
    finished, reason, peak = json.loads(run.stdout)
    assert (finished, reason) == (complete, "" if complete else "memory")
    assert peak <= memory + MARGIN
