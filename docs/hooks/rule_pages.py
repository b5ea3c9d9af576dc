"""Pages of the rules, one per family, made from the rules themselves while the guide is built."""

from __future__ import annotations

import logging

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

from dineros.metamodel.errors import DinerosError
from dineros.transformations.language.rule import Rule
from dineros.transformations.pictures.describing import documentation_of, rule_text
from dineros.transformations.pictures.drawing import rule_svg
from dineros.transformations.rules.catalogue import FAMILIES, Family, name_of

LOG = logging.getLogger("mkdocs.hooks.rule_pages")

INTRODUCTION = """What a rule matches is on the left, what there is afterwards on the right. Underlined
elements are the same on both sides; what the rule makes is bold and orange. A place or a group *by T1 for
channel* is what T1 made when it matched that channel. Text in braces is filled in: `{channel.id}` is the id
of the channel. [Rule language](../rule_language.md) explains the words,
[Transformations](../transformations.md) says when the rules run. Every picture links to itself in full size.
"""
NO_PICTURE = (
    '<svg xmlns="http://www.w3.org/2000/svg" width="400" height="40">'
    '<text x="10" y="25">Build the guide with Graphviz installed to see this rule.</text></svg>'
)


def on_files(files: Files, *, config: MkDocsConfig) -> Files:
    """Add the pages and their pictures to the guide; the hook that MkDocs calls."""
    for path, content in pages().items():
        files.append(File.generated(config, path, content=content))
    return files


def pages() -> dict[str, str]:
    """Return the content of all pages and pictures by path."""
    made: dict[str, str] = {}
    for family in FAMILIES:
        made[f"rules/{family.name}.md"] = page(family)
        for rule in family.rules:
            made[f"rules/pictures/{name_of(rule)}.svg"] = picture(rule)
    return made


def page(family: Family) -> str:
    """Return the page of a family, in Markdown."""
    parts = [
        "---\nhide:\n  - toc\n---",
        f"# {family.title}",
        f"The rules of the paper's {family.section}." if family.section else family.about,
        INTRODUCTION,
    ]
    for rule in family.rules:
        name = name_of(rule)
        shown = f"pictures/{name}.svg"
        parts += [
            f"## {name}",
            documentation_of(rule),
            f"[![Rule {name}: left-hand side and right-hand side]({shown})]({shown})",
            f"```text\n{rule_text(rule)}\n```",
        ]
    return "\n\n".join(parts) + "\n"


def picture(rule: type[Rule]) -> str:
    """Draw a rule; a note instead where Graphviz is missing."""
    try:
        return rule_svg(rule)
    except DinerosError as error:
        LOG.info("%s: the pictures of the rules are left out", error)
        return NO_PICTURE
