"""The reference of the command line: the `--help` of each command, inserted while the guide is built."""

from __future__ import annotations

import click
from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import Files
from mkdocs.structure.pages import Page

from dineros.cli.main import main

MARK = "<!-- every command -->"


def on_page_markdown(markdown: str, *, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Replace the mark by all commands' help; the hook that MkDocs calls."""
    return markdown.replace(MARK, reference()) if MARK in markdown else markdown


def reference() -> str:
    """Return one section per command, in Markdown."""
    root = click.Context(main, info_name="dineros", **main.context_settings)
    sections = []
    for name in main.list_commands(root):
        command = main.get_command(root, name)
        assert command is not None
        context = click.Context(command, info_name=name, parent=root)
        sections.append(f"## dineros {name}\n\n```text\n{command.get_help(context)}\n```\n")
    return "\n".join(sections)
