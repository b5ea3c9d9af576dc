"""Source code that a command reads: its options and its facts."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from dineros.cli.console import note, warn
from dineros.cli.models import change, refuse_invalid
from dineros.cli.options import Adds, cache_folder, collected, flag, path_option, together, value_option
from dineros.cli.searching import search

if TYPE_CHECKING:
    from dineros.analysis.witnesses.findings import Fault, Finding
    from dineros.metamodel import sym
    from dineros.observation.importing.coded import Coded
    from dineros.observation.systems import ObservedSystem

CACHE = "DINEROS_SOURCE_CACHE"
"""Environment variable: the folder of the cache of source code; empty: no cache."""


@dataclass(frozen=True)
class ModelOfCode:
    """The model of source code."""

    model: sym.SystemModel
    findings: list[Finding]
    """Faults that the code and its names show."""


@dataclass(frozen=True)
class Code:
    """Folders of source code."""

    folders: tuple[Path, ...]
    facts: Path | None = None
    """Where the facts are written, as JSON."""
    launch: str | None = None
    """A launch file in one of the folders."""
    idioms: tuple[Path, ...] = ()
    """Tables of library idioms."""
    arguments: tuple[str, ...] = ()
    """``ARG:=VALUE`` of the launch file."""
    no_cache: bool = False
    """Whether nothing is taken from the cache, and nothing kept."""

    def refuse_without_folders(self) -> None:
        """Reject options that need source code if no folder is given; raises `UsageError`."""
        given = {"--facts": self.facts, "--launch": self.launch, "--idioms": self.idioms}
        for option, value in given.items():
            if value not in (None, ()) and not self.folders:
                raise click.UsageError(f"{option} requires --source FOLDER")
        for argument in self.arguments:
            if self.launch is None or ":=" not in argument:
                raise click.UsageError(f"{argument!r} is not an ARG:=VALUE of a --launch FILE")

    def refuse_beside(self, bag: Path | None, graph: bool) -> None:
        """Reject another source of observations; raises `UsageError`."""
        if bag is not None:
            raise click.UsageError("--source cannot be combined with --bag")
        if graph:
            raise click.UsageError("--source cannot be combined with --graph and --domain in this command")

    def read(self) -> tuple[Coded, list[Finding]]:
        """Return the described system and the faults of the code; the facts are written.

        Raises
        ------
        DinerosError
            A folder, a table or the launch file cannot be read, or no node is found.
        """
        from dineros.metamodel.errors import DinerosError, Location
        from dineros.metamodel.files.atomic import write_atomically
        from dineros.observation.findings.code import code_findings
        from dineros.observation.findings.interfaces import missing_types, unchecked_types
        from dineros.observation.findings.locks import not_modelled
        from dineros.observation.importing.coded import coded, unread
        from dineros.sources.folders import file_of_ros1
        from dineros.sources.reading import Launch, read_source

        search().stage("reading source code")
        launch = None
        if self.launch is not None:
            pairs = [argument.partition(":=") for argument in self.arguments]
            launch = Launch(self.launch, {name: value for name, _, value in pairs})
        cache = None if self.no_cache else _cache()
        read = [(str(folder), read_source(folder, self.idioms, launch, cache)) for folder in self.folders]
        if self.facts is not None:
            shown = [facts.to_json() for _, facts in read]
            text = json.dumps(shown[0] if len(shown) == 1 else shown, indent=2, ensure_ascii=False)
            write_atomically(self.facts, f"{text}\n".encode())
        for line in unread(read):
            warn(line)
        if not any(facts.nodes for _, facts in read):
            old = next(((folder, path) for folder, _ in read if (path := file_of_ros1(Path(folder)))), None)
            hint = "only nodes of ROS 2 in Python and C++ are recognised"
            if old is not None:
                hint += f"; {old[0]}/{old[1]} is code of ROS 1"
            raise DinerosError(
                "the source code contains no node", location=Location(self.folders[0]), hint=hint
            )
        for line in unchecked_types(read):
            note(f"type: {line}")
        model = coded(read, ", ".join(folder for folder, _ in read))
        model = replace(model, lacks=(*model.lacks, *not_modelled(read)))
        return model, [*missing_types(read), *code_findings(read, model.modelled)]

    def mismatches(self, read: Coded, system: ObservedSystem) -> list[Finding]:
        """Return the faults of ports; without a launch file, programs may run apart."""
        from dineros.observation.findings.mismatches import mismatches, of_separate_programs

        found = mismatches(system)
        return found if self.launch is not None else of_separate_programs(found, read.programs)


def _cache() -> Path | None:
    """Return the folder of the cache; None: no cache."""
    said = os.environ.get(CACHE)
    if said is not None:
        return Path(said) if said else None
    return cache_folder() / "sources"


def model_of_code(code: Code, given: Path | None, settings: Sequence[str]) -> ModelOfCode:
    """Return the model of source code, and the faults that the code and its names show.

    Raises
    ------
    DinerosError
        The code or the file cannot be read, or a setting does not fit.
    """
    from dineros.metamodel.ros_names import snake_case
    from dineros.observation.findings.mismatches import of_part
    from dineros.observation.importing.building import to_model
    from dineros.observation.importing.given import Given
    from dineros.observation.importing.given_reading import read_given

    read, found = code.read()
    said = read.with_people(read_given(given) if given is not None else Given())
    threads = read.lacks_of_threads(said)
    say_taken((*read.taken, *threads))
    search().stage("making the model")
    folder = code.folders[0]
    lacks = (*read.lacks, *threads)
    imported = to_model(read.system, said, snake_case(folder.resolve().name) or "code", lacks)
    for line in imported.left_out:
        warn(f"left out: {line}")
    for assumed in imported.assumed:
        note(f"assumed: {assumed}")
    change(imported.model, folder, settings)
    refuse_invalid(imported.model, folder)
    return ModelOfCode(imported.model, [*found, *of_part(code.mismatches(read, read.apart))])


def faults_of_code() -> Mapping[str, Fault]:
    """Return all kinds of findings of a check of source code, by name."""
    from dineros.analysis.timed_checks.faults import TIMED_FAULTS
    from dineros.observation.findings import code, interfaces, mismatches

    missing = interfaces.MISSING
    return {**TIMED_FAULTS, **mismatches.FAULTS, **code.FAULTS, missing.rule: missing}


cache_option = flag("--no-cache", "Read all source code again, and do not cache the result.")


def code_options() -> Adds:
    """Return the options that name source code, passed as `code`; `--no-cache` is apart."""
    return together(
        collected(Code, "code"),
        path_option(
            "--source FOLDER",
            "Source code in Python and C++; it is read, never executed; repeatable.",
            into="folders",
            multiple=True,
        ),
        path_option("--facts FILE.json", "Write the facts found in the code, with their lines."),
        value_option(
            "--launch FILE", "The launch file, in FOLDER, that starts the nodes; ARG:=VALUE may follow."
        ),
        path_option(
            "--idioms FILE.toml", "An additional table of library idioms; repeatable.", multiple=True
        ),
        click.argument("arguments", nargs=-1, metavar="[ARG:=VALUE]..."),
    )


def say_taken(lines: Sequence[str]) -> None:
    """Print what the code leaves open, with the assumptions."""
    for line in lines:
        note(f"open: {line}")
    if lines:
        warn(f"open in the code: {len(lines)}; -v lists them")
