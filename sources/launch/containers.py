"""Determines the executor of a component from its container in a launch file."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.sources.launch.started import Started, full

Executor = tuple[str, int | str]
"""Class of an executor, and its threads; ``processors``: as many as the machine has."""

EXECUTORS: dict[str, Executor] = {
    "component_container": ("SingleThreadedExecutor", 1),
    "component_container_mt": ("MultiThreadedExecutor", "processors"),
    "component_container_isolated": ("SingleThreadedExecutor", 1),
    "component_container_event": ("EventsExecutor", 1),
    "component_container_callback_group": ("SingleThreadedExecutor", "open"),
}
"""By container of ``rclcpp_components``."""
ALONE = "component_container_isolated"
"""The container that gives each component an executor of its own."""
THREADS: dict[str, int | str] = {
    "SingleThreadedExecutor": 1,
    "StaticSingleThreadedExecutor": 1,
    "EventsExecutor": 1,
    "MultiThreadedExecutor": "processors",
}
"""By class of executor, as ``rclcpp_components_register_node`` takes it."""


def container_of(component: Started, started: Sequence[Started]) -> Started | None:
    """Return the container into which a launch file loads a component; None: it is unknown.

    A container with exactly this name is meant, or else the only one whose name differs in its namespace.
    """
    if component.within is not None:
        return component.within
    wanted = full(component.container, "")
    named = [each for each in started if each.kind != "component" and each.name and each.executable]
    ends = [each for each in named if _last(each.name) == _last(component.container)]
    for found in ([each for each in ends if full(each.name, each.namespace) == wanted], ends):
        enabled = [each for each in found if each.is_enabled] or found
        if len({full(each.name, each.namespace) for each in enabled}) == 1:
            return enabled[0]
    return None


def _last(name: str) -> str:
    return name.rpartition("/")[2]


def executor_in(component: Started, started: Sequence[Started]) -> Executor | None:
    """Return the executor that runs a component; None: unknown from its container."""
    container = container_of(component, started)
    if container is None:
        return None
    if container.executable == ALONE and container.has_threads:
        return EXECUTORS["component_container_mt"]
    return EXECUTORS.get(container.executable)
