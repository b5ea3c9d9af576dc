"""The command line in a process of its own, whose memory is measured and may be limited."""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

# The peak that the system tells of a child starts from the size of the process that started it: a small one.
_STARTER = """
import json, os, resource, sys
limits, command = json.loads(sys.argv[1]), sys.argv[3:]
child = os.fork()
if child == 0:
    for limit, most in limits:
        resource.setrlimit(getattr(resource, limit), (most, most))
    os.execv(command[0], command)
_, status, usage = os.wait4(child, 0)
with open(sys.argv[2], "w", encoding="ascii") as file:
    json.dump([os.waitstatus_to_exitcode(status), usage.ru_maxrss * 1024], file)
"""


@dataclass(frozen=True)
class Ended:
    """How a command ended, and the most memory it had at a time."""

    exit_code: int
    stdout: str
    stderr: str
    peak_bytes: int


def run_apart(*arguments: object, limits: dict[str, int] | None = None) -> Ended:
    """Run ``dineros`` with arguments in a process of its own.

    Parameters
    ----------
    *arguments : object
        Of the command line.
    limits : dict of str to int, optional
        Limits of the process, such as ``RLIMIT_AS``.
    """
    command = [sys.executable, "-m", "dineros.cli.main", *map(str, arguments)]
    with tempfile.TemporaryDirectory() as folder:
        told = Path(folder) / "ended.json"
        starter = [sys.executable, "-S", "-c", _STARTER, json.dumps(list((limits or {}).items())), str(told)]
        run = subprocess.run([*starter, *command], capture_output=True, text=True, check=True, timeout=300)
        status, peak = json.loads(told.read_text(encoding="ascii"))
    return Ended(status, run.stdout, run.stderr, peak)
