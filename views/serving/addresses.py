"""Stores port and token of a page, so that an open page finds its server again after a restart."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import secrets
import socket
from dataclasses import asdict, dataclass
from pathlib import Path

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files.reading import resolved
from dineros.metamodel.json_text import decode_json

HOST = "127.0.0.1"

_MOST = 1000  # bytes of a remembered address


@dataclass(frozen=True)
class Address:
    """The port of a page, and its token."""

    port: int
    token: str


def bind(port: int) -> socket.socket:
    """Return a socket that listens on this machine only.

    Raises
    ------
    OSError
        The port is in use.
    """
    listening = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
    try:
        # A port whose last connections are only fading may be taken again, one that is in use may not.
        listening.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listening.bind((HOST, port))
        listening.listen(128)
    except OSError:
        listening.close()
        raise
    return listening


def open_address(path: Path, port: int) -> tuple[socket.socket, str]:
    """Return a socket and a token for the page of a path: the last ones if the port is free.

    Parameters
    ----------
    path : Path
        The path that the page follows.
    port : int
        The port; 0: the last one, or any.
    """
    last = recall(path)
    wanted = port or (last.port if last else 0)
    try:
        listening = bind(wanted)
    except OSError:
        if port:
            raise
        listening, last = bind(0), None  # another server of the same path still runs: its token is its own
    token = last.token if last else secrets.token_urlsafe(24)
    remember(path, Address(listening.getsockname()[1], token))
    return listening, token


def recall(path: Path) -> Address | None:
    """Return the last address of a path, if there is one."""
    try:
        with _file(path).open("rb") as stream:
            found = decode_json(stream.read(_MOST + 1), limit=_MOST)
        return Address(int(found["port"]), str(found["token"]))
    except (OSError, ValueError, KeyError, TypeError, DinerosError):
        return None


def remember(path: Path, address: Address) -> None:
    """Store an address, readable by this user only; if this fails, pages must be opened again."""
    file = _file(path)
    with contextlib.suppress(OSError):
        file.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o600)
        with os.fdopen(descriptor, "w", encoding="ascii") as stream:
            json.dump(asdict(address), stream)


def _file(path: Path) -> Path:
    """Return the file for a path, in the state folder of programs (XDG Base Directory Specification)."""
    state = os.environ.get("XDG_STATE_HOME") or str(Path.home() / ".local" / "state")
    name = hashlib.sha256(str(resolved(path)).encode()).hexdigest()[:16]
    return Path(state) / "dineros" / "live" / f"{name}.json"
