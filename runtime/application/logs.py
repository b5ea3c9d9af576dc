"""Logging of the engine and of the developers' handlers, with Python's `logging`.

Handlers use loggers of any name, so the level is set at the root logger: the program that runs nodes forwards
records with `logs_to`. `OwnLogs` removes what libraries log about themselves.
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
"""Format of records on a terminal: that of ROS."""


class OwnLogs(logging.Filter):
    """Removes what a library logs about itself below WARNING.

    This is a record of a logger with the name of an installed module, written by an installed module. It is
    kept if the level of the logger, or of a parent logger other than the root, was set explicitly.

    Parameters
    ----------
    *packages : str
        Top-level packages that do not count as libraries even if installed, such as that of the node.
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
    """Formats a record of the engine as one line; records of handlers keep their line breaks."""

    def format(self, record: logging.LogRecord) -> str:
        """Return the text of a record."""
        text = super().format(record)
        return printable(text) if record.name.partition(".")[0] == "dineros" and not record.exc_info else text


@contextmanager
def logs_to(handler: logging.Handler, level: int) -> Iterator[None]:
    """Forward records from a level on to a handler while the block lasts.

    Handlers of the root logger that write to the terminal are removed meanwhile, so that nothing appears
    twice; others, such as handlers that write files, stay.
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
    """Return a handler that writes to stderr without what libraries log about themselves."""
    handler = logging.StreamHandler()
    handler.setFormatter(_OneLine(FORMAT))
    handler.addFilter(OwnLogs())
    return handler


def _is_on_terminal(handler: logging.Handler) -> bool:
    return isinstance(handler, logging.StreamHandler) and handler.stream in (sys.stdout, sys.stderr)


def _is_set(name: str) -> bool:
    """Return whether the level of a logger, or of a parent logger other than the root, was set explicitly."""
    logger: logging.Logger | None = logging.getLogger(name)
    while logger is not None and logger.parent is not None:
        if logger.level != logging.NOTSET:
            return True
        logger = logger.parent
    return False


def _files(module: str) -> list[str]:
    """Return the files of an imported module; a namespace package only has folders."""
    found = sys.modules.get(module)
    return [getattr(found, "__file__", None) or "", *map(str, getattr(found, "__path__", ()))]


@functools.cache
def _is_in_library(path: str) -> bool:
    """Return whether a file belongs to Python itself or to its installed packages."""
    return path.startswith(_libraries())


@functools.cache
def _libraries() -> tuple[str, ...]:
    folders = {sysconfig.get_path(name) for name in ("stdlib", "platstdlib", "purelib", "platlib")}
    folders.update(site.getsitepackages(), [site.getusersitepackages()])
    return tuple(f"{folder.rstrip(os.sep)}{os.sep}" for folder in folders)
