"""Reads from a ``CMakeLists.txt`` what is installed: programs with their sources, components, and scripts."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from itertools import pairwise

_COMMENT = re.compile(r"#\[\[.*?\]\]|#[^\n]*", re.DOTALL)
_COMMAND = re.compile(r"\b([A-Za-z_]\w*)\s*\(([^()]*(?:\([^()]*\)[^()]*)*)\)")
_WORD = re.compile(r'"([^"]*)"|([^\s"]+)')
_VARIABLE = re.compile(r"\$\{(\w+)\}")
_PROGRAMS = {"add_executable", "ament_auto_add_executable", "catkin_add_executable"}
_COMPONENTS = {"rclcpp_components_register_node", "rclcpp_components_register_nodes"}
MOST_VALUES = 2000
"""Limit of the words of a variable."""
LONGEST_WORD = 4096
"""Limit of the characters of a word; a variable that contains itself twice doubles with each line."""


@dataclass(frozen=True)
class Component:
    """A component that is registered."""

    plugin: str
    """Its class."""
    executable: str = ""
    """The program that runs only this component; empty: none."""
    executor: str = "SingleThreadedExecutor"
    """The class of executor of that program."""


@dataclass(eq=False)
class Built:
    """Targets that a ``CMakeLists.txt`` builds and installs; paths are relative to its folder."""

    sources: dict[str, list[str]] = field(default_factory=dict)
    """Sources of programs in C++."""
    components: list[Component] = field(default_factory=list)
    """What is registered."""
    scripts: list[str] = field(default_factory=list)
    """Scripts that are installed as programs."""


def read_cmake(text: str) -> Built:
    """Return the targets that a ``CMakeLists.txt`` builds and installs; all conditions count as true.

    >>> built = read_cmake('project(robot) add_executable(${PROJECT_NAME}_node src/main.cpp)')
    >>> built.sources
    {'robot_node': ['src/main.cpp']}
    """
    values: dict[str, list[str]] = {}
    built = Built()
    for command in _COMMAND.finditer(_COMMENT.sub("", text)):
        name, words = command[1].lower(), _words(command[2], values)
        if name == "project" and words:
            values["PROJECT_NAME"] = [words[0]]
        elif name == "set" and words:
            values[words[0]] = words[1:MOST_VALUES]
        elif name in _PROGRAMS and words:
            built.sources.setdefault(words[0], []).extend(
                word for word in words[1:] if word not in ("WIN32", "MACOSX_BUNDLE", "EXCLUDE_FROM_ALL")
            )
        elif name == "target_sources" and words and words[0] in built.sources:
            built.sources[words[0]].extend(word for word in words[1:] if "." in word)
        elif name in _COMPONENTS and words:
            _register(words[1:], built)
        elif name == "install" and words[:1] == ["PROGRAMS"]:
            end = words.index("DESTINATION") if "DESTINATION" in words else len(words)
            built.scripts += [word for word in words[1:end] if "$" not in word]
    return built


def _words(text: str, values: dict[str, list[str]]) -> list[str]:
    """Return the arguments of a command, with the values of variables."""
    found: list[str] = []
    for match in _WORD.finditer(text):
        word = match[1] if match[1] is not None else match[2]
        whole = _VARIABLE.fullmatch(word)
        if whole and whole[1] in values and match[1] is None:
            found += values[whole[1]]
        else:
            found.append(
                _VARIABLE.sub(lambda one: ";".join(values.get(one[1], [one[0]])), word)[:LONGEST_WORD]
            )
        if len(found) > MOST_VALUES:
            break
    return found


def _register(words: list[str], built: Built) -> None:
    """Add the component of a call of ``rclcpp_components_register_node``."""
    given = {"PLUGIN": "", "EXECUTABLE": "", "EXECUTOR": ""}
    if not given.keys() & set(words):
        built.components += [Component(word) for word in words]
        return
    for key, value in pairwise(words):
        if key in given:
            given[key] = value
    executor = given["EXECUTOR"] or "SingleThreadedExecutor"
    built.components.append(Component(given["PLUGIN"], given["EXECUTABLE"], executor))
