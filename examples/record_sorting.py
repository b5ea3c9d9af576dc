"""Run the case study in this process with toy arms, and record what its nodes do (paper, Fig. 19).

``python record_sorting.py MODEL FOLDER`` sorts a red and a green object: a user selects the red one first,
and the green one while the red one is placed.
"""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path

from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.runtime import Candidates, Enabled, Net, Node
from dineros.runtime.channels.local import LocalNetwork
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split

MOTION = 0.5
"""Seconds that an arm moves."""


class Arm:
    """A robot arm that succeeds, some time after its command to move."""

    def __init__(self, executor: Net) -> None:
        for operation, done in (("Pick", "ObjectIsPicked"), ("Place", "ObjectIsPlaced")):
            self._attach(executor, f"T{operation}", f"T{operation}Success", done)

    def _attach(self, net: Net, begins: str, ends: str, done: str) -> None:
        finished = net.signal("RobotHasFinished")

        def arrive() -> None:
            net.signal(done).set(True, "arm")
            finished.set(True, "arm")

        @net.handler(begins, name="move_arm")
        def move(firing: object) -> None:
            threading.Timer(MOTION, arrive).start()

        @net.handler(ends, name="arm_is_free")
        def free(firing: object) -> None:
            finished.set(False, "arm")
            net.signal(done).set(False, "arm")


def record(model: sym.SystemModel, source: str, folder: Path) -> None:
    """Sort both objects."""
    network = LocalNetwork(seed=1)
    nets = {net.id: net for net in (Net(runtime, seed=1) for runtime in split(model))}
    nodes = [
        Node(net, network.transport(), JournalRecorder(folder, net.id, source=source))
        for net in nets.values()
    ]
    Arm(nets["executor"])

    @nets["sensorics"].handler("TSense", name="look", thread=True)
    def look(firing: object) -> None:
        time.sleep(0.15)

    @nets["executor"].selection
    def believe_the_sensor(candidates: Candidates) -> Enabled | None:
        enabled = list(candidates)
        return next((one for one in enabled if one.id == "TSafe"), enabled[0] if enabled else None)

    network.start()
    for node in nodes:
        node.start()
    try:
        nets["sensorics"].signal("Sensor").set(True, "sensor")
        _play(nets)
    finally:
        for node in nodes:
            node.stop()
        network.stop()


def _play(nets: dict[str, Net]) -> None:
    selector, executor, feedback = (nets[name] for name in ("selector", "executor", "feedback"))
    time.sleep(0.4)
    selector.signal("Red").set(True, "user")
    executor.wait_for(lambda state: _working(state, "Place"), timeout=20)
    time.sleep(MOTION / 3)
    selector.signal("Green").set(True, "user")
    executor.signal("Danger").set(True, "light barrier")
    time.sleep(0.05)
    executor.signal("Danger").set(False, "light barrier")
    feedback.wait_for(lambda state: state.count("Shown") == 2, timeout=20)


def _working(state: object, service: str) -> bool:
    return any(state.count(f"{service}[{number}].{service}Run") for number in (1, 2))  # type: ignore[attr-defined]


if __name__ == "__main__":
    path, folder = Path(sys.argv[1]), Path(sys.argv[2])
    model = load(path)
    assert isinstance(model, sym.SystemModel)
    record(model, str(path), folder)
