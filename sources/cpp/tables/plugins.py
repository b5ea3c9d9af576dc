"""Plugins of ``pluginlib``: the classes that a folder exports, with the names by which loaders find them."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from dineros.sources.cpp.parsing import Source
from dineros.sources.folders import SourceFolder

_EXPORTS = ("PLUGINLIB_EXPORT_CLASS", "CLASS_LOADER_REGISTER_CLASS")
_DEFINE = re.compile(
    r"^[ \t]*#[ \t]*define[ \t]+(\w+)\(([\w, \t]*)\)((?:[^\n]*\\\r?\n)*[^\n]*)", re.MULTILINE
)
_CLASS = re.compile(r"<class\b([^>]*)>")
_ATTRIBUTE = re.compile(r"\b(name|type)\s*=\s*[\"']([^\"']*)[\"']")
_LONGEST = 2000
"""Limit of the characters of the arguments of a macro."""


@dataclass(frozen=True)
class Plugin:
    """A class that a loader can create.

    Attributes
    ----------
    cls, base : str
        The class and its base class as they are written, possibly with arguments of a template.
    path : str
        The file that exports it.
    """

    cls: str
    base: str
    path: str


@dataclass(frozen=True)
class Plugins:
    """The plugins of a folder.

    Attributes
    ----------
    exported : list of Plugin
        The classes.
    names : mapping of str to str
        Classes by the names in plugin descriptions.
    """

    exported: list[Plugin] = field(default_factory=list)
    names: Mapping[str, str] = field(default_factory=dict)

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
    """Return the plugins that files in C++ export, also by macros of the folder, and their names."""
    texts = {each.path: each.text.decode(errors="replace") for each in sources}
    macros = {
        found[1]: ([each.strip() for each in found[2].split(",")], found[3].replace("\\\n", " "))
        for text in texts.values()
        if _exports(text)
        for found in _DEFINE.finditer(text)
        if _exports(found[3])
    }
    exported: list[Plugin] = []
    for path, text in texts.items():
        names = [each for each in (*_EXPORTS, *macros) if each in text]
        code = _DEFINE.sub("", text) if names else ""
        for name in names:
            for args in _calls(name, code):
                for cls, base in _expanded(name, args, macros):
                    exported.append(Plugin(cls, base, path))
    return Plugins(list(dict.fromkeys(exported)), _names(folder) if exported else {})


def _expanded(
    name: str, args: list[str], macros: Mapping[str, tuple[list[str], str]]
) -> Iterable[tuple[str, str]]:
    if name in _EXPORTS:
        return [(args[0], args[1])] if len(args) == 2 else []
    parameters, body = macros[name]
    if len(parameters) != len(args):
        return []
    given = dict(zip(parameters, args, strict=True))
    text = re.sub(r"\w+", lambda found: given.get(found[0], found[0]), body)
    return [(each[0], each[1]) for one in _EXPORTS for each in _calls(one, text) if len(each) == 2]


def _exports(text: str) -> bool:
    return any(each in text for each in _EXPORTS)


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
