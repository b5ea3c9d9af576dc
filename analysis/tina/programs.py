"""TINA's programs: where they are, and one run of one of them on files of a folder of its own."""

from __future__ import annotations

import os
import re
import resource
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from dineros.analysis.answers.budget import RAN_OUT, UNLIMITED, Budget
from dineros.analysis.answers.processes import end_group
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError

LONGEST_ARGUMENT = 100_000
"""Bytes of one argument of a program; Linux takes 128 KiB."""


class TinaError(DinerosError):
    """TINA is not there, failed, or printed what cannot be read."""


class TinaAnswerError(TinaError):
    """A program of TINA printed what cannot be read, or is wrong."""

    def __init__(self, message: str) -> None:
        super().__init__(message, hint="this version of TINA may not be supported; use another engine")


class TinaBudgetError(TinaError):
    """A program of TINA took more than it may: why the answer is not known, as reports say it."""

    def __init__(self, why: str, message: str, hint: str) -> None:
        super().__init__(message, hint=hint)
        self.why = why


_NO_MEMORY = re.compile(
    "failed to map segment|cannot allocate|allocate memory|memory allocation failed|out of memory|bad_alloc"
    "|Out_of_memory|MemoryError"
)
"""What loaders, the C library and run-time systems say."""


def tool(name: str = "tina") -> Path:
    """Return where a tool of TINA is.

    Raises
    ------
    TinaError
        It is not on the PATH.
    """
    found = shutil.which(name)
    if found is None:
        raise TinaError(
            f"{name} is not on the PATH",
            hint="TINA is available from its authors at LAAS; or use another engine",
        )
    return Path(found)


@dataclass(frozen=True)
class Workplace:
    """A folder with nets as files, where programs of TINA run.

    Attributes
    ----------
    folder : Path
        The folder; programs run in it and get names without folders.
    budget : Budget
        Time of all programs together; bytes of address space of each.
    """

    folder: Path
    budget: Budget = UNLIMITED

    def save(self, net: CompiledNet | pn.Net, name: str) -> None:
        """Write a net to a file whose name ends with ``.net``."""
        from dineros.analysis.nets.models import to_model
        from dineros.metamodel.files import save

        save(to_model(net, "net") if isinstance(net, CompiledNet) else net, self.folder / name)

    def run(self, name: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Run a program.

        Raises
        ------
        TinaBudgetError
            It took too long, or says that it got too little memory, of which there is a limit.
        TinaError
            It is not there, does not run, or failed.
        """
        program = tool(name)
        if any(len(os.fsencode(argument)) > LONGEST_ARGUMENT for argument in arguments):
            raise TinaError(
                f"the formula is too long for the command line of {name}", hint="use another engine"
            )
        try:
            # A session of its own: what the program starts (selt starts a converter) ends with it.
            process = subprocess.Popen(
                [str(program), *arguments],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                text=True,
                encoding="utf-8",
                errors="replace",
                cwd=self.folder,
                start_new_session=True,
            )
        except OSError as error:
            raise TinaError(
                f"{program} does not run: {error.strerror}", hint="check the installation of TINA"
            ) from None
        try:
            self._limit(process)
            left = self.budget.left
            output, errors = process.communicate(timeout=None if left is None else max(left, 0.01))
        except subprocess.TimeoutExpired:
            message = f"{name} took more than {self.budget.seconds:g} s"
            hint = "give it more time, or use another engine"
            raise TinaBudgetError(RAN_OUT["time"], message, hint) from None
        finally:
            end_group(process)
        if self.budget.memory_bytes is not None and _ran_out_of_memory(process.returncode, errors + output):
            why = RAN_OUT["memory"]
            raise TinaBudgetError(why, f"{name}: {why}", "give it more, or use another engine")
        if process.returncode:
            raise TinaError(
                f"{name} failed with exit status {process.returncode}: {_last_line(output, errors)}",
                hint="or it had too little memory; another engine may answer",
            )
        return subprocess.CompletedProcess(process.args, 0, output, errors)

    def _limit(self, process: subprocess.Popen[str]) -> None:
        memory = self.budget.memory_bytes
        if memory is not None and hasattr(resource, "prlimit"):  # Linux only
            with suppress(ProcessLookupError):  # it may have ended already
                resource.prlimit(process.pid, resource.RLIMIT_AS, (memory, memory))


@contextmanager
def workplace(net: CompiledNet | pn.Net, budget: Budget = UNLIMITED) -> Iterator[Workplace]:
    """Make a folder that holds a net as ``net.net``, and leave nothing of it behind.

    Parameters
    ----------
    budget : Budget, optional
        Time that all programs together may take, from now on where it has not begun, and the memory of each.
    """
    with tempfile.TemporaryDirectory(prefix="dineros-tina-") as folder:
        place = Workplace(Path(folder), budget.begun())
        place.save(net, "net.net")
        yield place


def _ran_out_of_memory(status: int, said: str) -> bool:
    """Return whether a program that had a limit failed by it; some use what they did not get, and crash."""
    return status in (-signal.SIGSEGV, -signal.SIGBUS) or (status != 0 and bool(_NO_MEMORY.search(said)))


def _last_line(output: str, errors: str) -> str:
    """Return the last line that is not empty: an error if there is one."""
    for text in (errors, output):
        for line in reversed(text.splitlines()):
            if line.strip():
                return line.strip()[:200]
    return "no message"
