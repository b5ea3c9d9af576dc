"""Which records of Python's `logging` are handed on, and to whom."""

from __future__ import annotations

import asyncio.log
import io
import logging
import sys
from collections.abc import Iterator
from types import ModuleType

import pluggy
import pytest

from dineros.runtime.application.logs import OwnLogs, logs_to, terminal_handler


@pytest.fixture
def bare_root() -> Iterator[logging.Logger]:
    """The root logger as a program finds it; pytest has handlers of its own there."""
    root = logging.getLogger()
    handlers, level = root.handlers[:], root.level
    root.handlers[:] = []
    root.setLevel(logging.WARNING)
    yield root
    root.handlers[:] = handlers
    root.setLevel(level)


def record(name: str, module: ModuleType, level: int = logging.INFO) -> logging.LogRecord:
    """Return a record of a logger, as if it had been written in a module."""
    return logging.LogRecord(name, level, str(module.__file__), 1, "text", (), None)


HERE = sys.modules[__name__]


@pytest.mark.parametrize(
    ("name", "module", "is_kept"),
    [
        ("sorting", HERE, True),
        ("pluggy.hooks", pluggy, False),  # installed from elsewhere
        ("asyncio", asyncio.log, False),  # of Python itself
        ("pluggy", HERE, True),  # our own code uses a library's logger
        ("sorting", asyncio.log, True),  # Python calls our function: `loop.call_later(1, LOG.info, "text")`
        ("dineros.runtime", HERE, True),
        ("root", HERE, True),
    ],
)
def test_what_libraries_tell_about_themselves_is_left_out(
    name: str, module: ModuleType, is_kept: bool
) -> None:
    assert OwnLogs().filter(record(name, module)) is is_kept
    assert OwnLogs().filter(record(name, module, logging.WARNING))


def test_the_package_of_the_handlers_is_no_library_although_it_is_installed() -> None:
    assert OwnLogs("pluggy").filter(record("pluggy.hooks", pluggy))


def test_a_library_that_somebody_asked_for_is_heard() -> None:
    logger = logging.getLogger("pluggy")
    try:
        logger.setLevel(logging.DEBUG)
        assert OwnLogs().filter(record("pluggy.hooks", pluggy, logging.DEBUG))
    finally:
        logger.setLevel(logging.NOTSET)
    assert not OwnLogs().filter(record("pluggy.hooks", pluggy))


def test_terminal_handlers_are_put_aside_and_come_back(
    bare_root: logging.Logger, capsys: pytest.CaptureFixture[str]
) -> None:
    terminal, file = logging.StreamHandler(sys.stderr), logging.StreamHandler(io.StringIO())
    bare_root.addHandler(terminal)
    bare_root.addHandler(file)
    log = logging.getLogger("sorting")
    with logs_to(handler := terminal_handler(), logging.INFO):
        log.info("inside %d", 1)
        log.debug("too much")
    log.info("too little")
    log.warning("outside")
    assert capsys.readouterr().err == "[INFO] [sorting]: inside 1\noutside\n"
    assert file.stream.getvalue() == "inside 1\noutside\n"
    assert {terminal, file} <= set(bare_root.handlers)
    assert handler not in bare_root.handlers
    assert bare_root.level == logging.WARNING
