"""The lines that Babeltrace 2 writes of a trace: from a text file, or from the program itself.

The program is the reader of the authors of LTTng, and users who trace ROS 2 have it. Its Python library is
not on a package index: it comes with a distribution, for the Python of that distribution.
"""

from __future__ import annotations

import os
import re
import selectors
import shutil
import subprocess
import time
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import IO

from dineros.analysis.answers.processes import end_group
from dineros.metamodel.errors import Location, ModelFileError
from dineros.metamodel.files.reading import read_pieces
from dineros.observation.tracing.errors import TracingError

PROGRAM = "babeltrace2"
STALLED = 30.0
"""Seconds without output after which the program is stopped: it may hang on damaged traces."""
LONGEST_LINE = 1 << 16
"""Limit of the bytes of a line; an event of ROS 2 takes a few hundred."""

_OPTIONS = ("--clock-seconds", "--no-delta", "--color=never")
_PIECE = 1 << 18
_MOST_SAID = 1 << 14
"""Last bytes of standard error of the program that are stored."""
_DISCARDED = re.compile(rb"discarded (\d+) event")


class Said:
    """The output of the program on standard error."""

    def __init__(self) -> None:
        self.discarded = 0
        """Events that the tracer discarded because its buffer was full, according to the trace."""
        self._text = b""
        self._line = b""

    def add(self, piece: bytes) -> None:
        """Take a piece of it."""
        *lines, self._line = (self._line + piece).split(b"\n")
        self._line = self._line[-LONGEST_LINE:]
        for line in lines:
            self.discarded += sum(int(number[:18]) for number in _DISCARDED.findall(line))
        self._text = (self._text + piece)[-_MOST_SAID:]

    def reason(self, folder: Path) -> str:
        """Return why it failed: the last cause that it names, in one line."""
        text = self._text.decode(errors="replace")
        last = re.split(r"CAUSED BY \[[^\n]*\n|ERROR: +\[[^\n]*\n", text)[-1]
        said = " ".join(last.split()).replace(f"{folder}/", "").replace(str(folder), "it")
        return said[:300].rstrip(".") or "it prints nothing"


def lines(path: Path, said: Said, stalled: float = STALLED) -> Iterator[bytes]:
    """Yield the lines of a trace as Babeltrace 2 writes them; an unfinished last one ends without a newline.

    Parameters
    ----------
    path : Path
        A text file, or a folder in the format CTF.
    said : Said
        Gets the output on standard error.
    stalled : float
        Seconds that the program may run without output.

    Raises
    ------
    TracingError
        The file does not exist, the program is missing, fails or prints nothing, or a line is too long.
    """
    pieces = _printed(path, said, stalled) if path.is_dir() else _text(path)
    for number, line in enumerate(_split(pieces), 1):
        if len(line) > LONGEST_LINE:
            raise TracingError(
                "is not output of Babeltrace 2: a line is too long", location=Location(path, number)
            )
        yield line


def _split(pieces: Iterable[bytes]) -> Iterator[bytes]:
    rest = b""
    for piece in pieces:
        found = (rest + piece).splitlines(keepends=True) if rest else piece.splitlines(keepends=True)
        rest = b"" if not found or found[-1].endswith(b"\n") else found.pop()
        yield from found
        if len(rest) > LONGEST_LINE:
            break
    if rest:
        yield rest


def _text(path: Path) -> Iterator[bytes]:
    try:
        yield from read_pieces(path)
    except ModelFileError as error:
        raise TracingError(error.message, location=error.location, hint=error.hint) from error


def _printed(folder: Path, said: Said, stalled: float) -> Iterator[bytes]:
    """Yield the output of the program for a folder."""
    program = shutil.which(PROGRAM)
    if program is None:
        raise TracingError(
            f"a folder of LTTng is read by {PROGRAM}, which is not on the PATH",
            location=Location(folder),
            hint=f"install it (Debian, Ubuntu: apt install babeltrace2), or give the output that "
            f"`{PROGRAM} {folder} > trace.txt` writes elsewhere",
        )
    try:
        # A session of its own: what the program may start ends with it.
        process = subprocess.Popen(
            [program, *_OPTIONS, str(folder.resolve())],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            bufsize=0,
            start_new_session=True,
        )
    except OSError as error:
        raise TracingError(f"{program} does not run: {error.strerror}", location=Location(folder)) from None
    try:
        assert process.stdout is not None and process.stderr is not None
        yield from _both(process.stdout, process.stderr, said, folder, stalled)
        status = process.wait(stalled)
    except subprocess.TimeoutExpired:
        raise _silent(folder, stalled) from None
    finally:
        end_group(process)
    if status:
        raise TracingError(
            f"{PROGRAM} cannot read it: {said.reason(folder.resolve())}",
            location=Location(folder),
            hint="a trace is a folder that `ros2 trace` or `lttng` created and completed",
        )


def _both(output: IO[bytes], errors: IO[bytes], said: Said, folder: Path, stalled: float) -> Iterator[bytes]:
    """Yield standard output; standard error is read so that it does not fill its pipe."""
    with selectors.DefaultSelector() as selector:
        selector.register(output, selectors.EVENT_READ)
        selector.register(errors, selectors.EVENT_READ)
        # Endless warnings are not progress, and the time that the caller takes for a line does not count.
        left = stalled
        while selector.get_map():
            asked = time.monotonic()
            ready = selector.select(left)
            left -= time.monotonic() - asked
            if left <= 0:
                raise _silent(folder, stalled)
            for key, _ in ready:
                piece = os.read(key.fd, _PIECE)
                if not piece:
                    selector.unregister(key.fileobj)
                elif key.fileobj is errors:
                    said.add(piece)
                else:
                    yield piece
                    left = stalled


def _silent(folder: Path, stalled: float) -> TracingError:
    return TracingError(
        f"{PROGRAM} has printed nothing for {stalled:g} s: the trace is damaged", location=Location(folder)
    )
