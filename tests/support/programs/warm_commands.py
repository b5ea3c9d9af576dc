"""The command ``dineros`` as a fork of a process that has imported the engines, which is most of its time.

Other functions can be such commands, too. Each command is a separate process. It has the arguments, the
folder, the environment and the open files of the calling process, which ends with the exit status of the
command. Tests that need a start without a warm process run ``python -m dineros.cli.main``, as the pages in
`COLD` of `tests/docs/test_examples.py` do.

>>> python tests/support/programs/warm_commands.py SOCKET  # waits for commands
>>> python tests/support/programs/warm_commands.py SOCKET dineros.cli.main:main validate model.sym.xmi
"""

from __future__ import annotations

import json
import os
import select
import signal
import socket
import sys
from contextlib import contextmanager

TYPE_CHECKING = False  # as type checkers know it from `typing`, which takes long to import, too
if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path
    from typing import Any

STANDARD = (0, 1, 2)
_READ = 1 << 20


DINEROS = "dineros.cli.main:main"


def main(path: str, called: str = "", *arguments: str) -> int:
    """Serve commands at a socket until standard input ends; with what is called, be a command."""
    if called:
        return _ask(path, called, list(arguments))
    _prepare()
    with socket.socket(socket.AF_UNIX) as listening:
        listening.bind(path)
        listening.listen()
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)  # nobody waits for those that answer
        print("ready", flush=True)
        while True:
            readable, _, _ = select.select([sys.stdin, listening], [], [])
            if sys.stdin in readable:
                return 0
            connection, _ = listening.accept()
            if os.fork() == 0:
                signal.signal(signal.SIGCHLD, signal.SIG_DFL)
                listening.close()
                _answer(connection)
                os._exit(0)
            connection.close()


@contextmanager
def served(path: Path) -> Iterator[Path]:
    """Serve commands at a socket."""
    import subprocess

    command = [sys.executable, "-P", __file__, str(path)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as server:
        assert server.stdin and server.stdout
        assert server.stdout.readline() == "ready\n"
        yield path
        server.stdin.close()


def program(place: Path, called: str = DINEROS, first: str = "") -> str:
    """Return a script that is the command ``dineros``, a fork of what serves at a socket.

    Parameters
    ----------
    place : Path
        The socket.
    called : str
        The module and the function without parameters that are called instead.
    first : str
        An argument before all others.
    """
    before = f'"{called}" "{first}"' if first else f'"{called}"'
    return f'#!/bin/sh\nexec "{sys.executable}" -I -S "{__file__}" "{place}" {before} "$@"\n'


def _ask(path: str, called: str, arguments: list[str]) -> int:
    """Have a command run with the open files of this process; return its exit status."""
    folder = os.getcwd()  # noqa: PTH109 - `pathlib` takes as long to import as all of this
    asked = {"called": called, "arguments": arguments, "folder": folder, "environment": dict(os.environ)}
    with socket.socket(socket.AF_UNIX) as connection:
        connection.connect(path)
        socket.send_fds(connection, [b"\0"], STANDARD)
        connection.sendall(json.dumps(asked).encode())
        connection.shutdown(socket.SHUT_WR)
        return int(connection.recv(16))


def _prepare() -> None:
    """Import what commands import, in the way they do it."""
    import gc
    import pkgutil
    from importlib import import_module

    from dineros import analysis
    from dineros.cli import commands
    from dineros.cli.quick_start import start_quickly

    start_quickly()
    for package in (commands, analysis):
        for module in pkgutil.walk_packages(package.__path__, f"{package.__name__}."):
            import_module(module.name)
    gc.collect()
    gc.freeze()  # a fork that looks at all objects copies their memory
    gc.get_freeze_count = lambda: 1  # for the same reason: counting walks through all of them


def _answer(connection: socket.socket) -> None:
    """Run the command that a connection asks for; end it when nobody waits for it any more."""
    _, files, _, _ = socket.recv_fds(connection, 1, len(STANDARD))
    asked = json.loads(b"".join(iter(lambda: connection.recv(_READ), b"")))
    child = os.fork()
    if child == 0:
        connection.close()
        _become(asked, files)
    for file in files:
        os.close(file)
    for file in STANDARD:
        os.close(file)
    watched = os.pidfd_open(child)
    hung_up = select.poll()
    hung_up.register(connection, 0)  # hang-ups alone
    hung_up.register(watched, select.POLLIN)
    if watched not in dict(hung_up.poll()):
        os.kill(child, signal.SIGKILL)
    _, status = os.waitpid(child, 0)
    status = os.waitstatus_to_exitcode(status)
    connection.sendall(str(status if status >= 0 else 128 - status).encode())


def _become(asked: dict[str, Any], files: list[int]) -> None:
    """Be the command that was asked for, to the end."""
    import atexit
    import threading
    import traceback
    from importlib import import_module

    for file, place in zip(files, STANDARD, strict=True):
        os.dup2(file, place)
        os.close(file)
    os.chdir(asked["folder"])
    os.environ.clear()
    os.environ.update(asked["environment"])
    sys.argv[1:] = asked["arguments"]
    sys.path[0] = asked["folder"]  # as `python -m` has it
    if asked["called"] != DINEROS:
        sys.path.append(__file__.rpartition("/tests/")[0])
    status: object = 1
    try:
        module, _, function = asked["called"].partition(":")
        getattr(import_module(module), function)()
    except SystemExit as ended:
        status = ended.code
    except Exception:
        traceback.print_exc()
    else:
        status = 0
    finally:  # as `multiprocessing` ends a fork; taking all modules down would copy their memory
        threading._shutdown()  # type: ignore[attr-defined]
        atexit._run_exitfuncs()
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(status if isinstance(status, int) else 1)


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
