"""Sixteen systems, and what an independent program counted of each, in whole units of time.

`longest` is the greatest number of messages in each reader history. `lost` names the readers that can lose
one, `missed` the timers that can lose a tick.
"""

from __future__ import annotations

from typing import Any, NamedTuple


class Counted(NamedTuple):
    """A system, and its facts."""

    system: dict[str, Any]
    longest: dict[str, int]
    lost: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()


def _timer(
    name: str, node: str, period: int, script: list[Any], offset: int | str = 0, group: str = "default"
) -> dict[str, Any]:
    return {"name": name, "node": node, "period": period, "offset": offset, "group": group, "script": script}


def _reader(name: str, node: str, topic: str, depth: int, script: list[Any]) -> dict[str, Any]:
    return {"name": name, "node": node, "topic": topic, "depth": depth, "group": "default", "script": script}


def _system(
    callbacks: list[dict[str, Any]],
    latency: dict[str, tuple[int, int]] | None = None,
    threads: dict[str, int] | None = None,
) -> dict[str, Any]:
    nodes = {each["node"]: {"threads": (threads or {}).get(each["node"], 1)} for each in callbacks}
    return {"nodes": nodes, "latency": latency or {}, "chains": [], "callbacks": callbacks}


def _work(least: int, most: int, *topics: str) -> list[Any]:
    return [["work", least, most], *(["publish", topic] for topic in topics)]


def _logger(
    period: int, work: tuple[int, int], latency: tuple[int, int], depth: int, log: tuple[int, int]
) -> dict[str, Any]:
    callbacks = [
        _timer("tick", "a", period, _work(*work, "t")),
        _reader("log", "b", "t", depth, _work(*log)),
    ]
    return _system(callbacks, {"t": latency})


def _two(
    fast: tuple[int, int], slow: tuple[int, int], threads: int = 1, groups: tuple[str, str] = ("g", "g")
) -> dict[str, Any]:
    callbacks = [
        _timer("fast", "a", 5, _work(*fast), "any", groups[0]),
        _timer("slow", "a", 10, _work(*slow), "any", groups[1]),
    ]
    return _system(callbacks, threads={"a": threads})


def _filter(step: list[Any], *others: dict[str, Any]) -> dict[str, Any]:
    callbacks = [
        _timer("sense", "a", 20, _work(1, 2, "scan")),
        _reader("filter", "b", "scan", 1, step),
        _reader("act", "c", "pose", 1, _work(1, 1)),
        *others,
    ]
    return _system(callbacks, {"scan": (0, 1), "pose": (0, 1)})


def _asking(*others: dict[str, Any]) -> dict[str, Any]:
    ask = [["work", 0, 1], ["call", "look", "answers"], ["work", 1, 1], ["publish", "found"]]
    look = {"name": "look", "node": "b", "service": "look", "depth": 10, "group": "default"}
    callbacks = [_timer("ask", "a", 12, ask), {**look, "script": _work(2, 4)}, *others]
    return _system(callbacks, {"look": (0, 1)}, {"a": 2})


_FUSED = _system(
    [
        _timer("cam", "a", 6, _work(1, 1, "img")),
        _timer("imu", "b", 3, _work(0, 1, "turn"), "any"),
        _reader("see", "c", "img", 1, _work(2, 3, "est")),
        _reader("feel", "c", "turn", 2, _work(0, 1)),
        _reader("use", "d", "est", 1, _work(1, 1)),
    ],
    {"img": (0, 0), "turn": (0, 0), "est": (0, 0)},
)
_OTHER = _timer("other", "b", 10, _work(2, 4), "any")
_SPIN = _timer("spin", "b", 6, _work(1, 3), "any")

COUNTED: dict[int, Counted] = {
    1: Counted(_logger(10, (0, 1), (0, 1), 2, (2, 5)), {"log": 1}),
    2: Counted(_logger(4, (0, 1), (0, 1), 2, (2, 5)), {"log": 2}, ("log",)),
    3: Counted(_logger(5, (0, 1), (0, 1), 2, (2, 5)), {"log": 1}),
    4: Counted(_logger(4, (0, 0), (0, 3), 1, (1, 4)), {"log": 1}),
    5: Counted(_logger(4, (0, 0), (6, 6), 2, (1, 2)), {"log": 1}),
    6: Counted(_logger(4, (0, 0), (2, 9), 1, (1, 2)), {"log": 1}, ("log",)),
    7: Counted(_two((1, 2), (2, 3)), {}),
    8: Counted(_two((2, 3), (4, 6)), {}, missed=("fast", "slow")),
    9: Counted(_two((1, 2), (2, 3), 2), {}),
    10: Counted(_two((1, 2), (2, 3), 2, ("g", "h")), {}),
    11: Counted(_filter(_work(3, 6, "pose")), {"filter": 1, "act": 1}),
    12: Counted(_filter(_work(3, 6, "pose"), _OTHER), {"filter": 1, "act": 1}),
    13: Counted(_filter([["open", 3, 6, "pose"]]), {"filter": 1, "act": 1}),
    14: Counted(_FUSED, {"see": 1, "feel": 2, "use": 1}),
    15: Counted(_asking(), {}),
    16: Counted(_asking(_SPIN), {}),
}
"""By number."""

RESPONSES: dict[int, dict[str, tuple[int, int]]] = {
    1: {"tick": (0, 1), "log": (2, 5)},
    2: {"log": (2, 15)},
    3: {"log": (2, 7)},
    4: {"log": (1, 7)},
    5: {"log": (1, 2)},
    6: {"log": (1, 4)},
    7: {"fast": (1, 5), "slow": (2, 5)},
    8: {"fast": (2, 24), "slow": (4, 21)},
    9: {"fast": (1, 5), "slow": (2, 5)},
    10: {"fast": (1, 2), "slow": (2, 3)},
    12: {"filter": (3, 10), "other": (2, 10)},
    14: {"see": (2, 4), "feel": (0, 4)},
    15: {"look": (2, 4)},
    16: {"look": (2, 7), "spin": (1, 7)},
}
"""By number, the least and the greatest response time of callbacks, in units."""

CHAINS: dict[int, tuple[str, str, int, int, bool]] = {
    1: ("tick", "log", 2, 7, False),
    2: ("tick", "log", 2, 15, True),
    3: ("tick", "log", 2, 7, False),
    4: ("tick", "log", 1, 7, False),
    5: ("tick", "log", 7, 8, False),
    6: ("tick", "log", 3, 11, True),
    11: ("sense", "act", 5, 11, False),
    12: ("sense", "act", 5, 15, False),
    13: ("sense", "act", 2, 11, False),
    14: ("cam", "use", 4, 6, False),
    15: ("ask", "found", 3, 8, False),
    16: ("ask", "found", 3, 11, False),
}
"""By number: from where to where, the least and the greatest latency, and whether data can be lost."""
