"""One participant with names that ROS does not allow hides nothing of the others; late ones are waited
for."""

from __future__ import annotations

import time
from types import SimpleNamespace
from typing import Any

import pytest

from dineros.metamodel.errors import DinerosError
from dineros.observation.findings.mismatches import mismatches
from dineros.observation.graph import watching
from dineros.observation.graph.listing import UNKNOWN, Listing
from dineros.observation.systems import ObservedSystem

pytest.importorskip("rclpy")

STRING = "std_msgs/msg/String"
ODD = ["a b", "é", "x\x1b[2J", "0", "", "a-b", "$(touch MARK)", "A" * 300]


def refused(name: str) -> Exception:
    from rclpy.impl.implementation_singleton import rclpy_implementation

    kinds = (ValueError, rclpy_implementation.RCLError, RuntimeError)
    return kinds[len(name) % 3](f"{name} is not allowed")


class Graph:
    """Stands for an rclpy node: what others announce, by seconds from which it is known."""

    def __init__(self, odd: list[str] | None = None, *, nameless: bool = False, late: float = 0.0) -> None:
        self.odd = odd or []
        self.nameless = nameless
        self.late = late
        self.began = time.monotonic()
        self.unknown = 0.0

    @property
    def _is_late(self) -> bool:
        return time.monotonic() < self.began + self.late

    def get_fully_qualified_name(self) -> str:
        return "/_watching"

    def get_node_names_and_namespaces(self) -> list[tuple[str, str]]:
        if self.nameless:
            raise refused("node")
        ends = [("lidar", "/")] if self._is_late else [("lidar", "/"), ("mapper", "/")]
        return [*((name, "/") for name in self.odd), *ends]

    def get_topic_names_and_types(self, no_demangle: bool = False) -> list[tuple[str, list[str]]]:
        names = ["rt/scan" if no_demangle else "/scan", *(f"/{name}" for name in self.odd)]
        return [(name, [STRING]) for name in names]

    def _infos(self, topic: str, node: str) -> list[Any]:
        if topic not in ("/scan", "rt/scan"):
            raise refused(topic)
        is_known = time.monotonic() >= self.began + self.unknown
        quality = SimpleNamespace(
            reliability=SimpleNamespace(name="RELIABLE"),
            durability=SimpleNamespace(name="VOLATILE"),
            liveliness=SimpleNamespace(name="AUTOMATIC"),
            history=SimpleNamespace(name="KEEP_LAST"),
            depth=10,
            **{
                each: SimpleNamespace(nanoseconds=0)
                for each in ("deadline", "liveliness_lease_duration", "lifespan")
            },
        )
        name = node if is_known else UNKNOWN
        return [SimpleNamespace(node_name=name, node_namespace="/", topic_type=STRING, qos_profile=quality)]

    def get_publishers_info_by_topic(self, topic: str, no_mangle: bool = False) -> list[Any]:
        return self._infos(topic, "lidar")

    def get_subscriptions_info_by_topic(self, topic: str, no_mangle: bool = False) -> list[Any]:
        return [] if self._is_late else self._infos(topic, "mapper")

    def get_service_names_and_types_by_node(self, name: str, namespace: str) -> list[tuple[str, list[str]]]:
        if name in self.odd:
            raise refused(name)
        if name == "mapper":
            return []
        return [("/grip", ["std_srvs/srv/Trigger"]), *((f"/{odd}", ["a/srv/B"]) for odd in self.odd)]

    def get_client_names_and_types_by_node(self, name: str, namespace: str) -> list[tuple[str, list[str]]]:
        return [] if name == "lidar" else self.get_service_names_and_types_by_node("lidar", namespace)


def test_odd_names_are_left_out_and_the_others_listed() -> None:
    listing = Listing(Graph(ODD))
    assert list(listing.topics()) == [("/scan", [STRING])]
    assert listing.nodes() == [("lidar", "/"), ("mapper", "/")]
    assert listing.services("servers", "lidar", "/") == [("/grip", ["std_srvs/srv/Trigger"])]
    assert listing.services("servers", ODD[0], "/") == []
    assert len(listing.left_out) == 3 * len(ODD)
    assert all(each.isprintable() for each in listing.left_out)


def test_a_node_without_a_name_hides_no_other() -> None:
    listing = Listing(Graph(nameless=True))
    assert listing.nodes() == [("lidar", "/"), ("mapper", "/")]
    assert list(listing.left_out) == ["node '': not a name that ROS 2 allows"]


def test_what_cannot_be_listed_is_one_line() -> None:
    graph = Graph()
    graph.get_topic_names_and_types = lambda *_: b"\xff".decode()  # type: ignore[method-assign, assignment]
    with pytest.raises(DinerosError, match="some participant announces a name that is not text"):
        list(Listing(graph).topics())


@pytest.fixture
def hasty(monkeypatch: pytest.MonkeyPatch) -> None:
    """Watch for shorter than one does."""
    monkeypatch.setattr(watching, "PAUSE", 0.02)
    monkeypatch.setattr(watching, "QUIET", (0.1, 0.4))
    monkeypatch.setattr(watching, "SLOW", 1.0)


def watch(graph: Graph, *, again: bool = False) -> ObservedSystem:
    class Quiet:
        def can_be_asked(self, *_: object) -> None: ...
        def ask(self, _: str) -> None: ...
        def answers(self, _: str) -> tuple[None, None]:
            return None, None

    watch = watching._Watching(graph, (), "ROS domain 1", 0.1)
    watch._questions = Quiet()  # type: ignore[assignment]
    system = watch.system()
    return watch.system(again=True) if again and mismatches(system) else system


def test_what_seems_to_be_missing_is_looked_for_again(hasty: None) -> None:
    first = watch(Graph(late=0.3))
    assert [finding.rule for finding in mismatches(first)] == ["topic-unheard"]
    assert first.watched is not None and not first.watched.is_checked
    second = watch(Graph(late=0.3), again=True)
    assert mismatches(second) == []
    assert second.watched is not None and second.watched.is_checked and second.watched.is_stable
    assert second.watched.seconds > 0.4
    assert ", because something seemed to be missing; nothing new in the last 0." in str(second.watched)


def test_endpoints_whose_nodes_are_not_known_yet_are_waited_for(hasty: None) -> None:
    graph = Graph()
    graph.unknown = 0.5
    system = watch(graph)
    assert [node.name for node in system.nodes] == ["/lidar", "/mapper"]
    assert mismatches(system) == []
    assert system.watched is not None and system.watched.seconds > 0.5


def test_a_graph_that_never_rests_is_said_to_change(hasty: None, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(watching, "MOST_MORE", 0.3)
    graph = Graph()
    graph.unknown = 60.0
    watched = watch(graph).watched
    assert watched is not None and not watched.is_stable
    assert "and the graph was still changing: parts may be missing" in str(watched)
