"""What commands print: results on stdout, notes and progress on stderr, colours on terminals only."""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any, TextIO

import click

from dineros.cli.options import invocation

SEVERITIES = {"error": "bold red", "warning": "yellow"}
"""Styles of findings."""


def say(text: str, style: str | None = None) -> None:
    """Print one line of the result.

    Parameters
    ----------
    text : str
        The line.
    style : str, optional
        A style of rich, such as ``bold red``, for terminals.
    """
    if style is None or not sys.stdout.isatty():
        click.echo(text)
    else:
        _print_styled(text, style, sys.stdout)


def summarise(text: str, style: str | None = None) -> None:
    """Print the last line of a report, unless `-q` is given."""
    if invocation().verbosity >= 0:
        say(text, style)


def say_json(value: Any) -> None:
    """Print a value as JSON, the only thing on stdout."""
    click.echo(json.dumps(value, indent=2, ensure_ascii=False))


def warn(text: str) -> None:
    """Print a line for people on stderr, even with `-q`."""
    if sys.stderr.isatty():
        _print_styled(text, "yellow", sys.stderr)
    else:
        click.echo(text, err=True)


def note(text: str) -> None:
    """Print a line about what is done on stderr, with `-v` only."""
    if invocation().verbosity > 0:
        click.echo(text, err=True)


@contextmanager
def working(text: str) -> Iterator[None]:
    """Show on stderr, where that is a terminal, that long work goes on."""
    if invocation().verbosity < 0 or invocation().is_watched or not sys.stderr.isatty():
        yield
        return
    from rich.console import Console

    with Console(stderr=True).status(text):
        yield


def _print_styled(text: str, style: str, stream: TextIO) -> None:
    from rich.console import Console

    # What people copy and tools read must not be wrapped or decorated.
    Console(file=stream, highlight=False, markup=False, emoji=False, soft_wrap=True).print(text, style=style)
