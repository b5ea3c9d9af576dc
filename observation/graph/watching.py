"""Watches a running graph for some seconds: discovered nodes, and their responses to queries.

Nothing is published, and no interface of the system needs to be installed: ports, types and quality of
service come from discovery (DDS, "built-in topics"). Nodes with the necessary services get two queries:
whether they use simulated time, and, for managed nodes, their state.
"""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Collection
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.observation.graph.listing import Listing
from dineros.observation.graph.qualities import endpoint_of
from dineros.observation.graph.questions import Questions
from dineros.observation.systems import (
    Endpoint,
    ObservedNode,
    ObservedSystem,
    Watched,
    is_house_service,
    is_house_topic,
    is_of_action,
    name_of,
)
from dineros.runtime.ros.process.environment import DOMAINS
from dineros.runtime.ros.process.session import Session

PAUSE = 0.25
"""Seconds between two queries of the graph."""
QUIET = 1.0, 3.5
"""Seconds without changes after which a graph counts as complete: as long as it is watched, within these
bounds. A participant of DDS that was missed announces itself again after 3 s."""
SLOW = 4.0
"""Largest factor of this time on a busy machine, on which queries take longer than expected."""
MOST_MORE = 60.0
"""Largest extension of the watch by changes, in seconds."""
_GOALS = "/_action/send_goal"
_HIDDEN = "_"


def watch(
    seconds: float = 3.0,
    domain: int | None = None,
    *,
    without: Collection[str] = (),
    doubts: Callable[[ObservedSystem], bool] | None = None,
) -> ObservedSystem:
    """Return the nodes of a graph, with all ports that existed at some time.

    Hidden nodes (``_name``), such as those of tools, are omitted.

    Parameters
    ----------
    seconds : float
        Least time to watch; it is extended while there are changes, `QUIET`, `SLOW` and `MOST_MORE` say how.
    domain : int, optional
        The ROS domain; by default that of the environment.
    without : collection of str
        Full names of further nodes that are left out.
    doubts : callable, optional
        Tells whether something seems to be wrong with what was seen, such as a topic without subscribers;
        then it is watched once more before it is returned.

    Raises
    ------
    DinerosError
        ROS 2 is not there, there is no such domain, or no node in it; or the graph cannot be listed.
    """
    if domain is not None and domain not in DOMAINS:
        raise DinerosError(f"there is no ROS domain {domain}", hint="take one from 0 to 101")
    session = Session("_dineros_watching", domain=domain, make_node=_make_node)
    try:
        used = session.node.context.get_domain_id()
        session.start()
        watching = _Watching(session.node, set(without), f"ROS domain {used}", seconds)
        system = watching.system()
        if system.nodes and doubts is not None and doubts(system):
            system = watching.system(again=True)
        watching.close()
    finally:
        session.close()
    if not system.nodes:
        raise DinerosError(
            f"there is no node in ROS domain {used}",
            hint="give the domain with --domain, or watch longer with --watch",
        )
    return system


def _make_node(name: str, **options: Any) -> Any:
    from rclpy.node import Node

    return Node(name, **options, start_parameter_services=False, enable_rosout=False)


class _Watching:
    def __init__(self, node: Any, without: Collection[str], source: str, seconds: float) -> None:
        self._listing = Listing(node)
        self._without = {*without, node.get_fully_qualified_name()}
        self._source = source
        self._seconds = seconds
        self._ports: dict[str, dict[str, Counter[Any]]] = {}
        self._duplicates: set[str] = set()
        self._questions = Questions(node)
        self._began = time.monotonic()

    def system(self, *, again: bool = False) -> ObservedSystem:
        """Watch until there are no changes; return the observed system."""
        quiet = max(QUIET[0], min(self._seconds, QUIET[1]))
        begun = last_news = time.monotonic()
        least = begun + (QUIET[1] if again else self._seconds)
        present = self._look()
        slow = 1.0
        while (now := time.monotonic()) < least or (
            now < last_news + quiet * slow and now < least + MOST_MORE
        ):
            known = self._known()
            time.sleep(PAUSE)
            present = self._look()
            after = time.monotonic()
            # A machine that is too busy for this loop also delays announcements.
            slow = min(SLOW, max(1.0, (after - now) / (2 * PAUSE)))
            if self._known() != known or not self._listing.is_complete:
                last_news = after
        nodes = tuple(self._told(name, self._ports[name]) for name in sorted(self._ports))
        departed = tuple(name for name in sorted(self._ports) if name not in present)
        ended = time.monotonic()
        watched = Watched(ended - self._began, ended - last_news, ended >= last_news + quiet, again)
        return ObservedSystem(
            self._source,
            nodes,
            (),
            departed,
            tuple(sorted(self._duplicates)),
            left_out=tuple(self._listing.left_out),
            watched=watched,
        )

    def close(self) -> None:
        """Destroy the querying node."""
        self._questions.close()

    def _known(self) -> int:
        """Return the number of observed nodes and ports; elements are never removed."""
        ports = (found.total() for known in self._ports.values() for found in known.values())
        return len(self._ports) + sum(ports)

    def _look(self) -> set[str]:
        """Add the current elements; return the names of the nodes."""
        named = [(f"{namespace.rstrip('/')}/{name}", name, namespace)
                 for name, namespace in self._listing.nodes()]  # fmt: skip
        present = [each for each in named if not each[1].startswith(_HIDDEN) and each[0] not in self._without]
        self._duplicates |= {full for full, n in Counter(full for full, *_ in present).items() if n > 1}
        sight = self._topics()
        for full, name, namespace in present:
            ports = sight.get(full, {})
            self._services(full, name, namespace, ports)
            known = self._ports.setdefault(full, {})
            for role, found in ports.items():
                known[role] = known.get(role, Counter()) | found  # a node that ends loses its ports first
            self._questions.ask(full)
        return {full for full, *_ in present}

    def _topics(self) -> dict[str, dict[str, Counter[Any]]]:
        """Return the publishers and subscriptions of each node."""
        found: dict[str, dict[str, Counter[Any]]] = {}
        asked = {"publishers": self._listing.publishers, "subscribers": self._listing.subscribers}
        for topic, types in self._listing.topics():
            if is_of_action(topic) or all(is_house_topic(topic, type) for type in types):
                continue
            for role, infos in asked.items():
                for info in infos(topic):
                    if not is_house_topic(topic, info.topic_type):
                        full = f"{info.node_namespace.rstrip('/')}/{info.node_name}"
                        ports = found.setdefault(full, {}).setdefault(role, Counter())
                        ports[endpoint_of(topic, info)] += 1
        return found

    def _services(self, full: str, name: str, namespace: str, ports: dict[str, Counter[Any]]) -> None:
        """Add the services and actions of a node."""
        for role in ("servers", "clients"):
            services = self._listing.services(role, name, namespace)
            for service, types in services:
                for type in types:
                    if service.endswith(_GOALS):
                        action = Endpoint(service.removesuffix(_GOALS), type.removesuffix("_SendGoal"))
                        ports.setdefault(f"action_{role}", Counter())[action] = 1
                    elif not is_of_action(service) and not is_house_service(type):
                        ports.setdefault(role, Counter())[Endpoint(service, type)] = 1
                    if role == "servers":
                        self._questions.can_be_asked(full, service, type)

    def _told(self, name: str, ports: dict[str, Counter[Any]]) -> ObservedNode:
        ordered: dict[str, Any] = {
            role: tuple(sorted(found.elements(), key=lambda port: (name_of(port), port.type)))
            for role, found in ports.items()
        }
        simulated, state = self._questions.answers(name)
        return ObservedNode(name, **ordered, use_sim_time=simulated, lifecycle=state)
