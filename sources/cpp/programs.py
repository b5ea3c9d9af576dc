"""Reads the programs in C++: main functions, components, and node classes that no program creates."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

from dineros.metamodel.errors import counted
from dineros.sources.branches import fields_of_effects
from dineros.sources.cmake import Component
from dineros.sources.cpp.calling.doing import Ros
from dineros.sources.cpp.entries import ClassInfo, Routine
from dineros.sources.cpp.following.machine import MOST_STEPS, TooLong
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.index import Asked, Index
from dineros.sources.cpp.interpreting.deferring import find_unanswered, is_deferred
from dineros.sources.cpp.interpreting.groups import doubt_groups
from dineros.sources.cpp.interpreting.notified import mark_never_notified
from dineros.sources.cpp.keeping import Followed, Keeper
from dineros.sources.cpp.left_out import calls_of
from dineros.sources.cpp.macros.directives import without_dead
from dineros.sources.cpp.macros.expanding import Macros
from dineros.sources.cpp.macros.member_pointers import with_bound_members
from dineros.sources.cpp.parsing import Source, errors_of, parse
from dineros.sources.cpp.reaching.reach import Reach
from dineros.sources.cpp.reaching.reached import Reached
from dineros.sources.cpp.remaining.overriding import overridden
from dineros.sources.cpp.remaining.unfollowed import unfollowed
from dineros.sources.cpp.replaced import join_replaced
from dineros.sources.cpp.tables.parameter_libraries import read_parameter_libraries
from dineros.sources.cpp.tables.plugins import read_plugins
from dineros.sources.cpp.values import Frame, Made, Todo, Value
from dineros.sources.facts import LATER, NO_SPIN, CallbackFact, NodeFact
from dineros.sources.folders import CPP, SourceFolder, is_test
from dineros.sources.launch.containers import THREADS
from dineros.sources.left_out import lines
from dineros.sources.libraries.idioms import Idiom, read_idioms
from dineros.sources.packages import Package
from dineros.sources.places import Place
from dineros.sources.reading_limits import limits_for_reading

_MOST_OF_ALL = 2_000_000
"""Steps for all programs of a folder, as each may take `MOST_STEPS`."""
_LEAST = 20_000
"""Steps for a program when these are used up: most need fewer."""


@cache
def cpp_idioms() -> dict[str, Idiom]:
    """Return the table of C++ libraries that is stored next to this file."""
    return read_idioms(Path(__file__).with_name("idioms.toml"))


class CppPrograms:
    """The programs in C++ of a folder.

    Parameters
    ----------
    idioms : mapping of str to Idiom
        The table of libraries.
    cache : Path, optional
        Folder of the cache of facts of programs.
    """

    def __init__(
        self,
        folder: SourceFolder,
        packages: list[Package],
        idioms: Mapping[str, Idiom],
        cache: Path | None = None,
    ) -> None:
        self._folder = folder
        self._packages = packages
        self._idioms = cpp_idioms() | dict(idioms)
        self.index = Index()
        self.files = [path for path in folder.files if path.endswith(CPP) and not is_test(path)]
        self._sources: list[Source] = []
        with limits_for_reading():
            read = {path: folder.read(path) for path in self.files}
            texts = {path: without_dead(text) for path, text in read.items() if text is not None}
            macros = Macros(texts)
            for path, text in texts.items():
                try:
                    source = _parsed(folder, path, text, macros)
                    if source is not None:
                        self.index.add(source)
                        self._sources.append(source)
                except RecursionError:
                    folder.unread.append(f"{path}: it is nested too deeply")
        self.index.finish()
        folder.unread += [*macros.unread, *self.index.unread]
        self.index.libraries = read_parameter_libraries(folder)
        self.index.plugins = read_plugins(folder, self._sources)
        self._reach = Reach(self.index, self._idioms)
        self._is_launched = False
        self._reached = Reached()
        self._steps_left = _MOST_OF_ALL
        context = [str(folder.root.resolve()), repr(sorted(self._idioms.items()))]
        context += [repr(sorted(self.index.spaces.items()))]
        context += [repr(self.index.libraries), repr(self.index.plugins)]
        self._keeper = Keeper(cache, self.index, context) if cache is not None else None

    def nodes(self, given: Mapping[str, Mapping[str, Any]] | None = None) -> list[NodeFact]:
        """Return the nodes of all programs, and one node for each class of nodes that no program creates."""
        found: list[NodeFact] = []
        with limits_for_reading():
            programs = [
                self._run(self._program(routine.path), routine, None, given or {})
                for routine in self.index.functions.get("main", [])
                if self._reach.may_make_nodes(routine)
            ]
            # Of programs that create the same nodes, the one with a known executor is used.
            for nodes in sorted(programs, key=lambda each: any(node.threads == "open" for node in each)):
                found += nodes
            wanted = list(self._components())
            for cls in dict.fromkeys([*wanted, *self._exported(), *self._classes()]):
                if id(cls) not in self._reached.classes:
                    nodes = self._run(self._component_name(cls), None, cls, given or {})
                    found += nodes
                    if cls in wanted and not nodes:
                        self._folder.unread.append(
                            f"{cls.path}: the component {cls.full} is not a node that can be read, so its "
                            "ports are unknown"
                        )
        self._folder.unread += lines(calls_of(self._sources, self._made()), self._reached.calls)
        return sorted(_different(found), key=lambda node: (node.at.file, node.at.line))

    def _made(self) -> list[str]:
        return [path for path, each in self._idioms.items() if each.makes]

    def run(self, names: Sequence[str], values: Mapping[str, Any]) -> list[NodeFact] | None:
        """Return the nodes of a program, or of a component, with values of its parameters.

        Parameters
        ----------
        names : sequence of str
            How it may be called: ``package/executable``, the class of a component.
        values : mapping
            Values of parameters.

        Returns
        -------
        list of NodeFact or None
            None: it is not in the folder.
        """
        if not self._is_launched:
            self._is_launched, self._steps_left = True, _MOST_OF_ALL
        with limits_for_reading():
            for routine in self.index.functions.get("main", []):
                name = self._program(routine.path)
                if self._full(name, routine.path) in names:
                    return self._run(name, routine, None, {self._full(name, routine.path): values})
            for plugin, path in self.index.components:
                cls = self._class_of(plugin, path)
                if cls is not None:
                    name = self._component_name(cls)
                    if {cls.full, self._full(name, cls.path)} & set(names):
                        return self._run(name, None, cls, {self._full(name, cls.path): values})
        return None

    def _program(self, path: str) -> str:
        """Return the executable of a file with a main function."""
        package = self._package_at(path)
        for name, sources in package.sources.items() if package is not None else ():
            if path in sources:
                return name
        return PurePosixPath(path).stem

    def _component(self, cls: ClassInfo) -> Component | None:
        package = self._package_at(cls.path)
        found = package.components if package is not None else []
        return next((each for each in found if each.plugin == cls.full), None)

    def _component_name(self, cls: ClassInfo) -> str:
        """Return the executable of a component, if it has one; else its class."""
        component = self._component(cls)
        return component.executable if component is not None and component.executable else cls.full

    def _full(self, name: str, path: str) -> str:
        package = self._package_at(path)
        return name if package is None else f"{package.name}/{name}"

    def _components(self) -> Iterator[ClassInfo]:
        """Yield the classes of components; a line names those that are not there."""
        for name, path in self.index.components:
            cls = self._class_of(name, path)
            if cls is not None:
                yield cls
            else:
                self._folder.unread.append(
                    f"{path}: the component {name} is not in the folder, so its ports are unknown"
                )

    def _exported(self) -> Iterator[ClassInfo]:
        """Yield the classes of plugins that are nodes themselves, such as controllers."""
        machine = Statements(self.index, "", {})
        for each in self.index.plugins.exported:
            cls = self._class_of(each.cls.partition("<")[0].strip(), each.path)
            if cls is not None and not cls.templates and machine.node_kind(cls) is not None:
                yield cls

    def _class_of(self, name: str, path: str) -> ClassInfo | None:
        """Return the class of a component, which may be named by an alias."""
        machine = Statements(self.index, "", {})
        return machine.class_of(machine.type_text_of(name, Frame(path, "")), Frame(path, ""))

    def _classes(self) -> Iterator[ClassInfo]:
        """Yield the classes of nodes that no other class of the folder extends."""
        machine = Statements(self.index, "", {})
        kinds = [each for found in self.index.classes.values() for each in found]
        extended = {base for cls in kinds for base in machine.bases(cls)[1:]}
        for cls in sorted(kinds, key=lambda each: each.path):
            if cls not in extended and not cls.templates and machine.node_kind(cls) is not None:
                yield cls

    def _package_at(self, path: str) -> Package | None:
        inside = [each for each in self._packages if each.path == "." or path.startswith(f"{each.path}/")]
        return max(inside, key=lambda each: len(each.path)) if inside else None

    def _run(
        self, name: str, main: Routine | None, cls: ClassInfo | None, given: Mapping[str, Mapping[str, Any]]
    ) -> list[NodeFact]:
        """Return the nodes of a program or of a class of nodes, followed now or kept from an earlier run."""
        start = main or cls
        path = start.path if start is not None else ""
        full = self._full(name, path)
        values = dict(given.get(full, {}))
        if cls is not None:  # a component, which launch files name by its class
            values = {**given.get(self._full(cls.full, path), {}), **values}
        program = {
            "name": full,
            "path": path,
            "digest": self.index.digests.get(path),
            "start": start.node.start_byte if start is not None else 0,
            "cls": cls.full if cls is not None else "",
            "component": repr(None if cls is None else self._component(cls)),
            "given": values,
            "launched": self._is_launched,
            "steps": self._most_steps(),
        }
        found = self._keeper.load(program) if self._keeper is not None else None
        if found is None:
            asked, self._reach.was_asked = Asked(), False
            if cls is not None:
                asked.names.add(("classes", cls.name))
            self.index.asked = asked
            found, is_whole = self._follow(full, main, cls, values)
            self.index.asked = None
            if self._keeper is not None and is_whole:
                self._keeper.save(program, found, asked, self._reach.was_asked)
        self._steps_left -= found.steps
        self._folder.unread += found.unread
        self._reached.classes |= found.reached.classes
        self._reached.calls |= found.reached.calls
        doubt_groups(found.nodes, self._sources)
        find_unanswered(found.nodes, self._sources)
        mark_never_notified(found.nodes, self._sources)
        return found.nodes

    def _most_steps(self) -> int:
        return max(_LEAST, min(MOST_STEPS, self._steps_left))

    def _follow(
        self,
        program: str,
        main: Routine | None,
        cls: ClassInfo | None,
        given: Mapping[str, Any],
    ) -> tuple[Followed, bool]:
        """Return the facts of a program, and whether they are independent of the remaining stack."""
        path = main.path if main is not None else cls.path if cls is not None else ""
        reached = Reached()
        machine = Statements(self.index, program, self._idioms, self._reach, reached)
        library = machine.library = Ros(machine)
        machine.most_steps = self._most_steps()
        machine.given, machine.is_launched = given, self._is_launched
        machine.fact = CallbackFact("main", "main", Place(path, main.line if main is not None else 1))
        is_cut, is_whole, unread = False, True, list[str]()
        try:
            if main is not None:
                machine.run([main], [], None, main.node, [])
            elif cls is not None:
                machine.role = "constructor"
                args: list[Value] = [Made("rclcpp::NodeOptions")]
                machine.construct(cls, args, [], cls.node, Frame(path, cls.space))
            start = machine.fact
            for _ in range(2):  # the first pass finds the values that callbacks assign to members
                library.waiting.forget()
                _callbacks(machine)
                for target, routine, frame in list(overridden(machine)):
                    machine.library.read_callback(target, "event", routine.node, frame)
        except (TooLong, RecursionError) as error:
            start, is_cut, is_whole = machine.fact, True, isinstance(error, TooLong)
            unread.append(f"{path}: the program {program} is too large to be read completely")
        count = sum(machine.skipped.values())
        if count and not is_cut:
            words = f"{counted(count, 'routine')} that did nothing three times"
            again = "is not followed again" if count == 1 else "are not followed again"
            unread.append(f"{path}: the program {program} is long: {words} {again}, so ports may be missing")
        if not is_cut and not count:
            unread += unfollowed(machine)
        unread += machine.unread
        _share(machine)
        join_replaced(machine)
        machine.add_setters()
        for node in machine.nodes:
            kinds = {each.cls for each in machine.nodes}
            is_helper = cls is None or (node.cls != cls.name and cls.name in kinds)
            _finish(node, start, cls, None if cls is None or is_helper else self._component(cls), is_helper)
            if is_cut:
                for callback in node.callbacks:
                    callback.is_open = True
                node.threads = "open"
        return Followed(machine.nodes, unread, reached, machine.steps), is_whole


def _parsed(folder: SourceFolder, path: str, text: str, macros: Macros) -> Source | None:
    """Return a file with its macros expanded; they are left as they are if the result cannot be parsed."""
    text = with_bound_members(text)
    expanded = with_bound_members(macros.expanded(path, text))
    source = parse(folder, path, expanded)
    if expanded != text and source is not None and source.root.has_error:
        plain = parse(folder, path, text)
        if plain is not None and errors_of(plain.root) < errors_of(source.root):
            macros.are_lost(path, text)
            return plain
    return source


def _share(machine: Statements) -> None:
    """Assign threads and answers without a node to the nodes whose ports they use."""
    for todo in machine.todo:
        if todo.owner.node is None and todo.fact.effects:
            used = [each.entity for each in todo.fact.effects]
            nodes = [node for node in machine.nodes if any(entity in used for entity in node.entities)]
            for node in nodes or machine.nodes[:1]:
                if todo.fact not in node.callbacks:
                    node.callbacks.append(todo.fact)


def _callbacks(machine: Statements) -> None:
    done: set[int] = set()
    while True:
        todo = [each for each in machine.todo if id(each) not in done]
        if not todo:
            return
        for each in todo:
            done.add(id(each))
            _read(machine, each)


def _read(machine: Statements, todo: Todo) -> None:
    machine.fact, machine.role = todo.fact, todo.fact.kind
    machine.owner, machine.entity = todo.owner, todo.entity
    machine.cond = machine.loops = machine.off = 0
    machine.changes = []
    machine.calls, machine.frames, machine.holding = [], [], []
    machine.ways_out, machine.asked = [], set()
    machine.block, machine.is_lost = [], False
    todo.fact.effects, todo.fact.body = [], None
    node = _node_of(todo.target)
    if node is None:
        todo.fact.is_open = True
        return
    machine.invoke(todo.target, [], node, Frame(todo.fact.at.file, ""))
    todo.fact.body = machine.body_of(todo.fact, node)
    for effect, fields in fields_of_effects(todo.fact.body or []).items():
        effect.given = fields
    if todo.fact.kind == "service":
        todo.fact.lacks = LATER if is_deferred(node) else ""
    if todo.fact.kind == "accepted" and todo.entity is not None and "execute" not in todo.entity.callbacks:
        todo.entity.callbacks["execute"] = todo.fact
        todo.entity.details["execute"] = todo.fact.name


def _node_of(target: Value) -> Any:
    for each in getattr(target, "options", (target,)):
        node = getattr(each, "node", None)
        if node is not None:
            return node
        for routine in getattr(each, "routines", ()):
            return routine.node
    return None


def _finish(
    node: NodeFact, start: CallbackFact, cls: ClassInfo | None, component: Component | None, is_helper: bool
) -> None:
    """Complete a node with the actions of the main function on its ports, and with its executor.

    Components are not helpers: the executor of their container runs them.
    """
    node.entities = [each for each in node.entities if each.kind not in ("done", "threads")]
    own = set(node.entities)
    # A line names foreign code that receives the node; it cannot use the ports that a class holds.
    used = CallbackFact(start.name, start.kind, start.at)
    used.effects = [each for each in start.effects if each.entity is None or each.entity in own]
    if cls is not None:
        used.name, used.kind, used.at = f"{cls.name} constructor", "constructor", node.at
    if used.effects:
        node.callbacks.append(used)
    node.plugin = "" if cls is None else cls.full
    if node.threads == "not spun" and component is not None and component.executable:
        node.executor = component.executor.rpartition("::")[2]
        node.threads = THREADS.get(node.executor, "open")
    elif node.threads == "not spun" and not node.executor:
        node.threads = "open"
        node.executor = NO_SPIN if is_helper else "open: a component: its container decides"


def _different(nodes: Iterable[NodeFact]) -> list[NodeFact]:
    """Return the nodes without duplicates: of equal nodes of several programs, the first is used."""
    found: dict[tuple[str, str, str], list[NodeFact]] = {}
    for node in nodes:
        same = found.setdefault((str(node.at), node.name, node.cls), [])
        places = {each.at for each in node.entities}
        other = next((each for each in same if places <= {one.at for one in each.entities}), None)
        if other is None:
            same.append(node)
        elif other.program != node.program:
            other.also_in = list(dict.fromkeys([*other.also_in, node.program]))
    return [node for each in found.values() for node in each]
