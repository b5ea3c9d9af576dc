"""The reference of classes and functions, made from their docstrings while the guide is built.

Docstrings are in numpy's form: sections with a line of hyphens below their names, entries ``name : type``
with their text indented.
"""

from __future__ import annotations

import ast
import inspect
import re
import textwrap
from importlib import import_module
from itertools import pairwise
from typing import Any

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from dineros.metamodel.base import features_of

MODULES = {
    "dineros.metamodel.pn": "Nets",
    "dineros.metamodel.sym": "System models",
    "dineros.metamodel.build": "Building models",
    "dineros.metamodel.elements": "Finding elements",
    "dineros.metamodel.files": "Model files",
    "dineros.metamodel.constraints": "Constraints",
    "dineros.metamodel.errors": "Errors",
    "dineros.transformations.flattening.flatten": "Flattening",
    "dineros.transformations.flattening.split": "Splitting",
    "dineros.analysis.checks.check": "Checking",
    "dineros.analysis.conformance": "Conformance",
    "dineros.generators": "Generating",
    "dineros.runtime": "Running",
}
"""What is shown, by module."""

INTRODUCTION = """# Classes and functions

What Python programs use, as the docstrings say it. [Metamodels](metamodels.md) draws how the classes of
models belong together.
"""
_READ_AS = re.compile(r"^(?:Choice|Mandatory)\[(.*)\]$")
"""Static views of a single value, which the reference does not show."""
_SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}\n", re.MULTILINE)
_ENTRIES = ("Parameters", "Attributes", "Returns", "Raises", "Yields", "Other Parameters")


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the page to the guide; the hook that MkDocs calls."""
    files.append(File.generated(config, "classes.md", content=page()))
    return files


def page() -> str:
    """Return the page, in Markdown."""
    parts = [INTRODUCTION]
    for name, title in MODULES.items():
        module = import_module(name)
        first = (inspect.getdoc(module) or "").partition("\n")[0]
        parts.append(f"## {title}\n\n`{name}`: {_inline(first)}")
        parts += [_described(name, member, value) for member, value in members(module)]
    return "\n\n".join(parts) + "\n"


def members(module: Any) -> list[tuple[str, Any]]:
    """Return the public classes and functions of a module, in its order or that of its `__all__`."""
    names = getattr(module, "__all__", None)
    if names is None:
        found = vars(module).items()
        names = [name for name, value in found if getattr(value, "__module__", "") == module.__name__]
    values = [(name, getattr(module, name)) for name in names if not name.startswith("_")]
    return [(name, value) for name, value in values if inspect.isclass(value) or inspect.isfunction(value)]


def _described(module: str, name: str, value: Any) -> str:
    shown = [f"### {name} {{ #{module}.{name} }}", _signature(name, value), documented(_docstring(value))]
    if inspect.isclass(value):
        for method, member in vars(value).items():
            function = getattr(member, "__func__", member)
            if not method.startswith("_") and inspect.isfunction(function) and function.__doc__:
                shown += [_signature(f"{name}.{method}", function), documented(inspect.getdoc(function))]
    return "\n\n".join(filter(None, shown))


def _docstring(value: Any) -> str | None:
    """Return a docstring; for a class of a metamodel, with the texts that follow its features."""
    found = inspect.getdoc(value)
    if not hasattr(value, "eClass"):
        return found
    (described,) = ast.parse(inspect.getsource(value)).body
    assert isinstance(described, ast.ClassDef)
    entries = []
    for feature, below in pairwise(described.body):
        if isinstance(feature, ast.AnnAssign) and isinstance(below, ast.Expr):
            text = " ".join(ast.literal_eval(below.value).split())
            hint = _READ_AS.sub(r"\1", ast.unparse(feature.annotation))
            entries.append(f"{ast.unparse(feature.target)} : {hint}\n    {text}")
    return "\n".join([f"{found}\n\nAttributes\n----------", *entries]) if entries else found


def _signature(name: str, value: Any) -> str:
    """Return how something is called; features of the metamodels' classes are keywords, listed below."""
    if hasattr(value, "eClass"):
        shown = [
            inspect.Parameter(each, inspect.Parameter.KEYWORD_ONLY, default=None)
            for each in features_of(value)
        ]
    else:
        try:
            signature = inspect.signature(value.__init__ if inspect.isclass(value) else value)
        except (TypeError, ValueError):
            return ""
        shown = [each for each in signature.parameters.values() if each.name != "self"]
    words, is_keyword = [], False
    for each in shown:
        if each.kind is each.KEYWORD_ONLY and not is_keyword:
            words.append("*")
        is_keyword = is_keyword or each.kind in (each.KEYWORD_ONLY, each.VAR_POSITIONAL)
        stars = "*" if each.kind is each.VAR_POSITIONAL else "**" if each.kind is each.VAR_KEYWORD else ""
        words.append(f"{stars}{each.name}{'' if each.default is each.empty else '=...'}")
    lines = textwrap.wrap(f"{name}({', '.join(words)})", 100, subsequent_indent="    ")
    return "```text\n" + "\n".join(lines) + "\n```"


def documented(docstring: str | None) -> str:
    """Return a docstring in Markdown."""
    if not docstring:
        return ""
    first, *rest = _SECTION.split(docstring)
    parts = [_inline(first.strip())]
    for title, text in zip(rest[::2], rest[1::2], strict=True):
        parts.append(f"**{title}**")
        if title in _ENTRIES:
            parts.append(_entries(text))
        elif title == "Examples":
            parts.append(f"```python\n{text.strip()}\n```")
        else:
            parts.append(_inline(text.strip()))
    return "\n\n".join(parts)


def _entries(text: str) -> str:
    """Return the entries of a section as a list."""
    lines: list[str] = []
    for line in text.strip("\n").splitlines():
        if line and not line[0].isspace():
            name, _, kind = line.partition(" : ")
            lines.append(f"* `{name}`{f' (`{kind}`)' if kind else ''}: ")
        elif line.strip() and lines:
            lines[-1] += f"{_inline(line.strip())} "
    return "\n".join(line.rstrip(" :") if line.endswith(": ") else line.rstrip() for line in lines)


def _inline(text: str) -> str:
    """Return prose, with code in single backticks, and roles and angle brackets harmless."""
    text = text.replace("``", "`")
    parts = text.split("`")
    return "`".join(
        part if number % 2 else re.sub(r"([*_<\[\]])", r"\\\1", part) for number, part in enumerate(parts)
    )
