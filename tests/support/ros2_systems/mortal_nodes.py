"""Nodes of the case study as processes that kill themselves with SIGKILL while they write their journals.

One process loads everything and forks a child per node, as it is told on its standard input:
``start NODE SEED POINT PART`` starts a node, which dies at its POINT-th write to its journal (0: never),
after PART of the bytes (per mille) of that write; ``stop`` ends all nodes in good order. It says ``died
NODE`` for each that was killed and ``ended NODE`` for each that was stopped.
"""

from __future__ import annotations

import os
import random
import signal
import sys
import threading
import time
from pathlib import Path
from typing import Any

from dineros.metamodel import rtm
from dineros.metamodel.files import load
from dineros.metamodel.settings import apply
from dineros.runtime import Net, Node
from dineros.runtime.journal import recorder as recorder_module
from dineros.runtime.journal import resume_journal
from dineros.transformations.flattening.split import split
from tests.support.programs.socket_transport import SocketTransport

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"
PART_BYTES = 8000
"""Small, so that parts are rotated while nodes are killed."""


class DeadlySystem:
    """Stands in for the module `os` where journals are written; kills the process at one of the writes."""

    def __init__(self, point: int, part: int) -> None:
        self._left, self._part = point, part

    def __getattr__(self, name: str) -> Any:
        return getattr(os, name)

    def write(self, file: int, content: bytes) -> int:
        self._left -= 1
        if self._left == 0:
            os.write(file, content[: len(content) * self._part // 1000])
            os.kill(os.getpid(), signal.SIGKILL)
        return os.write(file, content)


def run_node(model: rtm.RuntimeModel, folder: Path, broker: Path, seed: int, point: int, part: int) -> None:
    """Run a node until SIGTERM, or until it kills itself."""
    stopping = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stopping.set())
    signal.pthread_sigmask(signal.SIG_UNBLOCK, {signal.SIGTERM})
    if point:
        vars(recorder_module)["os"] = DeadlySystem(point, part)
    net = Net(model, seed=seed)
    recorder, checkpoint = resume_journal(folder, net.id, part_bytes=PART_BYTES, kept_parts=None)
    node = Node(net, SocketTransport(broker), recorder, resume=checkpoint, request_timeout=0.5)
    outside = random.Random(seed)
    node.start()
    while not stopping.wait(0.002):
        if node.failure is not None:
            raise node.failure
        for name in net.structure.signals:
            if outside.random() < 0.3:
                net.signal(name).set(outside.random() < 0.5)
    node.stop()


def main(folder: Path, broker: Path) -> None:
    """Start nodes as told, and tell how they end."""
    model = load(CASE_STUDY)
    for setting in ("RedObjects.tokens=2", "GreenObjects.tokens=2"):
        apply(model, setting)
    models = {runtime_model.node.id: runtime_model for runtime_model in split(model)}  # type: ignore[arg-type]
    running: dict[int, str] = {}
    lock = threading.Lock()
    commands_over = threading.Event()

    def read() -> None:
        # A child that is told to stop before it can listen learns of it once it does.
        signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGTERM})
        for line in sys.stdin:
            command, *arguments = line.split()
            with lock:
                if command == "start":
                    name, (seed, point, part) = arguments[0], map(int, arguments[1:])
                    child = os.fork()
                    if child == 0:
                        try:
                            run_node(models[name], folder, broker, seed, point, part)
                        except BaseException:
                            import traceback

                            traceback.print_exc()
                            os._exit(1)
                        os._exit(0)
                    running[child] = name
                else:
                    for child in running:
                        os.kill(child, signal.SIGTERM)
        with lock:
            for child in running:
                os.kill(child, signal.SIGKILL)
        commands_over.set()

    print("ready", flush=True)
    threading.Thread(target=read, daemon=True).start()
    while running or not commands_over.is_set():
        try:
            child, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            child = 0
        if child:
            with lock:
                name = running.pop(child)
            killed = os.WIFSIGNALED(status) and os.WTERMSIG(status) == signal.SIGKILL
            said = "died" if killed else "ended" if status == 0 else "failed"
            print(f"{said} {name}", flush=True)
        else:
            time.sleep(0.005)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]))
