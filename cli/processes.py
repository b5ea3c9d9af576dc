"""The command line as a process of its own, for programs of this package that let others do their work."""

from __future__ import annotations

import os
import sys

_MAIN = """\
from dineros.analysis.answers.processes import die_with
die_with({parent})
from dineros.cli.main import main
main()
"""


def own_program() -> list[str]:
    """Return what begins the command line of a process that runs ``dineros`` and ends with this one.

    Modules in the folder where it is started do not stand in for those that are installed.
    """
    return [sys.executable, "-P", "-c", _MAIN.format(parent=os.getpid())]
