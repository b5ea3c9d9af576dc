"""Determines the executor of a component from its container in a launch file."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.sources.launch.description import Started, full

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
    """Return the container into which a launch file loads a component; None: nothing starts it."""
    name = component.container.rpartition("/")[2]
    for each in started:
        if each.kind != "component" and each.name and each.executable:
            names = {each.name, each.name.rpartition("/")[2], full(each.name, each.namespace)}
            if component.container in names or name in names:
                return each
    return None


def executor_in(component: Started, started: Sequence[Started]) -> Executor | None:
    """Return the executor that runs a component; None: unknown from its container."""
    container = container_of(component, started)
    if container is None:
        return None
    if container.executable == ALONE and container.has_threads:
        return EXECUTORS["component_container_mt"]
    return EXECUTORS.get(container.executable)
