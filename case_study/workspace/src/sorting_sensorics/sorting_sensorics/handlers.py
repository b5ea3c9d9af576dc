"""What the node `/sensorics` does when its transitions fire: it answers with what the sensor sees."""

from __future__ import annotations

import time

from dineros.runtime import Net
from sorting_cell.cell import Cell, connect

from . import firings

_cell: Cell


def configure(net: Net) -> None:
    """Connect the sensor."""
    global _cell
    _cell = connect(net)


@firings.on("TSense")
def sense(firing: firings.TSenseFiring) -> firings.Outcome:
    """SensorEntry -> SensorExit, while Sensor."""
    return {"humanDetected": _cell.is_human_inside, "sensorData": f"{time.time():.3f}"}
