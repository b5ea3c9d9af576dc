"""Converts launch files in XML and YAML to the actions of launch files in Python."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from lxml import etree

from dineros.metamodel.errors import ModelFileError
from dineros.metamodel.files.xml import attributes_of, line_of, parse_bytes
from dineros.sources.language.values import Const, Items, Made, Open, Value
from dineros.sources.language.values import Mapping as Table
from dineros.sources.launch.substitutions import typed
from dineros.sources.launch.yaml_text import Part, UnreadableError, parts_of
from dineros.sources.places import Place

_GROUPS = ("group", "timer")
_CONTAINERS = ("node_container", "load_composable_node")
Entity = tuple[str, dict[str, Any], list[Any], int]
"""An element: its tag, its attributes, its inner elements, its line."""


def actions_of_xml(text: str, path: str) -> list[Value]:
    """Return the actions of a launch file in XML.

    Raises
    ------
    UnreadableError
        The text is not XML.
    """
    try:
        root = parse_bytes(text.encode(), Path(path)).getroot()
    except ModelFileError as error:
        raise UnreadableError(error.message) from error
    return [_action(each, path) for each in _inner(root)] if root.tag == "launch" else []


def _inner(element: etree._Element) -> list[Entity]:
    children = element.iterchildren("*")  # comments are ignored
    return [(str(each.tag), dict(attributes_of(each)), _inner(each), line_of(each) or 1) for each in children]


def actions_of_yaml(text: str, path: str) -> list[Value]:
    """Return the actions of a launch file in YAML.

    Raises
    ------
    UnreadableError
        The text is not YAML.
    """
    root = parts_of(text)
    inner = root.value.get("launch") if isinstance(root.value, dict) else None
    return [_action(each, path) for each in _entities(inner)] if inner is not None else []


def _entities(part: Part | None) -> list[Entity]:
    found: list[Entity] = []
    for each in part.value if part is not None and isinstance(part.value, list) else []:
        if isinstance(each.value, dict):
            found += [_entity(tag, value) for tag, value in each.value.items()]
    return found


def _entity(tag: str, part: Part) -> Entity:
    attributes: dict[str, Any] = {}
    inner: list[Entity] = []
    if isinstance(part.value, list):
        inner = _entities(part)
    for key, value in part.value.items() if isinstance(part.value, dict) else ():
        if isinstance(value.value, list) and tag in _GROUPS:
            inner += _entities(value)
        elif isinstance(value.value, list) and tag in _CONTAINERS and key == "composable_node":
            inner += [_entity("composable_node", each) for each in value.value]
        elif isinstance(value.value, list):
            inner += [_entity(key, each) for each in value.value]
        else:
            attributes[key] = value.plain()
    return (
        tag,
        attributes,
        inner,
        part.line - (1 if tag not in ("param", "remap", "arg", "composable_node") else 0),
    )


def _action(entity: Entity, path: str) -> Value:
    """Convert an element to an equivalent action."""
    tag, attributes, inner, line = entity
    keys = {key: parsed(value) for key, value in attributes.items()}
    at = Place(path, line)

    def made(kind: str, **more: Value) -> Made:
        found = Made(f"launch.{kind}", [], {**more}, at)
        for word, condition in (("if", "IfCondition"), ("unless", "UnlessCondition")):
            if word in keys:
                found.keys["condition"] = Made(f"launch.{condition}", [keys[word]], {}, at)
        return found

    if tag == "arg":
        default = {"default_value": keys["default"]} if "default" in keys else {}
        return made("DeclareLaunchArgument", name=keys.get("name", Const("")), **default)
    if tag in ("let", "set_parameter", "set_remap"):
        kinds = {"let": "SetLaunchConfiguration", "set_parameter": "SetParameter", "set_remap": "SetRemap"}
        source, target = keys.get("name", keys.get("from")), keys.get("value", keys.get("to"))
        first, second = ("src", "dst") if tag == "set_remap" else ("name", "value")
        return made(kinds[tag], **{first: source or Const(""), second: target or Const("")})
    if tag in ("push_ros_namespace", "push-ros-namespace"):
        return made("PushRosNamespace", namespace=keys.get("namespace", Const("")))
    if tag == "group":
        scoped = {key: keys[key] for key in ("scoped", "forwarding") if key in keys}
        return made("GroupAction", actions=Items([_action(each, path) for each in inner]), **scoped)
    if tag == "timer":
        actions = Items([_action(each, path) for each in inner])
        return made("TimerAction", period=keys.get("period", Const("")), actions=actions)
    if tag == "include":
        pairs: list[Value] = [
            Items([Const(e[1].get("name", "")), parsed(e[1].get("value", ""))])
            for e in inner
            if e[0] in ("arg", "let")
        ]
        source_of = Made("launch.AnySource", [keys.get("file", Const(""))], {}, at)
        return made(
            "IncludeLaunchDescription", launch_description_source=source_of, launch_arguments=Items(pairs)
        )
    if tag in ("node", "lifecycle_node", "node_container", "composable_node"):
        return _node(made, tag, keys, inner, path)
    if tag == "load_composable_node":
        components = [_action(each, path) for each in inner if each[0] == "composable_node"]
        target_of = keys.get("target", Const(""))
        return made(
            "LoadComposableNodes", target_container=target_of, composable_node_descriptions=Items(components)
        )
    return Open(tag)


def _node(made: Any, tag: str, keys: dict[str, Value], inner: Iterable[Entity], path: str) -> Value:
    names = {"lifecycle_node": "LifecycleNode", "node_container": "ComposableNodeContainer"}
    found: Made = made(names.get(tag, "ComposableNode" if tag == "composable_node" else "Node"))
    for key, given in (
        ("pkg", "package"),
        ("exec", "executable"),
        ("name", "name"),
        ("namespace", "namespace"),
        ("plugin", "plugin"),
    ):
        if key in keys:
            found.keys[given] = keys[key]
    if "args" in keys and isinstance(keys["args"], Const):
        found.keys["arguments"] = Items([Const(each) for each in str(keys["args"].value).split()])
    remappings: list[Value] = []
    parameters: list[Value] = []
    components: list[Value] = []
    for entity in inner:
        inner_tag, attributes, children, _ = entity
        if inner_tag == "remap":
            remappings.append(Items([parsed(attributes.get("from", "")), parsed(attributes.get("to", ""))]))
        elif inner_tag == "param":
            parameters.append(_parameter(attributes, children))
        elif inner_tag == "composable_node":
            components.append(_action(entity, path))
    found.keys |= {"remappings": Items(remappings), "parameters": Items(parameters)}
    if components:
        found.keys["composable_node_descriptions"] = Items(components)
    return found


def _parameter(attributes: dict[str, Any], children: Iterable[Entity]) -> Value:
    if "from" in attributes:
        return Made("launch.ParameterFile", [parsed(attributes["from"])], {}, Place("", 0))
    name = str(attributes.get("name", ""))
    if "value" in attributes:
        value = attributes["value"]
        read = parsed(value)
        if isinstance(read, Const) and isinstance(read.value, str):
            read = Const(typed(read.value))
        return Table({name: read})
    inner = Table()
    for child in children:
        found = _parameter(child[1], child[2])
        if isinstance(found, Table):
            inner.items |= found.items
    return Table({name: inner})


def parsed(value: Any) -> Value:
    """Return a text with ``$(...)`` as the substitutions that it names."""
    if not isinstance(value, str) or "$(" not in value or len(value) > _MOST_TEXT:
        return Const(value)
    found: list[Value] = []
    end = 0
    while (start := value.find("$(", end)) >= 0:
        stop = _closing(value, start + 1)
        if stop is None:
            break
        if start > end:
            found.append(Const(value[end:start]))
        word, _, rest = value[start + 2 : stop].strip().partition(" ")
        found.append(_substitution(word, rest.strip()))
        end = stop + 1
    if end < len(value):
        found.append(Const(value[end:]))
    return found[0] if len(found) == 1 else Items(found)


_MOST_TEXT = 10_000


def _closing(text: str, start: int) -> int | None:
    """Return the position of the closing bracket for an opening one."""
    depth = 0
    for index in range(start, len(text)):
        depth += {"(": 1, ")": -1}.get(text[index], 0)
        if depth == 0:
            return index
    return None


def _words(text: str) -> list[str]:
    """Return the arguments of a substitution: words, texts in quotes, and inner substitutions."""
    found: list[str] = []
    word, depth, quote = "", 0, ""
    for letter in f"{text} ":
        if not quote and not depth and letter.isspace():
            found += [_unquoted(word)] if word else []
            word = ""
            continue
        word += letter
        if letter in "'\"" and quote in ("", letter):
            quote = "" if quote else letter
        elif not quote:
            depth += {"(": 1, ")": -1}.get(letter, 0)
    return found


def _unquoted(text: str) -> str:
    """Return a text without the quotes around it."""
    if len(text) > 1 and text[0] == text[-1] and text[0] in "'\"":
        return text[1:-1].replace(f"\\{text[0]}", text[0])
    return text


def _substitution(word: str, rest: str) -> Value:
    at = Place("", 0)
    inner = parsed(_unquoted(rest))
    names = {
        **{"var": "LaunchConfiguration", "find-pkg-share": "FindPackageShare", "eval": "PythonExpression"},
        **{"env": "EnvironmentVariable", "dirname": "ThisLaunchFileDir", "not": "NotSubstitution"},
        **{"find-pkg-prefix": "FindPackagePrefix"},
    }
    pairs = {
        **{"and": "AndSubstitution", "or": "OrSubstitution"},
        **{"equals": "EqualsSubstitution", "not-equals": "NotEqualsSubstitution"},
    }
    words = _words(rest)
    if word in pairs and len(words) == 2:
        return Made(f"launch.{pairs[word]}", [parsed(each) for each in words], {}, at)
    if word in names:
        args: list[Value] = [inner]
        if word == "env" and isinstance(inner, Const) and " " in str(inner.value):
            name, _, default = str(inner.value).partition(" ")
            args = [Const(name), Const(default.strip().strip("'\""))]
        return Made(f"launch.{names[word]}", args, {}, at)
    return Open(f"{word} {rest}".strip())
