"""Long handlers: the transition is in flight, its tokens are reserved, everything else continues."""

from __future__ import annotations

import asyncio
import threading
import time

import pytest

from dineros.runtime import Aside, Firing, Net, Node, Retry
from tests.runtime.tiny import counts, events, settle, stepped, tiny

SECONDS = 20.0


def step_until(node: Node, condition: object) -> None:
    assert callable(condition)
    end = time.monotonic() + SECONDS
    while not condition():
        assert time.monotonic() < end
        if not node.step():
            node.wait(0.01)


def test_the_rest_of_the_node_goes_on() -> None:
    net = Net(tiny({"long": "a -> b", "quick": "c -> d", "rival": "a -> e"}, {"a": 1, "c": 3}))
    gate = threading.Event()

    @net.handler("long", thread=True)
    def long(firing: Firing) -> None:
        gate.wait(SECONDS)

    net.selection(lambda enabled: enabled.named("long") or enabled[0])
    with stepped(net) as (node, _):
        node.run_until_idle()
        state = net.inspect()
        assert counts(net) == {"a": 1, "b": 0, "c": 0, "d": 3, "e": 0}  # reserved, not gone
        (flight,) = state.in_flight
        assert (flight.transition, flight.handler, dict(flight.tokens)) == ("long", "long", {"a": (1,)})
        assert set(state.enabled) == {"long", "rival"}  # as far as the net goes
        gate.set()
        settle(node)
        assert counts(net) == {"a": 0, "b": 1, "c": 0, "d": 3, "e": 0}
        assert net.inspect().in_flight == ()


class _Gauge:
    """Counts how many run at a time."""

    def __init__(self) -> None:
        self.running = self.most = 0
        self.lock = threading.Lock()

    def __enter__(self) -> None:
        with self.lock:
            self.running += 1
            self.most = max(self.most, self.running)

    def __exit__(self, *exception: object) -> None:
        with self.lock:
            self.running -= 1


@pytest.mark.parametrize("parallel", [1, 2])
@pytest.mark.parametrize("kind", ["async", "thread"])
def test_one_in_flight_per_transition_unless_told_otherwise(kind: str, parallel: int) -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 3}))
    gauge = _Gauge()

    async def asynchronous(firing: Firing) -> None:
        with gauge:
            await asyncio.sleep(0.2)

    def threaded(firing: Firing) -> None:
        with gauge:
            time.sleep(0.2)

    if kind == "async":
        net.handler("go", parallel=parallel)(asynchronous)
    else:
        net.handler("go", parallel=parallel, thread=True)(threaded)
    with stepped(net) as (node, _):
        settle(node)
        assert counts(net) == {"a": 0, "b": 3}
        assert gauge.most == parallel


def test_inhibitor_and_read_arcs_see_reserved_tokens() -> None:
    net = Net(
        tiny({"long": "a -> b", "blocked": "c !a -> d", "reader": "e ?a -> f"}, {"a": 1, "c": 1, "e": 1})
    )
    gate = threading.Event()
    net.handler("long", thread=True)(lambda firing: gate.wait(SECONDS) and None)
    net.selection(lambda enabled: enabled.named("long") or enabled[0])
    with stepped(net) as (node, _):
        node.run_until_idle()
        assert counts(net) == {"a": 1, "b": 0, "c": 1, "d": 0, "e": 0, "f": 1}
        gate.set()
        settle(node)
        assert counts(net) == {"a": 0, "b": 1, "c": 0, "d": 1, "e": 0, "f": 1}


@pytest.mark.parametrize("obstacle", ["clause", "inhibitor", "read"])
def test_a_firing_that_is_not_allowed_any_more_is_withdrawn_and_tried_again(obstacle: str) -> None:
    arcs = {"clause": "a -> b", "inhibitor": "a !stop -> b", "read": "a ?safe -> b"}[obstacle]
    model = tiny(
        {"go": arcs, "alarm": "safe -> stop", "clear": "stop -> safe"},
        {"a": 1, "safe": 1},
        signals="allowed danger",
        clauses={"alarm": "danger", "clear": "!danger"} | ({"go": "allowed"} if obstacle == "clause" else {}),
    )
    net = Net(model)
    gate, started = threading.Event(), threading.Event()
    calls: list[Firing] = []

    @net.handler("go", thread=True)
    def go(firing: Firing) -> None:
        started.set()
        calls.append(firing)
        gate.wait(SECONDS)

    net.signal("allowed").set(True)
    with stepped(net) as (node, recorder):
        step_until(node, started.is_set)
        assert [firing.still_enabled for firing in calls] == [True]
        net.signal("allowed").set(False)
        net.signal("danger").set(True)
        node.run_until_idle()
        assert [firing.still_enabled for firing in calls] == [False]
        gate.set()
        step_until(node, lambda: not net.inspect().in_flight)
        assert (counts(net)["a"], counts(net)["b"]) == (1, 0)
        (error,) = events(recorder, "error")
        assert (error["error"], error["transition"], error["policy"]) == ("withdrawn", "go", "retry")
        assert net.inspect().halted is None
        net.signal("allowed").set(True)
        net.signal("danger").set(False)
        settle(node)
        assert (counts(net)["a"], counts(net)["b"], len(calls)) == (0, 1, 2)


def test_a_failed_long_handler_only_releases_the_reservation() -> None:
    net = Net(tiny({"go": "a -> b", "rival": "a -> c"}, {"a": 1}), policy=Aside())

    @net.handler("go")
    async def fail(firing: Firing) -> None:
        await asyncio.sleep(0.01)
        raise ValueError("no grip")

    net.selection(lambda enabled: enabled.named("go") or enabled[0])
    with stepped(net) as (node, recorder):
        settle(node)
        assert counts(net) == {"a": 0, "b": 0, "c": 1}
        assert events(recorder, "error")[0]["error"] == "ValueError: no grip"


@pytest.mark.parametrize("kind", ["async", "thread", "plain"])
def test_a_handler_that_takes_too_long_has_failed(kind: str) -> None:
    net = Net(tiny({"go": "a -> b", "other": "c -> d"}, {"a": 1, "c": 1}), policy=Aside())
    cancelled = threading.Event()
    gate = threading.Event()

    async def asynchronous(firing: Firing) -> None:
        try:
            await asyncio.sleep(SECONDS)
        except asyncio.CancelledError:
            cancelled.set()
            raise

    def hanging(firing: Firing) -> None:
        gate.wait(SECONDS)

    if kind == "async":
        net.handler("go", timeout=0.05)(asynchronous)
    else:
        net.handler("go", timeout=0.05, thread=kind == "thread")(hanging)
    with stepped(net) as (node, recorder):
        settle(node)
        assert counts(net) == {"a": 1, "b": 0, "c": 0, "d": 1}
        assert events(recorder, "error")[0]["error"] == "took longer than 0.05 s"
        gate.set()  # what the thread returns now counts no more
        if kind == "async":
            assert cancelled.wait(SECONDS)
        time.sleep(0.02)
        node.run_until_idle()
        assert counts(net)["b"] == 0


def test_plain_and_long_handlers_follow_each_other() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}))
    order: list[tuple[str, bool]] = []
    main = threading.current_thread()

    def note(name: str) -> None:
        order.append((name, threading.current_thread() is main))

    @net.handler("go", priority=4)
    def first(firing: Firing) -> None:
        note("first")

    @net.handler("go", priority=3)
    async def second(firing: Firing) -> dict[str, object]:
        note("second")
        return {"count": 2}

    @net.handler("go", priority=2, thread=True)
    def third(firing: Firing) -> dict[str, object]:
        note("third")
        return {"count": firing.data["count"] * 10}

    @net.handler("go", priority=1)
    def fourth(firing: Firing) -> None:
        note("fourth")
        firing.data["count"] += 1

    with stepped(net) as (node, recorder):
        settle(node)
        assert order == [("first", True), ("second", False), ("third", False), ("fourth", True)]
        assert net.inspect().marking["b"][0].data["count"] == 21
        assert events(recorder, "fire")[0]["handlers"] == ["first", "second", "third", "fourth"]


def test_closing_cancels_what_is_in_flight() -> None:
    before = set(threading.enumerate())
    net = Net(tiny({"go": "a -> b"}, {"a": 1}))
    started, cancelled = threading.Event(), threading.Event()

    @net.handler("go")
    async def endless(firing: Firing) -> None:
        try:
            started.set()
            await asyncio.Event().wait()
        finally:
            cancelled.set()

    with stepped(net) as (node, _):
        step_until(node, started.is_set)
    assert cancelled.wait(SECONDS)
    assert counts(net) == {"a": 1, "b": 0}
    assert set(threading.enumerate()) <= before


@pytest.mark.parametrize("kind", ["thread", "plain", "async"])
def test_a_retry_waits_for_the_end_of_a_handler_that_took_too_long(kind: str) -> None:
    """One motion at a time: a thread cannot be stopped, and a coroutine may have to tidy up."""
    net = Net(tiny({"move": "a -> b"}, {"a": 1}), policy=Retry(attempts=3, delay=0.01, then=Aside()))
    gauge, runs = _Gauge(), []

    def moving(firing: Firing) -> dict[str, object]:
        runs.append(firing)
        with gauge:
            time.sleep(0.4)
        return {"count": 7}

    async def tidying(firing: Firing) -> None:
        runs.append(firing)
        with gauge:
            try:
                await asyncio.sleep(SECONDS)
            finally:
                await asyncio.sleep(0.4)

    handler = tidying if kind == "async" else moving
    net.handler("move", timeout=0.05, thread=kind == "thread")(handler)
    with stepped(net) as (node, recorder):
        step_until(node, lambda: net.inspect().outliving)
        (late,) = net.inspect().outliving
        assert (late.transition, dict(late.tokens), net.inspect().in_flight) == ("move", {}, ())
        step_until(node, lambda: net.inspect().aside and not net.inspect().outliving)
        assert (gauge.most, len(runs)) == (1, 3)
        assert [error["error"] for error in events(recorder, "error")] == ["took longer than 0.05 s"] * 3
        assert counts(net) == {"a": 1, "b": 0}  # what came too late does not count


def test_a_halted_node_that_proceeds_waits_for_the_end_too() -> None:
    net = Net(tiny({"move": "a -> b", "other": "c -> d"}, {"a": 1, "c": 1}))
    gate, runs = threading.Event(), []

    @net.handler("move", thread=True, timeout=0.05)
    def move(firing: Firing) -> None:
        runs.append(firing)
        gate.wait(SECONDS)

    net.selection(lambda enabled: enabled.named("move") or enabled[0])
    with stepped(net) as (node, _):
        step_until(node, lambda: net.status.state == "halted")
        net.proceed()
        node.run_until_idle()
        assert (counts(net)["d"], len(runs)) == (1, 1)  # the rest continues
        gate.set()
        step_until(node, lambda: len(runs) == 2)


def test_firings_in_flight_can_be_released_by_hand() -> None:
    net = Net(tiny({"move": "a -> b", "rival": "a -> c"}, {"a": 1}))
    gate = threading.Event()
    net.handler("move", thread=True)(lambda firing: gate.wait(SECONDS) and None)
    net.selection(lambda enabled: enabled.named("move") or enabled[0])
    with stepped(net) as (node, recorder):
        step_until(node, lambda: net.inspect().in_flight)
        assert net.give_up() == ["move"]
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 0, "c": 1}
        (error,) = events(recorder, "error")
        assert (error["transition"], error["error"], error["policy"]) == ("move", "released by hand", None)
        gate.set()
        settle(node)
        assert counts(net)["b"] == 0
