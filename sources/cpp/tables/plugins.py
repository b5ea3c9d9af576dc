"""Plugins of ``pluginlib``: the classes that a folder exports, with the names by which loaders find them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from dineros.sources.cpp.parsing import Source
from dineros.sources.folders import SourceFolder

_EXPORTS = ("PLUGINLIB_EXPORT_CLASS", "CLASS_LOADER_REGISTER_CLASS")
_DEFINE = re.compile(r"^[ \t]*#[ \t]*define\b(?:[^\n]*\\\r?\n)*[^\n]*", re.MULTILINE)
_CLASS = re.compile(r"<class\b([^>]*)>")
_ATTRIBUTE = re.compile(r"\b(name|type)\s*=\s*[\"']([^\"']*)[\"']")
_LONGEST = 2000
"""Limit of the characters of the arguments of a macro."""


@dataclass(frozen=True)
class Plugin:
    """A class that a loader can create."""

    cls: str
    base: str
    """`cls`, `base`: the class and its base class as they are written, possibly with arguments of a template.
    """
    path: str
    """The file that exports it."""


@dataclass(frozen=True)
class Plugins:
    """The plugins of a folder."""

    exported: list[Plugin] = field(default_factory=list)
    """The classes."""
    names: Mapping[str, str] = field(default_factory=dict)
    """Classes by the names in plugin descriptions."""

    def of(self, base: str) -> list[Plugin]:
        """Return the plugins with a base class."""
        wanted = _plain(base)
        return [each for each in self.exported if _plain(each.base) == wanted]

    def class_named(self, name: str) -> str:
        """Return the class that a name means to a loader."""
        return _plain(self.names.get(name, name.replace("/", "::")))


def is_plugin(plugin: Plugin, cls: str) -> bool:
    """Return whether a plugin has a class."""
    return _plain(plugin.cls) == cls


def read_plugins(folder: SourceFolder, sources: Iterable[Source]) -> Plugins:
    """Return the plugins that files in C++ export, with their macros expanded, and their names."""
    exported: list[Plugin] = []
    for source in sources:
        text = source.text.decode(errors="replace")
        names = [each for each in _EXPORTS if each in text]
        code = _DEFINE.sub("", text) if names else ""
        for name in names:
            found = (args for args in _calls(name, code) if len(args) == 2)
            exported += [Plugin(cls, base, source.path) for cls, base in found]
    return Plugins(list(dict.fromkeys(exported)), _names(folder) if exported else {})


def _calls(name: str, text: str) -> Iterable[list[str]]:
    """Yield the arguments of each use of a macro; commas inside of brackets do not separate them."""
    for found in re.finditer(rf"\b{name}\s*\(", text):
        parts, depth = [""], 0
        for letter in text[found.end() : found.end() + _LONGEST]:
            depth += (letter in "(<") - (letter in ")>")
            if depth < 0:
                yield [" ".join(each.split()) for each in parts]
                break
            if letter == "," and depth == 0:
                parts.append("")
            else:
                parts[-1] += letter


def _names(folder: SourceFolder) -> dict[str, str]:
    found: dict[str, str] = {}
    for path in folder.files:
        text = (folder.read(path) or "") if path.endswith(".xml") else ""
        if "base_class_type" not in text:
            continue
        for each in _CLASS.finditer(text):
            given = dict(_ATTRIBUTE.findall(each[1]))
            if given.get("type"):
                found[given.get("name") or given["type"].replace("::", "/")] = given["type"]
    return found


def _plain(name: str) -> str:
    return "".join(name.split()).removeprefix("::")
