"""The private line between a supervisor and a node: what comes through, and what does no harm."""

from __future__ import annotations

import os
import socket
import subprocess
import sys
from collections.abc import Iterator

import pytest

from dineros.runtime.application.line import LINE, Line, LineError, inherited_line, new_line

ENDS = tuple[Line, socket.socket]


@pytest.fixture
def ends() -> Iterator[ENDS]:
    """A line, and the socket at its other end."""
    ours, theirs = socket.socketpair()
    line = Line(ours)
    with theirs:
        yield line, theirs
    line.close()


def test_several_things_are_said_at_once_or_in_pieces(ends: ENDS) -> None:
    line, other = ends
    other.sendall(b'{"a":1}\n{"b":"\\ud83d\\ude00"}\n{"c"')
    assert [line.receive(), line.receive()] == [{"a": 1}, {"b": "\U0001f600"}]
    other.sendall(b":[]}\n")
    assert line.receive() == {"c": []}
    line.say({"text": "\ud800"}, waits=False)  # half of a surrogate pair, which no UTF-8 holds
    assert other.recv(100) == b'{"text": "\\ud800"}\n'
    other.close()
    assert line.receive() is None


@pytest.mark.parametrize(
    "said",
    [b"no json\n", b"[1]\n", b"\xff\n", b"[" * 100_000 + b"\n", b'{"a":1e999}\n', b'{"a":"\\ud800"}\n'],
)
def test_what_is_none_of_ours_is_refused(ends: ENDS, said: bytes) -> None:
    line, other = ends
    other.sendall(said)
    with pytest.raises(LineError):
        line.receive()


def test_what_is_too_long_is_refused(ends: ENDS, monkeypatch: pytest.MonkeyPatch) -> None:
    line, other = ends
    monkeypatch.setattr("dineros.runtime.application.line.LONGEST", 1000)
    with pytest.raises(LineError, match="1013 bytes are too much for one line"):
        line.say({"text": "a" * 1000}, waits=True)
    other.sendall(b"a" * 1001)  # and there is no end to it
    with pytest.raises(LineError, match="a line of more than 1000 bytes"):
        line.receive()


def test_who_does_not_listen_makes_nobody_wait(ends: ENDS) -> None:
    line, _ = ends
    with pytest.raises(LineError, match="does not respond"):
        for _ in range(10_000):
            line.say({"text": "a" * 1000}, waits=False)


def test_who_receives_is_told_that_the_line_is_closed(ends: ENDS) -> None:
    line, other = ends
    line.hang_up()
    assert line.receive() is None
    assert other.recv(1) == b""
    line.hang_up()  # once more does no harm


PROGRAM = """
import os, subprocess, sys
from dineros.runtime.application.line import inherited_line
line = inherited_line()
child = "import os, sys; print(os.environ.get('DINEROS_LINE'), os.path.exists(sys.argv[1]))"
said = subprocess.run([sys.executable, "-c", child, f"/proc/self/fd/{line._end.fileno()}"], close_fds=False,
                      capture_output=True, text=True)
line.say({"line of a child": said.stdout.split(), "again": inherited_line() is None}, waits=True)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="looks into /proc")
def test_a_process_inherits_its_end_and_what_it_starts_does_not() -> None:
    taken: list[Line] = []
    with new_line(lambda end: taken.append(Line(end))) as given:
        subprocess.run(
            [sys.executable, "-P", "-c", PROGRAM],
            env={**os.environ, **given},
            pass_fds=[int(given[LINE])],
            check=True,
            timeout=60,
        )
    (line,) = taken
    assert line.receive() == {"line of a child": ["None", "False"], "again": True}
    assert line.receive() is None  # nobody holds the other end any more
    line.close()


def test_no_line_is_left_of_a_process_that_could_not_be_started() -> None:
    taken: list[socket.socket] = []
    with pytest.raises(OSError, match="nothing here"), new_line(taken.append) as given:
        number = int(given[LINE])
        raise FileNotFoundError("nothing here")
    assert taken == []
    with pytest.raises(OSError, match="Bad file descriptor"):
        os.fstat(number)
    with new_line(None) as given:
        assert given == {}


def test_what_names_no_line_is_none(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.delenv(LINE, raising=False)
    assert inherited_line() is None
    assert caplog.text == ""
    reading, writing = os.pipe()
    with socket.socket() as internet:
        for wrong in ("seven", "-1", "1" * 400, str(reading), str(internet.fileno())):
            monkeypatch.setenv(LINE, wrong)
            assert inherited_line() is None
            assert "does not name a connection to a supervisor" in caplog.text
            caplog.clear()
        assert internet.fileno() >= 0
        os.fstat(internet.fileno())  # still open
    for number in (reading, writing):
        os.close(number)
