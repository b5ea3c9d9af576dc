"""What a supervisor and the process of a node say to each other, and what a live page asks for."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from dineros.metamodel.errors import DinerosError
from tests.fuzz.judging import ACCEPTED, REFUSED, Outcome
from tests.fuzz.running_targets import _judged_log, _net

Attempt = Callable[[bytes], Outcome]

ASKED = [
    b'{"number": 1, "ask": "look"}\n{"number": 2, "ask": "pause", "reason": "a page"}\n'
    b'{"number": 3, "ask": "set", "values": {"Button": true}, "source": "live page"}\n'
    b'{"number": 4, "ask": "proceed"}\n',
]
ANSWERED = [
    b'{"number": 2, "outlook": {"state": "halted", "reason": "a page", "signals": {"Button": false}, '
    b'"enabled": ["Say"]}}\n{"number": 3}\n',
    b'{"number": 3, "refused": "no such node", "hint": null}\n{"number": 2, "outlook": {"state": "ended", '
    b'"reason": null, "signals": null, "enabled": null}}\n',
]
SAID = [
    b'{"ask": "signal", "node": "talker", "signal": "Button", "value": true}',
    b'{"ask": "pause", "node": "talker"}',
    b'{"ask": "proceed", "node": "talker"}',
]


def asked_of_a_node(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Say something to a node as its supervisor would; it continues, and can be steered again."""
    from dineros.runtime.application.line import Line
    from dineros.runtime.application.steered import steered_over
    from dineros.runtime.nodes.steering import SteeredNet

    net = _net(ending)
    steered = SteeredNet(net)

    def attempt(content: bytes) -> Outcome:
        ours, theirs = socket.socketpair()
        with _judged_log(), theirs, steered_over(Line(theirs), lambda: steered):
            sending = threading.Thread(target=_send, args=(ours, content))
            sending.start()
            with ours:
                answers = b""
                with suppress(ConnectionResetError):  # it hangs up before it has read everything
                    while piece := ours.recv(1 << 16):
                        answers += piece
                sending.join()
        net.proceed()
        _until(lambda: steered.look().state == "running")
        refused = not answers or b"refused" in answers
        return Outcome(REFUSED if refused else ACCEPTED, answers.decode()[-5000:] or "it is heard no more")

    return ASKED, attempt


def answered_by_a_process(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Answer a supervisor as the process of a node would; then have it speak with another process."""
    from dineros.runtime.application.remote import SILENT, RemoteNode

    remote = RemoteNode("talker")
    ending.callback(remote.close)

    def attempt(content: bytes) -> Outcome:
        ours, theirs = socket.socketpair()
        refusals: list[str] = []

        def pause() -> None:
            try:
                remote.pause("a page")
            except DinerosError as error:
                refusals.append(str(error))

        with _judged_log():
            remote.connect(ours)
            with theirs:
                theirs.settimeout(20)
                remote.look()
                theirs.sendall(b'{"number": 1, "outlook": {"state": "running"}}\n')
                _until(lambda: remote.look().state == "running")
                pausing = threading.Thread(target=pause)
                pausing.start()
                heard = b""
                while b'"number": 3' not in heard:
                    heard += theirs.recv(1 << 16)
                _send(theirs, content)
                pausing.join()
            _until(lambda: remote.look() == SILENT)
        return Outcome(REFUSED, *refusals) if refusals else Outcome(ACCEPTED)

    return ANSWERED, attempt


def said_by_a_page(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask for something as a page would."""
    from dineros.runtime.nodes.steering import SteeredNet
    from dineros.views.live.steering import Steering

    steering = Steering()
    steering.take({"talker": SteeredNet(_net(ending))})

    def attempt(content: bytes) -> Outcome:
        with _judged_log():
            refusal = steering.hear(content)
        return Outcome(ACCEPTED if refusal is None else REFUSED, refusal or "")

    return SAID, attempt


def _until(condition: Callable[[], bool]) -> None:
    end = time.monotonic() + 20
    while not condition():
        assert time.monotonic() < end, "it waits for what never comes"
        time.sleep(0.001)


def _send(end: socket.socket, content: bytes) -> None:
    """Say something, and nothing more; whoever is told nonsense may hang up meanwhile."""
    with suppress(OSError):
        end.sendall(content)
        end.shutdown(socket.SHUT_WR)
