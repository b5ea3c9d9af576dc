"""Running the examples of a Markdown page the way a reader would."""

from __future__ import annotations

import contextlib
import io
import logging
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.support.programs import warm_commands

_FENCE = re.compile(r'^```(\w*)(?: title="([^"]+)")?\n(.*?)^```$', re.MULTILINE | re.DOTALL)


@dataclass(frozen=True)
class Block:
    """One fenced block of a page."""

    language: str
    title: str | None
    text: str
    line: int
    start: int
    end: int


def blocks(markdown: str) -> list[Block]:
    """Return the fenced blocks of a page, in order."""
    return [
        Block(
            language=found[1],
            title=found[2],
            text=found[3],
            line=markdown.count("\n", 0, found.start(3)) + 1,
            start=found.start(),
            end=found.end(),
        )
        for found in _FENCE.finditer(markdown)
    ]


def commands(console: str) -> list[tuple[str, str]]:
    """Split a ``console`` block into commands, which begin with ``$``, and what each prints."""
    parts = re.split(r"^\$ ", console, flags=re.MULTILINE)
    return [(command, output) for command, _, output in (part.partition("\n") for part in parts[1:])]


def run_page(markdown: str, folder: Path, warm: Path | None = None) -> Iterator[tuple[Block, str, str, str]]:
    """Run a page in a folder; yield block, command, the output that the page shows, and the true output.

    * What has a title is a file. ``python`` without one is run, all on a page in one interpreter. A ``text``
      block right behind it is what it prints.
    * ``console`` is run by bash, where ``dineros`` and ``python`` are ours; ``dineros`` is a fork
      of what serves at the socket `warm`, if given (`tests.support.programs.warm_commands`).
    """
    with _levels_of_loggers_kept():
        yield from _run_blocks(markdown, folder, warm)


@contextlib.contextmanager
def _levels_of_loggers_kept() -> Iterator[None]:
    """Take back what a page sets, which would hold for all tests after it."""
    try:
        yield
    finally:
        _forget_levels()


def _forget_levels() -> None:
    for logger in logging.Logger.manager.loggerDict.values():
        if isinstance(logger, logging.Logger) and logger.name.startswith("dineros"):
            logger.setLevel(logging.NOTSET)


def _run_blocks(markdown: str, folder: Path, warm: Path | None) -> Iterator[tuple[Block, str, str, str]]:
    names: dict[str, object] = {"__name__": "__main__"}
    environment = _environment(folder, warm)
    found = blocks(markdown)
    for block, following in zip(found, [*found[1:], None], strict=False):
        if block.title:
            (folder / block.title).write_text(block.text, encoding="utf-8")
        elif block.language == "python":
            printed = io.StringIO()
            with contextlib.chdir(folder), contextlib.redirect_stdout(printed):
                exec(compile(block.text, f"line {block.line}", "exec"), names)
            shown = ""
            if (
                following
                and following.language == "text"
                and not markdown[block.end : following.start].strip()
            ):
                shown = following.text
            yield block, "python", shown, printed.getvalue()
        elif block.language == "console":
            for command, shown in commands(block.text):
                run = subprocess.run(
                    ["bash", "-c", command],
                    cwd=folder,
                    env=environment,
                    stdout=subprocess.PIPE,
                    stderr=subprocess.STDOUT,
                    text=True,
                    check=False,
                )
                yield block, command, shown, run.stdout


def _environment(folder: Path, warm: Path | None) -> dict[str, str]:
    """Put commands ``dineros`` and ``python`` in front that run this installation."""
    programs = folder / ".bin"
    programs.mkdir()
    python = f'#!/bin/sh\nexec "{sys.executable}" "$@"\n'
    dineros = python.replace('"$@"', '-m dineros.cli.main "$@"')
    for name, script in (("dineros", warm_commands.program(warm) if warm else dineros), ("python", python)):
        program = programs / name
        program.write_text(script, encoding="utf-8")
        program.chmod(0o755)
    return {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}", "LC_ALL": "C.UTF-8"}
