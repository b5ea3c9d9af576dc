"""From folders of source code to facts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from dineros.metamodel.errors import DinerosError, Location, counted, near_matches
from dineros.sources.cpp.parsing import forget_texts, is_there
from dineros.sources.cpp.programs import CppPrograms
from dineros.sources.facts import NODE, SPACE, Facts, NodeFact, is_open
from dineros.sources.folders import CPP, open_folder
from dineros.sources.interfaces import read_interfaces
from dineros.sources.keeping.store import tidy
from dineros.sources.language.keeping import ProgramKeeper
from dineros.sources.language.modules import Modules
from dineros.sources.launch.containers import ALONE, EXECUTORS, container_of, executor_in
from dineros.sources.launch.reading import LaunchFiles
from dineros.sources.launch.started import Started, full
from dineros.sources.launch.vendors import vendor_node
from dineros.sources.libraries.idioms import known_idioms, read_idioms
from dineros.sources.packages import packages_of
from dineros.sources.programs.running import Reading, read_programs, run_program, tests_with_ros


@dataclass(frozen=True)
class Launch:
    """A launch file, with values of its arguments."""

    file: str
    """Path in the folder that is read, or the end of the path of exactly one file."""
    arguments: Mapping[str, str] = field(default_factory=dict)
    """Values of arguments."""


def read_source(
    root: Path, tables: Sequence[Path] = (), launch: Launch | None = None, cache: Path | None = None
) -> Facts:
    """Return the facts of the packages of a folder, in Python and C++; nothing is executed or imported.

    Parameters
    ----------
    root : Path
        The folder.
    tables : sequence of Path
        Additional tables of library idioms.
    launch : Launch, optional
        The launch file that says which nodes there are; by default there is one of each.
    cache : Path, optional
        Folder where what programs in C++ do is kept: one that has not changed is not followed again. The
        facts are the same with and without.

    Raises
    ------
    DinerosError
        There is no such folder, it has too many files, a table or the launch file cannot be read.
    """
    idioms = dict(known_idioms())
    for table in tables:
        idioms |= read_idioms(table)
    folder = open_folder(root)
    packages = packages_of(folder)
    modules = Modules(folder, [package.path for package in packages])
    files = LaunchFiles(folder, packages, modules, idioms)
    descriptions: list[tuple[dict[str, Any], list[Started]]] = []
    given: dict[str, list[dict[str, Any]]] = {}
    for path in files.all():
        arguments, started = files.read(path, {}, follows=False)
        entries = [each.to_json() for each in started]
        descriptions.append(({"file": path, "arguments": arguments, "nodes": entries}, started))
        for each in started:
            started_code = each.plugin or each.executable
            if started_code and not is_open(started_code):
                found = files.parameters(each, full(each.name or started_code, each.namespace))
                given.setdefault(f"{each.package}/{started_code}", []).append(found)
    reading = Reading(folder, packages, idioms, {key: _agreed(found) for key, found in given.items()})
    if cache is not None:
        context = [repr(packages), repr(sorted(idioms.items()))]
        reading.keeper = ProgramKeeper(cache, folder, modules, context)
    facts = read_programs(reading, modules)
    facts.interfaces = read_interfaces(folder, packages)
    programs = _add_cpp(facts, reading, cache)
    if not facts.nodes and (tests := tests_with_ros(reading, modules)):
        others = f", and {counted(len(tests) - 1, 'other file')}" if len(tests) > 1 else ""
        folder.unread.append(f"{tests[0]}: a test that uses ROS{others}; tests are not read")
    _compose(facts, [started for _, started in descriptions])
    _complete(facts, descriptions)
    if launch is not None:
        facts.nodes = _launched(launch, files, reading, modules, facts, programs)
    facts.unread = sorted(dict.fromkeys(folder.unread))
    forget_texts()
    if cache is not None:
        tidy(cache)
    return facts


def _add_cpp(facts: Facts, reading: Reading, cache: Path | None) -> CppPrograms | None:
    """Add the nodes in C++, if a parser is installed; return their programs."""
    folder = reading.folder
    count = sum(path.endswith(CPP) for path in folder.files)
    if not count:
        return None
    if not is_there():
        folder.unread.append(f"{counted(count, 'file')} in C++: pip install 'dineros[sources]' reads them")
        return None
    programs = CppPrograms(folder, reading.packages, reading.idioms, cache)
    facts.nodes += programs.nodes(reading.given)
    facts.files += len(programs.files)
    return programs


def _compose(facts: Facts, descriptions: list[list[Started]]) -> None:
    """Set the executor of components by their container, if all launch files agree on it."""
    for node in facts.nodes:
        loaded = [(each, all_) for all_ in descriptions for each in all_ if each.plugin == node.plugin != ""]
        found = {executor_in(each, all_) for each, all_ in loaded}
        if len(found) == 1 and (executor := found.pop()) is not None:
            node.executor, node.threads = executor


def _complete(facts: Facts, descriptions: list[tuple[dict[str, Any], list[Started]]]) -> None:
    """Set the name of started nodes without one to the name in their code."""
    names = {node.program: node.name for node in facts.nodes if not is_open(node.name)}
    for entry, started in descriptions:
        for shown, each in zip(entry["nodes"], started, strict=True):
            name = names.get(f"{each.package}/{each.executable}")
            if "name" not in shown and each.kind != "include" and name is not None:
                shown["name"] = full(name, each.namespace)
        facts.launch.append(entry)


def _launched(
    launch: Launch,
    files: LaunchFiles,
    reading: Reading,
    modules: Modules,
    facts: Facts,
    cpp: CppPrograms | None,
) -> list[NodeFact]:
    """Return the nodes that a launch file starts, with their names, remappings and parameters."""
    path = files.named(launch.file)
    if path is None:
        hint = near_matches(launch.file, files.all()) or f"there are {', '.join(files.all()) or 'none'}"
        raise DinerosError(
            f"there is no launch file {launch.file} in the folder",
            location=Location(reading.folder.root),
            hint=hint,
        )
    _, started = files.read(path, launch.arguments, follows=True)
    defaults = {node.program: node.name for node in facts.nodes}
    found: list[NodeFact] = []
    for process, each in enumerate(started, 1):
        program = f"{each.package}/{each.executable}"
        if not each.is_enabled or each.kind == "include":
            continue
        name = each.name or defaults.get(program, each.executable)
        values = files.parameters(each, full(name, each.namespace)) if not is_open(name) else {}
        if each.kind == "container" or each.executable in EXECUTORS:
            continue
        values |= {key: said for key, said in ((NODE, each.name), (SPACE, each.namespace)) if said}
        launched = replace(
            reading, given={program: values}, is_launched=True, arguments=tuple(each.arguments)
        )
        nodes = run_program(program, launched, modules)
        if nodes is None and cpp is not None:
            nodes = cpp.run([each.plugin or program], values)
        if nodes is None and (vendor := vendor_node(each, reading.idioms)) is not None:
            nodes = [vendor]
        if nodes is None:
            reading.folder.unread.append(f"{each.at}: {each.plugin or program} is not in this folder")
        for node in nodes or ():
            if each.name and len(nodes or ()) == 1:
                node.name = each.name
            node.namespace = each.namespace or node.namespace
            node.remappings = each.remappings
            node.started, node.process = str(each.at), process
            if each.kind == "component":
                _load(node, each, started)
            elif node.pool:
                node.pool += 1000 * (len(found) + 1)
            found.append(node)
    if not found:
        reading.folder.unread.append(f"{path}: it does not start any node whose code is in this folder")
    return found


def _load(node: NodeFact, component: Started, started: list[Started]) -> None:
    """Run a component in its container, whose executor it shares unless it is the only one there."""
    container, executor = container_of(component, started), executor_in(component, started)
    if container is None or executor is None:
        node.executor, node.threads = "open: its container is not known", "open"
        return
    node.executor, node.threads = executor
    if container.executable != ALONE:
        node.process = 0
        node.program, node.pool = f"container {full(container.name, container.namespace)}", 1


def _agreed(found: list[dict[str, Any]]) -> dict[str, Any]:
    """Return the values on which all launch files agree."""
    return {
        key: value for key, value in found[0].items() if all(each.get(key) == value for each in found[1:])
    }
