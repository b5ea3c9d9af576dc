"""The one-line error of a failed command, and its exit status."""

from __future__ import annotations

import os
import sys

import click

from dineros.metamodel.errors import BudgetError, DinerosError, printable, without_middle

WRONG_USE = 2
UNKNOWN = 3
NO_READER = 141  # 128 + SIGPIPE

REPORT_AT = "please report it, with the model and what --debug adds"


def failed(error: Exception, debug: bool) -> int:
    """Print an error in at most one line, after the stack trace with `--debug`; return the status."""
    if isinstance(error, BrokenPipeError):
        return no_reader()
    if debug:
        import traceback

        traceback.print_exception(error)
    _complain(without_middle(_one_line(error)))
    return UNKNOWN if isinstance(error, BudgetError) else WRONG_USE


def _one_line(error: Exception) -> str:
    """Print an error without a stack trace."""
    if isinstance(error, click.ClickException):
        context = getattr(error, "ctx", None)
        path = context.command_path if context else "dineros"
        message = " ".join(error.format_message().split()).rstrip(".")
        message = message[:1].lower() + message[1:] if message[1:2].islower() else message
        return f"{path}: {message} (see {path} --help)"
    if isinstance(error, DinerosError):
        located = error.location is not None and str(error.location)
        return str(error) if located else f"dineros: {error}"
    if isinstance(error, OSError) and error.strerror:
        named = isinstance(error.filename, str)  # it may be the number of a descriptor
        return f"{error.filename if named else 'dineros'}: {error.strerror}"
    text = " ".join(str(error).split())
    return f"dineros: unexpected {type(error).__name__}{': ' if text else ''}{text} ({REPORT_AT})"


def _complain(line: str) -> None:
    try:
        click.echo(printable(line), err=True)
    except BrokenPipeError:
        no_reader()


def no_reader() -> int:
    """Keep Python from failing once more when it closes the streams."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except BrokenPipeError:
            os.dup2(nowhere, stream.fileno())
    return NO_READER
