"""What becomes of what developers' handlers log with Python's `logging`, and the engine with them.

Handlers use loggers of any name, so that the root logger decides: whoever runs nodes hands over what it gets,
by `logs_to`. What libraries tell about themselves is left out by `OwnLogs`.
"""

from __future__ import annotations

import functools
import logging
import os
import site
import sys
import sysconfig
from collections.abc import Iterator
from contextlib import contextmanager

from dineros.metamodel.errors import printable

FORMAT = "[%(levelname)s] [%(name)s]: %(message)s"
"""How records look on a terminal: as ROS writes them."""


class OwnLogs(logging.Filter):
    """Leaves out what a library tells about itself below WARNING.

    That is a record of a logger with the name of an installed module, written by an installed module. It is
    kept where somebody asked for it: where the level of the logger, or of one above it but the root, was set.

    Parameters
    ----------
    *packages : str
        Top-level packages that are not libraries although they may be installed, such as that of the node.
    """

    def __init__(self, *packages: str) -> None:
        super().__init__()
        self._packages = {"dineros", *packages}

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether a record is kept."""
        return record.levelno >= logging.WARNING or not self._is_of_library(record) or _is_set(record.name)

    def _is_of_library(self, record: logging.LogRecord) -> bool:
        package = record.name.partition(".")[0]
        return (
            package not in self._packages
            and _is_in_library(record.pathname)
            and any(map(_is_in_library, _files(package)))
        )


class _OneLine(logging.Formatter):
    """Shows what the engine logs as one line, whatever names and messages hold; handlers log as they like."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the text of a record."""
        text = super().format(record)
        return printable(text) if record.name.partition(".")[0] == "dineros" and not record.exc_info else text


@contextmanager
def logs_to(handler: logging.Handler, level: int) -> Iterator[None]:
    """Hand what is logged from a level on to a handler, as long as the block lasts.

    Handlers of the root logger that write to the terminal are put aside meanwhile, so that nothing is shown
    twice; others, such as those that write files, stay.
    """
    root = logging.getLogger()
    former, aside = root.level, [each for each in root.handlers if _is_on_terminal(each)]
    for each in aside:
        root.removeHandler(each)
    root.addHandler(handler)
    root.setLevel(level)
    try:
        yield
    finally:
        root.setLevel(former)
        root.removeHandler(handler)
        handler.close()
        for each in aside:
            root.addHandler(each)


def terminal_handler() -> logging.Handler:
    """Return a handler that writes to stderr, and leaves out what libraries tell about themselves."""
    handler = logging.StreamHandler()
    handler.setFormatter(_OneLine(FORMAT))
    handler.addFilter(OwnLogs())
    return handler


def _is_on_terminal(handler: logging.Handler) -> bool:
    return isinstance(handler, logging.StreamHandler) and handler.stream in (sys.stdout, sys.stderr)


def _is_set(name: str) -> bool:
    """Return whether somebody set the level of a logger, or of one above it but the root."""
    logger: logging.Logger | None = logging.getLogger(name)
    while logger is not None and logger.parent is not None:
        if logger.level != logging.NOTSET:
            return True
        logger = logger.parent
    return False


def _files(module: str) -> list[str]:
    """Return where a module that was imported comes from; a namespace package has only folders."""
    found = sys.modules.get(module)
    return [getattr(found, "__file__", None) or "", *map(str, getattr(found, "__path__", ()))]


@functools.cache
def _is_in_library(path: str) -> bool:
    """Return whether a file belongs to Python itself or to what is installed into it."""
    return path.startswith(_libraries())


@functools.cache
def _libraries() -> tuple[str, ...]:
    folders = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    folders.update(site.getsitepackages(), [site.getusersitepackages()])
    return tuple(f"{folder.rstrip(os.sep)}{os.sep}" for folder in folders)
