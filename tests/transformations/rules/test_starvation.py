"""Starvation: which callbacks can wait forever in which order, as rclcpp and rclpy were seen to do."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.analysis.timed.nets import compile_timed_net
from dineros.transformations.flattening.flatten import flatten
from tests.support.timed_systems.models import System, model_of

Row = tuple[int, int, str]


def timers(threads: int, order: str, *rows: Row) -> System:
    """Return a node with timers: period, duration and exclusive group of each."""
    callbacks = [
        {
            "name": f"t{number}", "node": "n", "period": period, "offset": 0, "group": group,
            "script": [["work", work, work]],
        }
        for number, (period, work, group) in enumerate(rows)
    ]  # fmt: skip
    nodes = {"n": {"threads": threads, "order": order}}
    return {"nodes": nodes, "latency": {}, "callbacks": callbacks}


def holds(system: System, formula: str) -> bool:
    net = compile_timed_net(flatten(model_of(system), "none", times=True).net)
    answer = verify_timed_ltl(net, formula)
    assert answer.status in ("holds", "violated")
    return answer.status == "holds"


def starves(system: System, timer: str) -> bool:
    return not holds(system, f"G (({timer}.due >= 1) -> F ({timer}.due == 0))")


CASES: dict[str, tuple[tuple[Row, ...], str]] = {
    "three timers, two groups": (((1000, 1000, "a"), (1000, 500, "a"), (1000, 500, "b")), "t1"),
    "four timers": (((1000, 500, "a"), (1000, 500, "b"), (1000, 500, "c"), (1000, 1, "c")), "t3"),
    "four periods": (((1000, 333, "a"), (1000, 333, "b"), (500, 334, "c"), (5000, 1, "c")), "t3"),
}


@pytest.mark.long
@pytest.mark.parametrize("case", CASES)
def test_a_timer_can_starve_with_two_threads(case: str) -> None:
    rows, timer = CASES[case]
    assert starves(timers(2, "rclcpp", *rows), timer)


@pytest.mark.long
def test_nothing_starves_with_one_thread_and_a_wait_result() -> None:
    rows, timer = CASES["three timers, two groups"]
    assert starves(timers(1, "any", *rows), timer)
    assert not starves(timers(1, "rclcpp", *rows), timer)


def copying(threads: int, work: int, order: str = "rclpy", own_groups: bool = False) -> System:
    """Return a node with a timer of 50 ms that works so long, and a subscription, which gets messages."""
    callbacks: list[dict[str, Any]] = [
        {
            "name": "send", "node": "m", "period": 100, "offset": "any", "group": "default",
            "script": [["work", 0, 0], ["publish", "data"]],
        },
        {
            "name": "slow", "node": "n", "period": 50, "offset": 0, "group": "default",
            "script": [["work", work, work]],
        },
        {
            "name": "copy", "node": "n", "topic": "data", "depth": 3,
            "group": "own" if own_groups else "default", "script": [["work", 1, 1]],
        },
    ]  # fmt: skip
    nodes = {"m": {"threads": 1}, "n": {"threads": threads, "order": order}}
    return {"nodes": nodes, "latency": {"data": (0, 1)}, "callbacks": callbacks}


@pytest.mark.long
@pytest.mark.parametrize(
    ("threads", "work", "own_groups", "is_copied"),
    [(1, 1, False, True), (1, 100, False, True), (4, 100, False, False), (4, 40, False, True),
     (4, 100, True, True)],
)  # fmt: skip
def test_a_slow_timer_starves_a_subscription_only_with_more_threads_in_one_group(
    threads: int, work: int, own_groups: bool, is_copied: bool
) -> None:
    """As rclpy was seen to do: of 80 messages, 80, 38, 0 or 1, 80, and 80 were copied."""
    waits = "data.reader.copy.heard.Load >= 1"
    taken = "fired(data.reader.copy.heard.out)"
    assert holds(copying(threads, work, own_groups=own_groups), f"G (({waits}) -> F {taken})") == is_copied


@pytest.mark.long
def test_in_any_order_the_same_timer_starves_it_with_one_thread() -> None:
    system = copying(1, 100, "any")
    assert not holds(system, "G ((data.reader.copy.heard.Load >= 1) -> F fired(data.reader.copy.heard.out))")
