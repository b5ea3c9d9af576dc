"""Runs the programs of a folder in the interpreter: from files to facts."""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import PurePosixPath
from typing import Any

from dineros.sources.facts import CallbackFact, Facts, NodeFact
from dineros.sources.folders import SourceFolder, is_test
from dineros.sources.language.activities import Activity
from dineros.sources.language.calls import Interpreter
from dineros.sources.language.keeping import ProgramKeeper
from dineros.sources.language.machine import TooLong
from dineros.sources.language.modules import Module, Modules
from dineros.sources.language.values import Class, Frame, Function
from dineros.sources.left_out import lines
from dineros.sources.libraries.executing.unset import mark_never_set
from dineros.sources.libraries.idioms import Idiom
from dineros.sources.libraries.left_out import calls_of
from dineros.sources.libraries.library import RosLibrary
from dineros.sources.packages import Package
from dineros.sources.places import Place
from dineros.sources.programs.callbacks import assign_callbacks, read_callbacks
from dineros.sources.programs.executables import Program, different, guard_of, only_call, programs_of
from dineros.sources.reading_limits import limits_for_reading
from dineros.sources.ros_imports import RosImports

NO_PROGRAM = "no program"
"""Stands for the program of a class that no program instantiates."""


@dataclass(eq=False)
class Reading:
    """The input from a folder."""

    folder: SourceFolder
    packages: list[Package]
    idioms: Mapping[str, Idiom]
    """The table of library idioms."""
    given: dict[str, dict[str, Any]] = field(default_factory=dict)
    """Values of parameters that launch files give, by programs: ``package/executable``."""
    is_launched: bool = False
    """Whether these values hold; else only where the code has none."""
    arguments: tuple[str, ...] = ()
    """Arguments of the command line that a launch file gives."""
    keeper: ProgramKeeper | None = None
    """The cache of what programs do."""

    def nodes(
        self, program: str, path: str, start: str | None, run: Callable[[], list[NodeFact]]
    ) -> list[NodeFact]:
        """Return the nodes of a program in a file that starts with a function or a class.

        They come from the cache if it has them; otherwise `run` returns them.
        """
        if self.keeper is None:
            return run()
        values = {"given": self.given.get(program, {}), "arguments": list(self.arguments)}
        names = {"program": program, "path": path, "start": start, "launched": self.is_launched}
        return self.keeper.nodes(names | values, run)


def read_programs(reading: Reading, modules: Modules) -> Facts:
    """Return the facts of the programs of a folder."""
    folder = reading.folder
    facts = Facts(folder.root.resolve().name)
    with limits_for_reading():
        all_programs = programs_of(folder, reading.packages, modules)
        programs, same = different(all_programs, reading.given, modules)
        imports = RosImports(modules, reading.idioms)
        made: set[tuple[str, int]] = set()
        known: dict[tuple[str, str], list[NodeFact]] = {}
        for program in programs:
            module = modules.module(program.path)
            if module is None or not imports.can_use_ros(module):
                continue
            nodes, classes = _run(program, modules, reading)
            made |= classes
            _add(facts, nodes, known)
        for program, other in same:
            for node in facts.nodes:
                if node.program == other.full or other.full in node.also_in:
                    node.also_in = list(dict.fromkeys([*node.also_in, program.full]))
        for path, line, name in _classes_of_nodes(folder, modules):
            module = modules.module(path)
            if (path, line) not in made and module is not None and imports.can_use_ros(module):
                run = partial(_run_class, path, name, module, modules, reading)
                _add(facts, reading.nodes(NO_PROGRAM, path, name, run), known)
    facts.files = len(modules.all)
    folder.unread += lines(calls_of(modules.all.values()), modules.reached)
    facts.unread = sorted(dict.fromkeys(folder.unread))
    facts.nodes.sort(key=lambda node: (node.at.file, node.at.line))
    return facts


def run_program(name: str, reading: Reading, modules: Modules) -> list[NodeFact] | None:
    """Return the nodes of the program with a name, ``package/executable``; None: it does not exist."""
    with limits_for_reading():
        for program in programs_of(reading.folder, reading.packages, modules):
            if f"{program.package}/{program.name}" == name:
                return _run(program, modules, reading)[0]
    return None


def tests_with_ros(reading: Reading, modules: Modules) -> list[str]:
    """Return the files of tests that import a library of ROS themselves or through others."""
    imports = RosImports(modules, reading.idioms)
    found = ((path, modules.module(path)) for path in reading.folder.scripts if is_test(path))
    return [path for path, module in found if module is not None and imports.can_use_ros(module)]


def _interpreter(modules: Modules, program: str, reading: Reading) -> tuple[Interpreter, RosLibrary]:
    machine = Interpreter(modules, program)
    library = RosLibrary(machine, reading.idioms)
    library.maker.given = reading.given.get(program, {})
    library.maker.is_launched = reading.is_launched
    library.maker.arguments = reading.arguments
    machine.library = library
    return machine, library


def _run(program: Program, modules: Modules, reading: Reading) -> tuple[list[NodeFact], set[tuple[str, int]]]:
    """Run a program; return its nodes, and the classes that it instantiated."""
    module = modules.module(program.path)
    if module is None:
        return [], set()
    nodes = reading.nodes(
        program.full, program.path, program.function, lambda: _follow(program, module, modules, reading)
    )
    return nodes, {(node.at.file, node.at.line) for node in nodes}


def _follow(program: Program, module: Module, modules: Modules, reading: Reading) -> list[NodeFact]:
    """Run a program in the interpreter; return its nodes."""
    words = program.full
    machine, library = _interpreter(modules, words, reading)
    machine.home = module.path
    main = CallbackFact("main", "main", Place(module.path, 1))
    activity = Activity(main)
    try:
        with machine.doing(activity):
            frame = machine.module_frame(module, is_script=program.function is None)
            function = _function(machine, frame, program.function)
            if function is not None:
                main.at = Place(function.frame.module.path, function.node.lineno)
                main.name = function.name
                machine.call(function, [], {}, function.node, frame)
            elif program.function is None:
                _place_main(main, machine, frame, module)
        read_callbacks(machine, reading.folder)
    except (TooLong, RecursionError):
        reading.folder.unread.append(
            f"{program.path}: the program {words} is too large to be read completely"
        )
        machine.attributes.is_wild = True
        for node in machine.nodes:
            for callback in node.callbacks:
                callback.is_open = True
    library.executors.late.finish()
    for node in machine.nodes:
        waits = any(node.of(kind) for kind in ("subscriptions", "timers", "services", "action_servers"))
        if node.threads == "not spun" and waits and (node.is_lent or node.lent_to):
            node.executor, node.threads = "open: code that is not in the folder may spin it", "open"
    mark_never_set(modules, library.doer.waits)
    assign_callbacks(machine, activity)
    return machine.nodes


def _place_main(main: CallbackFact, machine: Interpreter, frame: Frame, module: Module) -> None:
    called = only_call(guard_of(module))
    function = _function(machine, frame, called)
    if function is not None:
        main.at = Place(function.frame.module.path, function.node.lineno)
        main.name = function.name


def _function(machine: Interpreter, frame: Frame, name: str | None) -> Function | None:
    found = machine.variable(name.partition(".")[0], frame) if name else None
    return found if isinstance(found, Function) else None


def _run_class(path: str, name: str, module: Module, modules: Modules, reading: Reading) -> list[NodeFact]:
    """Create an instance of a node class that no program instantiates; return its nodes."""
    machine, library = _interpreter(modules, NO_PROGRAM, reading)
    main = CallbackFact("main", "main", Place(path, 1))
    activity = Activity(main)
    try:
        with machine.doing(activity):
            frame = machine.module_frame(module)
            cls = machine.variable(name, frame)
            if isinstance(cls, Class):
                machine.call(cls, [], {}, cls.node, frame)
        read_callbacks(machine, reading.folder)
    except (TooLong, RecursionError):
        machine.attributes.is_wild = True
        reading.folder.unread.append(f"{path}: the class {name} is too large to be read completely")
    mark_never_set(modules, library.doer.waits)
    for node in machine.nodes:
        node.executor = node.executor or "open: no program creates it"
        if node.threads == "not spun":
            node.threads = "open"
    assign_callbacks(machine, activity)
    return machine.nodes


def _add(facts: Facts, nodes: list[NodeFact], known: dict[tuple[str, str], list[NodeFact]]) -> None:
    """Add the nodes of a program, except nodes that the program of their own file also creates."""
    for node in nodes:
        same = known.setdefault((str(node.at), node.name), [])
        other = next((each for each in same if each.program != node.program), None)
        if other is None or not (_is_home(node) or _is_home(other)):
            facts.nodes.append(node)
            same.append(node)
            continue
        kept, left = (node, other) if _is_home(node) and not _is_home(other) else (other, node)
        kept.also_in = list(dict.fromkeys([*other.also_in, *node.also_in, left.program]))
        facts.nodes[facts.nodes.index(other)] = kept
        same[same.index(other)] = kept


def _is_home(node: NodeFact) -> bool:
    """Return whether the program of a node is in the file of its class."""
    return node.home == node.at.file


def _classes_of_nodes(folder: SourceFolder, modules: Modules) -> Iterator[tuple[str, int, str]]:
    """Yield the classes that look like nodes, and that no other class of the folder extends."""
    found: list[tuple[str, ast.ClassDef]] = []
    extended: set[str] = set()
    for path in folder.scripts:
        if "test" in PurePosixPath(path).parts or "tests" in PurePosixPath(path).parts:
            continue
        module = modules.module(path)
        others = _other_names(module) if module is not None else {}
        for node in module.nodes if module is not None else ():
            if isinstance(node, ast.ClassDef):
                bases = [ast.unparse(base) for base in node.bases]
                extended |= {others.get(base, base.rpartition(".")[2]) for base in bases}
                if node in module.tree.body and (  # type: ignore[union-attr]
                    any(base.rpartition(".")[2].endswith("Node") for base in bases) or _makes_a_node(node)
                ):
                    found.append((path, node))
    for path, node in found:
        if node.name not in extended:
            yield path, node.lineno, node.name


def _other_names(module: Module) -> dict[str, str]:
    """Return the original names of imports that a module renames."""
    return {
        each.asname: each.name
        for node in module.nodes
        if isinstance(node, ast.ImportFrom)
        for each in node.names
        if each.asname is not None
    }


def _makes_a_node(node: ast.ClassDef) -> bool:
    return any(
        isinstance(each, ast.Call)
        and isinstance(each.func, ast.Attribute)
        and each.func.attr == "create_node"
        for each in ast.walk(node)
    )
