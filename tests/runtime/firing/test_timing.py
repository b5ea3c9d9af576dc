"""Firing intervals and timer callbacks delay firings and change nothing else."""

from __future__ import annotations

import pytest

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.runtime import Net, Node
from dineros.runtime.channels.local import LocalNetwork, LocalTransport
from dineros.runtime.channels.transport import Receiver
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.ports import Ports, TimerPort
from tests.runtime.tiny import counts, events, stepped, tiny


class Clock:
    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        return self.now


def times(net: Net, clock: Clock, seconds: float, step: float = 0.1) -> list[tuple[object, float]]:
    """Run for some seconds; return what fired when."""
    found: list[tuple[object, float]] = []
    with stepped(net) as (node, recorder):
        end = clock.now + seconds
        while clock.now < end:
            node.run_until_idle()
            found += [(each["transition"], round(clock.now, 3)) for each in _new(recorder, len(found))]
            clock.now += step
    return found


def _new(recorder: ListRecorder, known: int) -> list[dict[str, object]]:
    return events(recorder, "fire")[known:]


def test_a_transition_waits_for_its_earliest_time_each_time() -> None:
    model, clock = tiny({"go": "a -> b"}, {"a": 3}), Clock()
    find(model, "go", pn.Transition).interval = pn.TimeInterval(earliest=1.0)
    fired = times(Net(model, clock=clock), clock, 10)
    assert [time for _, time in fired] == [pytest.approx(n, abs=0.11 * n) for n in (1.0, 2.0, 3.0)]


def test_a_break_starts_the_time_anew() -> None:
    model, clock = tiny({"go": "a -> b"}, {"a": 1}, signals="s", clauses={"go": "s"}), Clock()
    find(model, "go", pn.Transition).interval = pn.TimeInterval(earliest=1.0)
    net = Net(model, clock=clock)
    with stepped(net) as (node, _):
        for now, value in ((0.0, True), (0.6, False), (0.7, True), (1.5, True)):
            clock.now = now
            net.signal("s").set(value)
            node.run_until_idle()
        assert counts(net) == {"a": 1, "b": 0}
        clock.now = 1.75
        node.run_until_idle()
        assert counts(net) == {"a": 0, "b": 1}


def test_a_transition_past_its_latest_time_goes_first() -> None:
    model, clock = tiny({"go": "a -> b", "spin": "c -> c"}, {"a": 1, "c": 1}), Clock()
    find(model, "go", pn.Transition).interval = pn.TimeInterval(earliest=1.0, latest=1.0)
    net = Net(model, clock=clock, seed=1)
    with stepped(net) as (node, recorder):
        for _ in range(5):
            node.step()
        clock.now = 1.0
        node.step()
        assert events(recorder, "fire")[-1]["transition"] == "go"


@pytest.mark.parametrize("selected", [False, True])
def test_a_timer_callback_fires_once_in_each_period(selected: bool) -> None:
    node = sym.NodeNet(id="node", name="node")
    model = rtm.RuntimeModel(id="m.node", systemModel="m", pages=[node], node=node)
    page, clock = sym.CallbackPage(id="page", kind="timer", timer=0.5, page=node), Clock()
    pool = rtm.Place(id="pool", tokens=9, page=page)
    flow(pool, sym.Transition(id="tick", page=page), rtm.Place(id="done", page=page))
    net = Net(model, clock=clock)
    if selected:
        net.selection(lambda enabled: enabled[0])
    fired = times(net, clock, 2.3)
    assert [time for _, time in fired] == [pytest.approx(n, abs=0.45) for n in (0.5, 1.0, 1.5, 2.0)]
    assert len(fired) == 4


def test_late_ticks_delay_no_others_and_missed_ones_do_not_pile_up() -> None:
    model, clock = tiny({"beat": "-> beats"}), Clock()
    page = sym.CallbackPage(id="page", kind="timer", timer=1.0, page=model.node)
    page.objects.append(find(model, "beat", pn.Transition))
    net, found = Net(model, clock=clock), []
    with stepped(net) as (node, _):
        for now in (0.0, 1.4, 1.9, 2.1, 5.7, 5.9, 6.0, 6.5):
            clock.now = now
            node.run_until_idle()
            found.append(net.count("beats"))
    assert found == [0, 1, 1, 2, 3, 3, 4, 4]


class TickingTransport(LocalTransport):
    """Has timers of its own, which tick when the test says so."""

    receiver: Receiver
    timer: TimerPort
    has_timers = True
    is_ticking = False

    def open(self, ports: Ports, receiver: Receiver) -> None:
        super().open(ports, receiver)
        self.receiver, (self.timer,) = receiver, ports.timers

    def start_timers(self) -> None:
        self.is_ticking = True


def test_a_transport_that_has_timers_ticks_alone() -> None:
    """The clock of the loop then says nothing, and ticks that come before the callback has begun are gone."""
    model, clock = tiny({"beat": "full -> beats"}, {"full": 3}), Clock()
    page = sym.CallbackPage(id="page", kind="timer", timer=1.0, page=model.node)
    page.objects.append(find(model, "beat", pn.Transition))
    transport, net = TickingTransport(LocalNetwork(seed=1)), Net(model, clock=clock)
    node = Node(net, transport)
    node.open()
    assert transport.is_ticking
    assert (transport.timer.callback, transport.timer.period) == ("page", 1.0)
    node.run_until_idle()
    clock.now = 10.0
    node.run_until_idle()
    assert net.next_timer is None
    found = [net.count("beats")]
    for ticks in (1, 0, 3, 1):
        for _ in range(ticks):
            transport.receiver.ticked(transport.timer)
        node.run_until_idle()
        found.append(net.count("beats"))
    assert found == [0, 1, 1, 2, 3]
    node.close()


def test_a_timer_callback_begins_once_in_each_period_and_goes_on_at_once() -> None:
    """By one of two transitions; what comes after waits for no tick, and no tick is kept for later."""
    node = sym.NodeNet(id="node", name="node")
    model = rtm.RuntimeModel(id="m.node", systemModel="m", pages=[node], node=node)
    page, clock = sym.CallbackPage(id="page", kind="timer", timer=0.5, page=node), Clock()
    pool = rtm.Place(id="pool", tokens=3, page=page)
    between, finish = rtm.Place(id="between", page=page), sym.Transition(id="finish", page=page)
    for name in ("this", "that"):
        flow(pool, sym.Transition(id=name, page=page), between)
    flow(between, finish)
    net = Net(model, clock=clock)
    fired = times(net, clock, 2.3)
    begins = [time for name, time in fired if name != "finish"]
    assert begins == [pytest.approx(n, abs=0.45) for n in (0.5, 1.0, 1.5)]
    assert [time for name, time in fired if name == "finish"] == begins
