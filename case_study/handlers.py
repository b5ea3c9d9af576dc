"""The handlers of the sorting application for runs without ROS: those of the workspace, in a simulation."""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path

from dineros.metamodel.errors import DinerosError, Location
from dineros.runtime import Net
from dineros.runtime.application.simulation import LocalApplication

SOURCES = Path(__file__).resolve().parent / "workspace" / "src"
if not (SOURCES / "sorting_interfaces").is_dir():
    raise DinerosError("the workspace is not generated yet", location=Location(SOURCES), hint="make install")
sys.path[:0] = [str(package) for package in sorted(SOURCES.glob("sorting_*"))]

PERIOD = 0.05


def configure(net: Net) -> None:
    """Give a node the handlers of its package."""
    import_module(f"sorting_{net.id}.base").register(net)


def simulate(application: LocalApplication) -> None:
    """Let the application work in a simulated cell."""
    from sorting_cell.cell import use_local
    from sorting_cell.world import Visit, World

    nets = application.nets
    cell = World(
        lambda node, signal, value: nets[node].signal(signal).set(value, "cell"),
        visits=[Visit(motion=3, after=0.2, stay=1.0)],
    )
    use_local(cell)
    cell.start()
    application.every(PERIOD, cell.advance)
