"""Output of commands: results on stdout, notes and progress on stderr, colours on terminals only."""

from __future__ import annotations

import json
import re
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from types import MappingProxyType
from typing import Any, TextIO

import click

from dineros.cli.options import invocation
from dineros.metamodel.errors import printable

SEARCH = "dineros.search"
"""Where the context of a command keeps its search."""

SEVERITIES = {"error": "bold red", "warning": "yellow"}
"""Styles of findings."""

_NO_NOTES: Mapping[str, str] = MappingProxyType({})
_CONTROLS = re.compile("[\x7f-\x9f\u200e\u200f\u2028-\u202e\u2066-\u2069]")


def say(text: str, style: str | None = None) -> None:
    """Print one line of the result; line breaks and other control characters are shown, not executed.

    Parameters
    ----------
    text : str
        The line; it may contain text from files.
    style : str, optional
        A style of rich, such as ``bold red``, for terminals.
    """
    line = printable(text)
    if style is None or not sys.stdout.isatty():
        click.echo(line)
    else:
        _print_styled(line, style, sys.stdout)


def say_lines(text: str) -> None:
    """Print lines of the result."""
    for line in text.split("\n"):
        say(line)


def summarise(text: str, style: str | None = None) -> None:
    """Print the last line of a report, unless `-q` is given."""
    if invocation().verbosity >= 0:
        say(text, style)


def say_json(value: Any) -> None:
    """Print a value as JSON, the only thing on stdout."""
    text = json.dumps(value, indent=2, ensure_ascii=False)
    # JSON leaves some controls as they are, which it could only have in strings.
    click.echo(_CONTROLS.sub(lambda each: f"\\u{ord(each[0]):04x}", text))


def warn(text: str) -> None:
    """Print a warning on stderr, even with `-q`."""
    line = printable(text)
    if sys.stderr.isatty():
        _print_styled(line, "yellow", sys.stderr)
    else:
        click.echo(line, err=True)


def note(text: str) -> None:
    """Print a line of details on stderr, with `-v` only."""
    if invocation().verbosity > 0:
        click.echo(printable(text), err=True)


@contextmanager
def working(text: str) -> Iterator[None]:
    """Show on stderr, if it is a terminal, that long work continues; it is a stage of a search."""
    if invocation().is_watched:
        context = click.get_current_context(silent=True)
        search = None if context is None else context.meta.get(SEARCH)
        if search is not None:
            search.stage(text[:1].lower() + text[1:])
        yield
        return
    if invocation().verbosity < 0 or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console
    from rich.text import Text

    with Console(stderr=True).status(Text(printable(text))):
        yield


def _print_styled(text: str, style: str, stream: TextIO) -> None:
    from rich.console import Console

    # Text that people copy or tools read must not be wrapped or decorated.
    Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True).print(text, style=style)


def say_figures(
    figures: Mapping[str, object], indent: str = "", notes: Mapping[str, str] = _NO_NOTES
) -> None:
    """Print figures that have a value, a line each, with the notes on some of them."""
    for name, value in figures.items():
        if value not in (None, ""):
            width = 21 if indent else 22
            label = f"{indent}{name.replace('_', ' '):{width}}"
            say(f"{label} {_shown_figure(name, value)}{notes.get(name, '')}")


def _shown_figure(name: str, value: object) -> str:
    """Return a figure as text; its name decides its unit."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if name == "peak_memory_bytes" and isinstance(value, int):
        return f"{value / 2**20:,.0f} MiB"
    if isinstance(value, float):
        return f"{value:.2f}"
    return f"{value:,}" if isinstance(value, int) else str(value)
