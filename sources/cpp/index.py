"""An index of the definitions in C++ files: classes, members, functions, aliases and constants."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, TypeVar

from dineros.sources.cpp.declarators import function_of, is_array, name_of, parameters_of, used
from dineros.sources.cpp.entries import ClassInfo, Routine
from dineros.sources.cpp.parsing import Source, nodes_in, path_of, text_of
from dineros.sources.cpp.tables.enumerators import enumerators_of, value_of
from dineros.sources.cpp.tables.headers import Headers
from dineros.sources.cpp.tables.names import Named, without_branches
from dineros.sources.cpp.tables.parameter_libraries import ParameterLibraries
from dineros.sources.cpp.tables.plugins import Plugins

if TYPE_CHECKING:
    from tree_sitter import Node


_Found = TypeVar("_Found", ClassInfo, Routine, Named)
_COMPONENT = re.compile(rb"\b(?:RCLCPP_COMPONENTS_REGISTER_NODE|CLASS_LOADER_REGISTER_CLASS)\s*\(\s*([\w:]+)")
_CLASS = re.compile(rb"\b(?:struct|class)\s+\w+[^;(){}]*\{")
_MOST_HEADERS = 60
"""Limit of the headers that are searched for one name."""
_AROUND = {
    *("translation_unit", "declaration_list", "preproc_if", "preproc_ifdef", "preproc_else"),
    *("preproc_elif", "linkage_specification", "ERROR"),
}


@dataclass(eq=False)
class Asked:
    """The look-ups in an index."""

    names: set[tuple[str, str]] = field(default_factory=set)
    """Last parts of names, each with the table: ``classes``, ``functions``, ``aliases``, ``constants``,
    ``variables``; and paths of files whose ``includes`` decided.
    """
    interfaces: dict[tuple[str, str], str | None] = field(default_factory=dict)
    """What `find_interface` returned, by name and path."""


class Index:
    """The definitions of all files, which are looked up by name from a location."""

    def __init__(self) -> None:
        self.digests: dict[str, str] = {}
        """Hashes of the files, by path."""
        self.asked: Asked | None = None
        """Records all look-ups; None: they are not recorded."""
        self.classes: dict[str, list[ClassInfo]] = {}
        self.functions: dict[str, list[Routine]] = {}
        self.aliases: dict[str, list[Named]] = {}
        self.constants: dict[str, list[Named]] = {}
        self.enumerators: dict[str, list[Named]] = {}
        self.variables: dict[str, list[Named]] = {}
        self.components: list[tuple[str, str]] = []
        self.headers = Headers()
        self.includes = self.headers.includes
        self.unread: list[str] = []
        """Assumptions about definitions, a line each."""
        self.spaces: dict[str, dict[str, str]] = {}
        """Meanings of names of namespaces, by name and file: ``namespace msgs = sensor_msgs::msg``."""
        self.libraries = ParameterLibraries()
        self.plugins = Plugins()
        """`libraries`, `plugins`: what other files of the folder, or macros, define."""
        self._interfaces: dict[tuple[str, str], str | None] = {}
        self._loose: list[tuple[list[str], Routine]] = []

    def add(self, source: Source) -> None:
        """Add the definitions of a file."""
        self.digests[source.path] = source.digest
        self.headers.add(source.path)
        self._visit(source.root, source.path, "", None, [])
        for found in _COMPONENT.finditer(source.text):
            line = source.text.rfind(b"\n", 0, found.start())
            if b"#define" not in source.text[line + 1 : found.start()]:
                self.components.append((found[1].decode(), source.path))

    def finish(self) -> None:
        """Assign methods that are defined outside of their classes to them."""
        for scope, routine in self._loose:
            cls = self.find_class("::".join(scope), routine.path, routine.space)
            if cls is not None:
                routine.cls = cls
                cls.methods.setdefault(routine.name, []).append(routine)
            else:
                self.functions.setdefault(routine.name, []).append(routine)
        self._loose.clear()
        self.unread += without_branches(self.aliases)

    # ---------------------------------------------------------------------------------------------- finding

    def find_interface(self, name: str, path: str) -> str | None:
        """Return the ROS interface of a name without namespaces, by included headers.

        ``OffboardControlMode`` is of ``<px4_msgs/msg/offboard_control_mode.hpp>``. Headers of the folder are
        followed.
        """
        last = name.rpartition("::")[2]
        if (last, path) not in self._interfaces:
            self._interfaces[last, path] = self._interface(last, path)
        found = self._interfaces[last, path]
        if self.asked is not None:
            self.asked.interfaces[last, path] = found
        return found

    def _interface(self, last: str, path: str) -> str | None:
        snake = re.sub(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", last).lower()
        todo, seen = [path], {path}
        while todo and len(seen) < _MOST_HEADERS:
            found = {
                f"{parts[0]}/{parts[1]}/{last}"
                for each in self.includes.get(todo[0], ())
                if len(parts := each.rpartition(".")[0].split("/")) == 3
                and parts[1] in ("msg", "srv", "action")
                and parts[2] == snake
            }
            if found:
                return found.pop() if len(found) == 1 else None
            for each in self.includes.get(todo.pop(0), ()):
                for other in self.includes:
                    if other not in seen and (other == each or other.endswith(f"/{each}")):
                        seen.add(other)
                        todo.append(other)
        return None

    def unaliased(self, name: str, path: str) -> str:
        """Return a name in a file with the names of namespaces followed."""
        parts = name.split("::")
        for at, each in enumerate(parts if self.spaces else ()):
            known = self.spaces.get(each, {})
            found = {known[path]} if path in known else set(known.values())
            if len(found) == 1 and each not in found:
                parts[at] = next(iter(found))
        return "::".join(parts)

    def find_class(self, name: str, path: str, space: str) -> ClassInfo | None:
        """Return the class of a name at a location; None: unknown or ambiguous."""
        return self._nearest(self._named("classes", self.classes, name), name, path, space)

    def find_alias(self, name: str, path: str, space: str) -> Node | None:
        """Return the type that an alias means at a place."""
        found = self._nearest(self._named("aliases", self.aliases, name), name, path, space)
        return None if found is None else found.node

    def find_constant(self, name: str, path: str, space: str) -> Named | None:
        """Return the constant that a name means at a place."""
        return self._nearest(self._named("constants", self.constants, name), name, path, space)

    def find_enumerator(self, name: str, path: str, space: str) -> int | None:
        """Return the number of the enumerator that a name means at a place; None: unknown or ambiguous."""
        every = self._named("enumerators", self.enumerators, name)
        found = self._nearest(every, name, path, space)
        if found is None:
            return None
        same = [each for each in every if each.full == found.full]
        here = [each for each in same if each.path == path]
        values = {value_of(each.node) for each in here or same}
        return values.pop() if len(values) == 1 else None

    def find_variable(self, name: str, path: str, space: str) -> str | None:
        """Return the full name of the global variable, or static member, that a name means at a place."""
        found = self._named("variables", self.variables, name)
        if not found:
            return None
        nearest = self._nearest(found, name, path, space)
        full = {each.full for each in found if f"::{each.full}".endswith(f"::{name.lstrip(':')}")}
        return nearest.full if nearest is not None else full.pop() if len(full) == 1 else None

    def find_functions(self, name: str, path: str) -> list[Routine]:
        """Return the functions that a name may refer to: of its namespace, then of the same file."""
        found = self._named("functions", self.functions, name)
        ends = f"::{name.lstrip(':')}"
        found = [each for each in found if f"::{_full(each)}".endswith(ends)] or found
        here = [each for each in found if each.path == path]
        return here or found

    def _nearest(self, found: list[_Found], name: str, path: str, space: str) -> _Found | None:
        """Resolve a name at a location: by namespaces, by included headers, by folders; None: ambiguous."""
        ends = f"::{name.lstrip(':')}"
        fitting = [each for each in found if f"::{_full(each)}".endswith(ends)]
        if len(fitting) < 2:
            return fitting[0] if fitting else None
        best = max(_rank(each, path, space) for each in fitting)
        fitting = [each for each in fitting if _rank(each, path, space) == best]
        if len(fitting) > 1:
            if self.asked is not None:
                self.asked.names.add(("includes", path))
            paths = self.headers.nearest(path, {each.path for each in fitting})
            fitting = [each for each in fitting if each.path in paths]
        is_one = all(text_of(each.node) == text_of(fitting[0].node) for each in fitting[1:])
        return fitting[0] if is_one else None

    def _named(self, kind: str, table: dict[str, list[_Found]], name: str) -> list[_Found]:
        """Return all that a table has under the last part of a name."""
        last = name.rpartition("::")[2]
        if self.asked is not None:
            self.asked.names.add((kind, last))
        return table.get(last, [])

    def meaning(self, kind: str, last: str) -> list[list[object]]:
        """Return the entries of a table for a name, as locations and hashes of files, to detect changes."""
        tables: dict[str, Mapping[str, Sequence[ClassInfo | Routine | Named]]] = {
            "classes": self.classes,
            "functions": self.functions,
            "aliases": self.aliases,
            "constants": self.constants,
            "enumerators": self.enumerators,
            "variables": self.variables,
        }
        if kind == "includes":
            return [[each] for each in sorted(self.headers.included(last))]
        found: list[list[object]] = []
        for each in tables[kind].get(last, ()):
            inner = each.methods.values() if isinstance(each, ClassInfo) else ()
            for part in (each, *(routine for routines in inner for routine in routines)):
                found.append([_full(part), part.path, self.digests[part.path], part.node.start_byte])
        return found

    def all_classes(self) -> Iterator[ClassInfo]:
        """Yield all classes."""
        for found in self.classes.values():
            yield from found

    # --------------------------------------------------------------------------------------------- visiting

    def _visit(self, node: Node, path: str, space: str, cls: ClassInfo | None, templates: list[str]) -> None:
        for child in node.named_children:
            self._visit_one(child, path, space, cls, templates)

    def _visit_one(
        self, node: Node, path: str, space: str, cls: ClassInfo | None, templates: list[str]
    ) -> None:
        kind = node.type
        if kind in _AROUND:
            self._visit(node, path, space, cls, templates)
        elif kind == "namespace_definition":
            name, body = path_of(node.child_by_field_name("name")), node.child_by_field_name("body")
            if body is not None:
                self._visit(body, path, "::".join(filter(None, (space, name))), None, [])
        elif kind == "template_declaration":
            names = [_template(each) for each in _inner(node.child_by_field_name("parameters"))]
            for child in node.named_children:
                if child.type != "template_parameter_list":
                    self._visit_one(child, path, space, cls, names)
        elif kind in ("class_specifier", "struct_specifier"):
            self._class(node, path, space, templates)
        elif kind == "enum_specifier":
            self._enumeration(node, path, cls.full if cls is not None else space)
        elif kind == "function_definition":
            self._function(node, path, space, cls, templates)
            self._local_classes(node, path, cls.full if cls is not None else space)
        elif kind == "friend_declaration":
            for child in node.named_children:
                if child.type == "function_definition":
                    self._function(child, path, cls.space if cls is not None else space, None, templates)
        elif kind in ("alias_declaration", "type_definition"):
            self._enumeration(node.child_by_field_name("type"), path, cls.full if cls is not None else space)
            self._alias(node, path, cls.full if cls else space)
        elif kind == "using_declaration" and cls is None:
            other = used(node)
            if other is not None:
                self._name(self.aliases, path_of(other).rpartition("::")[2], space, path, other)
        elif kind == "namespace_alias_definition":
            meaning = path_of(node.named_children[-1]).lstrip(":")
            self.spaces.setdefault(path_of(node.child_by_field_name("name")), {})[path] = meaning
        elif kind == "preproc_include":
            header = text_of(node.child_by_field_name("path")).strip('<>"')
            self.includes.setdefault(path, []).append(header)
        elif kind == "preproc_def":
            value = node.child_by_field_name("value")
            if value is not None:
                self._name(self.constants, text_of(node.child_by_field_name("name")), "", path, value)
        elif kind in ("declaration", "field_declaration"):
            self._declaration(node, path, space, cls, templates)

    def _class(self, node: Node, path: str, space: str, templates: list[str]) -> None:
        body, name = node.child_by_field_name("body"), path_of(node.child_by_field_name("name"))
        if body is None or not name:
            return
        scope, _, last = name.rpartition("::")
        space = "::".join(filter(None, (space, scope)))
        cls = ClassInfo(last, space, path, node, templates=templates)
        for child in node.named_children:
            if child.type == "base_class_clause":
                cls.bases = [
                    each
                    for each in child.named_children
                    if each.type not in ("access_specifier", "comment", "virtual")
                ]
        self.classes.setdefault(last, []).append(cls)
        self._visit(body, path, cls.full, cls, [])

    def _function(
        self, node: Node, path: str, space: str, cls: ClassInfo | None, templates: list[str]
    ) -> None:
        declarator = function_of(node.child_by_field_name("declarator"))
        if declarator is None:
            self._conversion(node, path, space, cls)
            return
        parts = path_of(declarator.child_by_field_name("declarator")).split("::")
        routine = Routine(parts[-1], node, path, space, cls, parameters_of(declarator), templates)
        if cls is not None:
            cls.methods.setdefault(routine.name, []).append(routine)
        elif len(parts) > 1:
            self._loose.append((parts[:-1], routine))
        else:
            self.functions.setdefault(routine.name, []).append(routine)

    def _conversion(self, node: Node, path: str, space: str, cls: ClassInfo | None) -> None:
        """Add an operator that converts an object to another type, such as ``operator bool``."""
        declarator = node.child_by_field_name("declarator")
        scope: list[str] = []
        while declarator is not None and declarator.type == "qualified_identifier":
            scope.append(path_of(declarator.child_by_field_name("scope")))
            declarator = declarator.child_by_field_name("name")
        if declarator is None or declarator.type != "operator_cast":
            return
        name = f"operator {path_of(declarator.child_by_field_name('type'))}"
        routine = Routine(name, node, path, space, cls)
        if cls is not None:
            cls.methods.setdefault(name, []).append(routine)
        else:
            self._loose.append((scope, routine))

    def _local_classes(self, node: Node, path: str, space: str) -> None:
        """Add the classes that a function defines."""
        body = node.child_by_field_name("body")
        if body is None or _CLASS.search(body.text or b"") is None:
            return
        for each in nodes_in(body):
            if each.type in ("class_specifier", "struct_specifier"):
                self._class(each, path, space, [])

    def _enumeration(self, node: Node | None, path: str, space: str) -> None:
        if node is not None and node.type == "enum_specifier":
            for last, around, each in enumerators_of(node, space):
                self._name(self.enumerators, last, around, path, each)

    def _alias(self, node: Node, path: str, space: str) -> None:
        name = node.child_by_field_name("name") or node.child_by_field_name("declarator")
        kind = node.child_by_field_name("type")
        if name is not None and kind is not None:
            self._name(self.aliases, text_of(name), space, path, kind)

    def _name(self, table: dict[str, list[Named]], name: str, space: str, path: str, node: Node) -> None:
        full = f"{space}::{name}" if space else name
        table.setdefault(name, []).append(Named(full, path, node))

    def _declaration(
        self, node: Node, path: str, space: str, cls: ClassInfo | None, templates: list[str]
    ) -> None:
        kind = node.child_by_field_name("type")
        if kind is not None and kind.type in ("class_specifier", "struct_specifier"):
            self._class(kind, path, space, templates)
        self._enumeration(kind, path, cls.full if cls is not None else space)
        default = node.child_by_field_name("default_value")
        is_static = any(each.type == "storage_class_specifier" for each in node.children)
        is_fixed = any(text_of(each) in ("const", "constexpr") for each in node.children)
        for declarator in node.children_by_field_name("declarator"):
            value = default
            if declarator.type == "init_declarator":
                value = declarator.child_by_field_name("value")
            function = function_of(declarator)
            if function is not None and cls is not None:
                name = path_of(function.child_by_field_name("declarator"))
                cls.defaults.setdefault(name, []).append(parameters_of(function))
                continue
            name = name_of(declarator)
            if cls is not None and not is_static:
                cls.fields[name] = (kind, value)
                if is_array(declarator):
                    cls.arrays.add(name)
                if declarator.type in ("pointer_declarator", "reference_declarator"):
                    cls.pointers.add(name)
            elif name and function is None:
                scope, _, last = name.rpartition("::")
                around = "::".join(filter(None, (space, scope)))
                if value is not None:
                    self._name(self.constants, last, around, path, value)
                if not is_fixed:
                    self._name(self.variables, last, around, path, declarator)


def _inner(node: Node | None) -> list[Node]:
    return [] if node is None else node.named_children


def _template(node: Node) -> str:
    name = node.child_by_field_name("declarator") or node.child_by_field_name("name")
    if name is None and node.named_children:
        name = node.named_children[-1]
    return text_of(name)


def _full(found: ClassInfo | Routine | Named) -> str:
    return f"{found.space}::{found.name}" if isinstance(found, Routine) else found.full


def _rank(found: ClassInfo | Routine | Named, path: str, space: str) -> tuple[bool, int]:
    around = _full(found).rpartition("::")[0]
    is_inside = space == around or space.startswith(f"{around}::") or not around
    return found.path == path, len(around) if is_inside else -1
