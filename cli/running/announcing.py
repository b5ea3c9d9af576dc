"""Announces on ROS that the process of a node has ended, by a process that is started when needed."""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.metamodel.files.reading import open_plain
from dineros.runtime.application.supervisor import ProcessEvent, status_text
from dineros.runtime.nodes.status import Status

if TYPE_CHECKING:
    from dineros.runtime.nets.ports import Ports

_PATIENCE = 5.0
"""Seconds that the process has to end."""


class Announcer:
    """Publishes the status of crashed nodes on their ``~/state`` while they are down.

    Parameters
    ----------
    nodes : mapping of str to Ports
        Names of the nodes in ROS, by the names of their processes.
    environment : mapping of str to str
        That of the nodes.
    log : Path
        Takes what the process prints.
    """

    def __init__(self, nodes: Mapping[str, Ports], environment: Mapping[str, str], log: Path) -> None:
        self._nodes = nodes
        self._environment = environment
        self._log = log
        self._process: subprocess.Popen[str] | None = None

    def tell(self, event: ProcessEvent) -> None:
        """Announce that a node has crashed, or withdraw the announcement when the node is restarted."""
        ports = self._nodes.get(event.name)
        if ports is None or (event.event != "failed" and self._process is None):
            return
        order = {"topic": f"/{ports.namespace.strip('/')}/{ports.name}/state".replace("//", "/")}
        if event.event == "failed":
            said = f": {event.said}" if event.said else ""
            status = Status(ports.node, event.time, "crashed", f"{status_text(event.status)}{said}")
            order["text"] = status.json()
        elif event.event != "restarted":
            return
        self._write(json.dumps(order))

    def _write(self, line: str) -> None:
        if self._process is None:
            flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND
            with os.fdopen(open_plain(self._log, flags, follow_links=False), "ab") as log:
                self._process = subprocess.Popen(
                    [sys.executable, "-P", "-m", "dineros.runtime.ros.channels.announcer"],
                    stdin=subprocess.PIPE,
                    stdout=log,
                    stderr=subprocess.STDOUT,
                    env=dict(self._environment),
                    text=True,
                    start_new_session=True,  # Ctrl-C comes to us alone
                )
        assert self._process.stdin is not None
        with contextlib.suppress(OSError):  # if it does not run, nothing is announced
            self._process.stdin.write(line + "\n")
            self._process.stdin.flush()

    def close(self) -> None:
        """Stop the process, if there is one."""
        process, self._process = self._process, None
        if process is None:
            return
        try:
            with contextlib.suppress(OSError, subprocess.TimeoutExpired):
                process.communicate(timeout=_PATIENCE)
        finally:
            process.kill()
            process.wait()
