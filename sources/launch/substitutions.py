"""Evaluates substitutions of launch files: values of arguments, packages and the environment."""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from dineros.sources.language.values import (
    Const,
    Either,
    Items,
    Made,
    Open,
    OutsideMethod,
    Text,
    Value,
    constant,
    hole,
    is_none,
    text_of,
)
from dineros.sources.launch.python_text import worth

_NAMESPACE = "ros_namespace"

_MOST_CHARACTERS = 10_000
"""Limit of the length of a text; a variable that consists of others, and so on, could take all memory."""
_MOST_PARTS = 2_000
"""Limit of the parts of a text, with the parts of its parts."""


@dataclass
class Scope:
    """The scope of the actions that follow."""

    values: dict[str, Value] = field(default_factory=dict)
    """Of launch arguments and other configurations."""
    remappings: dict[str, str] = field(default_factory=dict)
    """Of all nodes."""
    parameters: dict[str, Any] = field(default_factory=dict)
    """Of all nodes."""
    when: tuple[str, ...] = ()
    is_enabled: bool = True
    file: str = ""

    @property
    def namespace(self) -> str:
        """The namespace of all nodes; like ``launch_ros``, the scope keeps it among the configurations."""
        pushed = self.values.get(_NAMESPACE)
        return "" if pushed is None else hole(pushed)

    @namespace.setter
    def namespace(self, name: str) -> None:
        self.values[_NAMESPACE] = Const(name)

    def copy(self) -> Scope:
        """Return a scope whose changes stay in it."""
        return replace(
            self,
            values=dict(self.values),
            remappings=dict(self.remappings),
            parameters=dict(self.parameters),
        )

    def may_become(self, other: Scope) -> None:
        """Take over the changes of another scope that perhaps happen: what differs is unknown afterwards."""
        for key in {**self.values, **other.values}:
            old, new = self.values.get(key), other.values.get(key)
            if (old and hole(old)) != (new and hole(new)):
                said = [hole(each) for each in (old, new) if each is not None]
                self.values[key] = Open(" or ".join(said) if len(said) == 2 else f"{said[0]} or nothing")
        for source, target in other.remappings.items():
            before = self.remappings.get(source, source)
            if before != target:
                self.remappings[source] = hole(Open(f"{before} or {target}"))
        for name, value in other.parameters.items():
            if name not in self.parameters or self.parameters[name] != value:
                self.parameters[name] = hole(Open(f"perhaps {value}"))


class Substitutions:
    """Turns substitutions into texts.

    `given`: values of launch arguments.
    """

    def __init__(self, given: Mapping[str, str]) -> None:
        self.given = dict(given)
        self._parts = 0

    def scalar(self, value: Value | None, scope: Scope) -> Any:
        """Return a value of a parameter: a substitution is read as YAML reads it."""
        if isinstance(value, Const):
            return value.value
        if isinstance(value, Items) and all(isinstance(each, Const) for each in value.items):
            return [constant(each) for each in value.items]
        if isinstance(value, Made) and value.path.endswith("ParameterValue"):
            return self.scalar(value.argument(0, "value"), scope)
        return typed(self.text(value, scope))

    def text(self, value: Value | None, scope: Scope) -> str:
        """Return the text of a substitution; unknown parts are in braces. One that is too long is unknown."""
        before, self._parts = self._parts, self._parts + 1
        try:
            found = self._text(value, scope) if before < _MOST_PARTS else None
        finally:
            self._parts = self._parts if before else 0
        is_short = found is not None and len(found) <= _MOST_CHARACTERS
        return found if is_short and found is not None else hole(Open("a long text"))

    def _text(self, value: Value | None, scope: Scope) -> str:
        if value is None or is_none(value):
            return ""
        if isinstance(value, (Const, Text)):
            return hole(value)
        if isinstance(value, Items):
            return "".join(self.text(each, scope) for each in value.items)
        if isinstance(value, Either):
            return hole(Open(" or ".join(self.text(each, scope) for each in value.options)))
        if isinstance(value, Made):
            return self._substituted(value, scope)
        return hole(value if isinstance(value, (Open, OutsideMethod)) else Open("?"))

    def _substituted(self, made: Made, scope: Scope) -> str:
        last, first = (
            made.path.rpartition(".")[2],
            made.argument(0, "text", "variable_name", "name", "package"),
        )
        if last in ("LaunchConfiguration", "var"):
            name = self.text(first, scope)
            known = scope.values.get(name)
            if known is None and name in self.given:
                known = Const(self.given[name])
            if known is None and made.argument(1, "default") is not None:
                return self.text(made.argument(1, "default"), scope)
            return hole(known) if known is not None else hole(Open(f"argument {name}"))
        if last in ("TextSubstitution",):
            return self.text(made.argument(0, "text"), scope)
        if last == "PathJoinSubstitution":
            parts = made.args[0].items if made.args and isinstance(made.args[0], Items) else []
            return "/".join(self.text(each, scope) for each in parts)
        if last in ("FindPackageShare", "FindPackage", "FindPackagePrefix"):
            return f"$(find {self.text(first, scope)})"
        if last in ("EnvironmentVariable", "EnvVar"):
            default = made.argument(1, "default_value")
            return (
                self.text(default, scope)
                if default is not None
                else hole(Open(f"environment {self.text(first, scope)}"))
            )
        if last == "PythonExpression":
            return self._expression(self.text(made.argument(0, "expression"), scope))
        if last in (
            "NotSubstitution",
            "AndSubstitution",
            "OrSubstitution",
            "EqualsSubstitution",
            "NotEqualsSubstitution",
        ):
            return self._logic(last, [self.text(each, scope) for each in made.args])
        if last in ("ThisLaunchFileDir", "dirname"):
            return scope.file.rpartition("/")[0] or "."
        if last in ("PythonLaunchDescriptionSource", "AnyLaunchDescriptionSource", "Path", "ParameterFile"):
            return self.text(first, scope)
        return hole(Open(last))

    @staticmethod
    def _logic(name: str, texts: list[str]) -> str:
        if name in ("EqualsSubstitution", "NotEqualsSubstitution") and len(texts) == 2:
            if any("{" in each for each in texts):
                return hole(Open(name))
            return str((texts[0] == texts[1]) == name.startswith("Equals")).lower()
        values = [truth_of(each) for each in texts]
        if name == "NotSubstitution" and values and values[0] is not None:
            return str(not values[0]).lower()
        if name == "AndSubstitution":
            return "false" if False in values else "true" if None not in values else hole(Open(name))
        return "true" if True in values else "false" if None not in values else hole(Open(name))

    @staticmethod
    def _expression(text: str) -> str:
        """Return the value of an expression over constants, without executing it."""
        try:
            value = worth(ast.parse(text.strip(), mode="eval").body)
        except (SyntaxError, ValueError, RecursionError, MemoryError, TypeError, ArithmeticError):
            return hole(Open(text))
        return str(value)


def known_or_open(text: str) -> Value:
    """Return a text as a value: a constant, unless a part of it is unknown."""
    return Text(text) if "{" in text else Const(text)


def typed(text: str) -> Any:
    """Convert a text by the rules of YAML: to a number, a truth value, or the text."""
    if text.lower() in ("true", "false"):
        return text.lower() == "true"
    for kind in (int, float):
        try:
            return kind(text) if len(text) < 40 else text
        except ValueError:
            continue
    return text


def truth_of(text: str) -> bool | None:
    """Return whether the text of a condition is true; None: unknown."""
    if "{" in text:
        return None
    return text.strip().lower() in ("true", "1")


def words_of(value: Value | None) -> str:
    """Return a condition as text."""
    if isinstance(value, Made):
        if value.path.endswith("LaunchConfiguration"):
            return text_of(value.argument(0))
        return " ".join(words_of(each) for each in value.args)
    if isinstance(value, Items):
        return "".join(words_of(each) for each in value.items)
    return hole(value)
