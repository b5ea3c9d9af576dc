"""A model's way through the commands: validate, convert, check, generate, run, resume, conform.

What must not happen: a stack trace, a refusal of more than one line, a file written in part, two formats that
disagree, a workspace that is stale at once, a run that does not conform to its own model.
"""

from __future__ import annotations

import re
import shutil
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from dineros.cli.models import BY_HAND, OTHER_QUEUES, RUNS_AS_ROS2
from dineros.metamodel import sym
from dineros.metamodel.files import save
from tests.fuzz.judging import ACCEPTED, REFUSED, Outcome, judge, refused_or, run_command

FOUND, UNKNOWN = 1, 3
BUDGET = ("--timeout", "3", "--memory", "4G")  # more than a test process may hold already
_PATHS = ("lifecycle",)
_NOTES = (": warning: ", ": by the rules of ros2: ", OTHER_QUEUES, RUNS_AS_ROS2, BY_HAND)
FURTHER: list[list[str]] = [
    ["check", "--suggest-callback-groups", "--no-cache", *BUDGET],
    ["check", "--suggest-capacities", "--no-cache", *BUDGET],
    ["check", "--witnesses", "--no-cache", *BUDGET],
    ["statespace", "--no-cache", *BUDGET],
    ["find", "--marking", "deadlock", *BUDGET],
    ["verify", "--ctl", "AG EF deadlock", "--no-cache", *BUDGET],
    ["generate", "-o", "lifecycle", "--lifecycle"],
    ["check", "--middleware", "ros1", "--no-cache", *BUDGET],
]
"""Of these, each model goes through one."""


@dataclass
class Passage:
    """What came of a model.

    Attributes
    ----------
    statuses : dict
        The exit status of each command, by a name of its own.
    said : dict
        The last line of commands that refused the model.
    faults : list of str
        What must not happen.
    """

    statuses: dict[str, int] = field(default_factory=dict)
    said: dict[str, str] = field(default_factory=dict)
    faults: list[str] = field(default_factory=list)

    @property
    def is_valid(self) -> bool:
        return self.statuses.get("validate") == ACCEPTED

    def counts(self) -> Counter[str]:
        return Counter(f"{step}: {status}" for step, status in self.statuses.items())


def take_through(model: sym.SystemModel, folder: Path, seed: int = 1) -> Passage:
    """Take a model through the whole chain, in an empty folder; `seed` is that of its runs."""
    return _Chain(folder, seed).through(model)


class _Chain:
    """A model on its way."""

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder = folder
        self.seed = seed
        self.passage = Passage()
        self.path = folder / "model.sym.xmi"

    def through(self, model: sym.SystemModel) -> Passage:
        if self._judged("save", partial(refused_or, partial(save, model, self.path))) != ACCEPTED:
            if self.path.exists():
                self._fault("save", "there is a file though it was refused")
            return self.passage
        self._command("validate", "validate", self.path)
        self._formats()
        self._command("check", "check", self.path, "--no-cache", *BUDGET)
        self._generated()
        further = FURTHER[self.seed % len(FURTHER)]
        self._command(" ".join(further[:2]), further[0], self.path, *self._in_folder(further[1:]))
        self._run("simulate", "--simulate", "--timeout", "3")
        if self.passage.statuses["run simulate"] != REFUSED:
            self._run("simulate", "--simulate", "--timeout", "2", "--resume")
            self._run("local", "--local", "--timeout", "0.3")
            self._command("trace", "trace", self.folder / "traces simulate", "-o", self.folder / "run.svg")
        return self.passage

    def _in_folder(self, options: list[str]) -> list[object]:
        """Return options, whose paths stand in the folder."""
        return [self.folder / each if each in _PATHS else each for each in options]

    def _formats(self) -> None:
        """What PNML has of the model is as valid, and stays as it is from then on."""
        pnml, back = self.folder / "model.pnml", self.folder / "back.sym.xmi"
        if self._command("convert", "convert", self.path, "-o", pnml) == REFUSED:
            if pnml.exists():
                self._fault("convert", "there is a file though it was refused")
            return
        # PNML is read as it should be, with arcs on the page of their ends: a model may be fixed by that.
        if self._command("validate PNML", "validate", pnml) != ACCEPTED and self.passage.is_valid:
            self._fault("convert", "what was valid is not valid as PNML")
        if self._command("convert back", "convert", pnml, "-o", back) == REFUSED:
            self._fault("convert back", "what was written as PNML cannot be read")
            return
        for source, target in ((back, "again.pnml"), (self.folder / "again.pnml", "again.sym.xmi")):
            if self._command("convert again", "convert", source, "-o", self.folder / target) == REFUSED:
                self._fault("convert again", "what was read from PNML cannot be written and read")
                return
        if (self.folder / "again.sym.xmi").read_bytes() != back.read_bytes():
            self._fault("convert again", "the model is another one")

    def _generated(self) -> None:
        workspace = self.folder / "workspace"
        if self._command("generate", "generate", self.path, "-o", workspace) == REFUSED:
            if workspace.exists():
                self._fault("generate", "there is a workspace though the model was refused")
            return
        if self._command("generate --check", "generate", self.path, "-o", workspace, "--check") != ACCEPTED:
            self._fault("generate --check", "the workspace is stale at once")
        for path in workspace.rglob("*.py"):
            try:
                compile(path.read_bytes(), path.name, "exec", dont_inherit=True)
            except SyntaxError as error:
                self._fault("generate", f"{path.relative_to(workspace)}: {error}")

    def _run(self, name: str, *options: str) -> None:
        """Run, and replay; no run that the runtime begins may differ from the net."""
        traces = self.folder / f"traces {name}"
        status = self._command(
            f"run {name}", "run", self.path, *options, "--seed", self.seed, "--trace", traces
        )
        if status == FOUND:
            self._fault(f"run {name}", "a step is said not to be allowed")
        if status == REFUSED or not traces.exists():
            return
        if self._command(f"conform {name}", "conform", self.path, traces, *BUDGET) == FOUND:
            self._fault(f"conform {name}", "a run differs from its own model")

    def _command(self, step: str, *arguments: object) -> int | None:
        return self._judged(step, partial(run_command, *arguments))

    def _judged(self, step: str, work: partial[Outcome]) -> int | None:
        said: list[str] = []

        def attempt(_: bytes) -> Outcome:
            outcome = work()
            said.append(outcome.said)
            return outcome

        verdict = judge(attempt, b"", self.folder)
        if verdict.fault:
            self._fault(step, verdict.fault)
        if verdict.status is not None:
            self.passage.statuses[step] = verdict.status
        if verdict.status == REFUSED:
            refusals = list(_refusals(said[-1]))
            self.passage.said[step] = refusals[-1] if refusals else ""
            places = [line for line in refusals if re.match(r"\S+\.(xmi|pnml):\d+: ", line)]
            if not refusals or len(refusals) > max(1, len(places)):  # a line for each fault of the file
                self._fault(step, f"is refused in {len(refusals)} lines: {said[-1]}")
        return verdict.status

    def _fault(self, step: str, text: str) -> None:
        self.passage.faults.append(f"{step}: {text}")


def _refusals(said: str) -> Iterator[str]:
    """Yield the lines that say more than by which rules the model is read, and what of it does not run."""
    for line in said.splitlines():
        if not any(note in line for note in _NOTES):
            yield line


def empty(folder: Path) -> Path:
    """Return the folder, with nothing in it."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    return folder
