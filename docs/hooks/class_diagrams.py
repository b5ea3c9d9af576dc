"""Class diagrams of the metamodels, drawn from the ``.ecore`` files while the guide is built.

A class shows its attributes; a hollow arrow leads to the class it extends, a line with a diamond to what it
contains, a plain arrow to what it refers to. Classes of another metamodel are grey.
"""

from __future__ import annotations

import html
import logging
import shutil
import subprocess
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from pyecore.ecore import EAttribute, EClass, EEnum, EPackage, EReference
from pyecore.resources import URI, ResourceSet

METAMODELS = ("pn", "sym", "rtm", "pnm", "trace")
TYPES = {
    "EInt": "Integer",
    "EIntegerObject": "Integer",
    "EDouble": "Number",
    "EDoubleObject": "Number",
    "EBoolean": "Boolean",
    "EString": "Text",
}
FOLDER = Path(__file__).resolve().parents[2] / "metamodel"
LOG = logging.getLogger("mkdocs.hooks.class_diagrams")

HEAD = """digraph {
  graph [bgcolor=white, nodesep=0.18, ranksep=0.4, fontname="Helvetica", pad=0.1]
  node [shape=plain, fontname="Helvetica", fontsize=12]
  edge [fontname="Helvetica", fontsize=11, color="#37474f", fontcolor="#37474f", arrowsize=0.8]
"""
# Diagrams of large metamodels: direction and classes. The others have one of all classes.
PARTS = {
    "pn": {
        "net": (
            "TB",
            "Element Net Page PageObject Node PlaceNode TransitionNode Place Transition "
            "ReferencePlace ReferenceTransition Arc ArcKind TimeInterval",
        ),
        "layout": ("TB", "Element Graphics Point Label LabelKind ToolInfo Suppression"),
    },
    "sym": {
        "nodes": (
            "TB",
            "SystemModel NodeNet Lifecycle Execution Executor CallbackGroup CallbackGroupKind "
            "CallbackPage CallbackKind",
        ),
        "tokens": ("LR", "SystemModel TokenType TokenField FieldKind Place PlaceKind BalloonToken"),
        "signals": (
            "TB",
            "NodeNet Transition TransitionKind InputSignal SignalValue InputClause Disjunction Literal",
        ),
        "properties": (
            "LR",
            "SystemModel Property PropertyLanguage SignalVariant Assumption Fairness ExclusiveSignals "
            "SourceAssumption InputSignal",
        ),
        "channels": (
            "TB",
            "SystemModel Middleware Channel TopicChannel ServiceChannel QualityOfService Reliability "
            "Durability Liveliness TopicPort PublisherPort SubscriberPort Dispatcher ServerPort ClientPort "
            "FieldMapping MessagePart",
        ),
        "times": ("LR", "SystemModel DefaultTimes NodeNet CallbackOrder CallbackPage"),
        "actions": ("TB", "Channel ActionChannel ActionServerPort ActionClientPort CallbackGroup"),
    },
    "pnm": {"": ("TB", "")},
}


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pictures to the guide; the hook that MkDocs calls."""
    for name, picture in pictures().items():
        files.append(File.generated(config, f"pictures/{name}.svg", content=picture))
    return files


def pictures() -> dict[str, str]:
    """Return each diagram's SVG by its name, such as ``sym-channels``."""
    return {
        "-".join(filter(None, ["class", name, part])): to_svg(to_dot(package, direction, members))
        for name, package in read_metamodels().items()
        for part, (direction, members) in parts_of(name, package).items()
    }


def parts_of(name: str, package: EPackage) -> dict[str, tuple[str, list[str]]]:
    """Return the diagrams of a metamodel: for each part its direction and its classes."""
    everything = [classifier.name for classifier in package.eClassifiers]
    return {
        part: (direction, members.split() or everything)
        for part, (direction, members) in PARTS.get(name, {"": ("LR", "")}).items()
    }


def read_metamodels() -> dict[str, EPackage]:
    """Read the ``.ecore`` files."""
    resources = ResourceSet()
    return {
        name: resources.get_resource(URI(str(FOLDER / f"{name}.ecore"))).contents[0] for name in METAMODELS
    }


def to_dot(package: EPackage, direction: str, members: list[str]) -> str:
    """Describe a class diagram of some classes of a package in Graphviz's language."""
    shown = [package.getEClassifier(name) for name in members]
    classes = [classifier for classifier in shown if isinstance(classifier, EClass)]
    lines = [HEAD, f"  rankdir={direction}"]
    foreign: dict[str, str] = {}

    def node_of(classifier: EClass) -> str:
        if classifier in classes:
            return f'"{classifier.name}"'
        prefix = "" if classifier.ePackage is package else f"{classifier.ePackage.name}."
        node = f'"{prefix}{classifier.name}"'
        foreign[node] = f"{prefix}{classifier.name}"
        return node

    for classifier in classes:
        lines.append(f'  "{classifier.name}" [label=<{box(classifier)}>]')
        for parent in classifier.eSuperTypes:
            lines.append(f"  {node_of(parent)} -> {node_of(classifier)} [dir=back, arrowtail=onormal]")
        for feature in classifier.eStructuralFeatures:
            if isinstance(feature, EReference) and is_drawn(feature, classes):
                lines.append(edge(feature, node_of(classifier), node_of(feature.eType)))
    for node, text in foreign.items():
        lines.append(f"  {node} [label=<{table(f'<i>{text}</i>', [], '#eceff1')}>]")
    enumerations = [classifier for classifier in shown if isinstance(classifier, EEnum)]
    if enumerations:
        rows = [f"{found.name}: {', '.join(map(str, found.eLiterals))}" for found in enumerations]
        lines.append(f"  enumerations [label=<{table('Enumerations', rows, '#fff8e1')}>]")
    return "\n".join([*lines, "}"])


def is_drawn(reference: EReference, shown: list[EClass]) -> bool:
    """Tell whether a reference gets a line: of two opposite ones only one does, the containment if any."""
    opposite = reference.eOpposite
    if opposite is None:
        return True
    if opposite.containment:
        return opposite.eContainingClass not in shown
    return reference.containment or (not reference.transient and reference.lower >= opposite.lower)


def edge(reference: EReference, source: str, target: str) -> str:
    """Draw a reference with its name and how many there may be."""
    upper = "*" if reference.many else str(reference.upper)
    bounds = upper if reference.lower == (0 if reference.many else 1) else f"{reference.lower}..{upper}"
    style = "dir=both, arrowtail=diamond, arrowhead=none" if reference.containment else "arrowhead=vee"
    return f'  {source} -> {target} [label=" {reference.name} {bounds} ", {style}]'


def box(classifier: EClass) -> str:
    """Draw a class with its attributes."""
    rows = [
        attribute(feature) for feature in classifier.eStructuralFeatures if isinstance(feature, EAttribute)
    ]
    title = f"<b>{classifier.name}</b>"
    return table(f"<i>{title}</i>" if classifier.abstract else title, rows, "#e3f2fd")


def attribute(feature: EAttribute) -> str:
    """Write an attribute as ``name: type = default``; ``?`` marks one that may be absent."""
    kind = TYPES.get(feature.eType.name, feature.eType.name)
    default = feature.defaultValueLiteral
    optional = "" if feature.lower > 0 or default is not None else "?"
    return f"{feature.name}: {kind}{optional}{f' = {default}' if default is not None else ''}"


def table(title: str, rows: list[str], colour: str) -> str:
    """Draw a box with a title and rows."""
    cells = "".join(f'<tr><td align="left" border="0">{html.escape(row)}</td></tr>' for row in rows)
    body = f"<hr/>{cells}" if rows else ""
    return (
        f'<table border="1" cellborder="0" cellspacing="0" cellpadding="3" '
        f'color="#37474f" bgcolor="{colour}">'
        f"<tr><td>{title}</td></tr>{body}</table>"
    )


def to_svg(dot: str) -> str:
    """Lay a graph out; a note instead where Graphviz is missing."""
    if not shutil.which("dot"):
        LOG.info("Graphviz (dot) is missing: the class diagrams are left out")
        return (
            '<svg xmlns="http://www.w3.org/2000/svg" width="400" height="40">'
            '<text x="10" y="25">Build the guide with Graphviz installed to see this diagram.</text></svg>'
        )
    return subprocess.run(["dot", "-Tsvg"], input=dot, capture_output=True, text=True, check=True).stdout
