"""Rules of time: what they make of small systems is what an independent program counted of these."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.timed.exploring import Explored, explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import flow, seconds
from dineros.metamodel.calls import UNLIMITED
from dineros.metamodel.elements import channels, find, transitions
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.times.given import says_times
from dineros.metamodel.times.rates import on_the_way
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.queries.message_times import CallsOnTheWay, OnTheWay
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

pytestmark = pytest.mark.usefixtures("own_time")


def explored(model: sym.SystemModel) -> Explored:
    found = explore_timed(timed_base_subject(model).timed, Budget(seconds=120))
    assert found.is_complete, found.reason
    return found


def fired(found: Explored, suffix: str) -> set[str]:
    names = found.net.untimed.transitions
    return {names[t].split(".")[-2] for t in found.ways if names[t].endswith(suffix)}


@pytest.mark.long
@pytest.mark.parametrize("number", COUNTED)
def test_counted_systems_have_the_facts(number: int) -> None:
    counted = COUNTED[number]
    found = explored(model_of(counted.system, 0.01))
    places, names = found.net.untimed.places, found.net.untimed.transitions
    top = dict(zip(places, found.markings.max(axis=0).tolist(), strict=True))
    longest = {
        name.split(".")[-3]: most
        for name, most in top.items()
        if ".reader." in name and name.endswith(".heard.Load")
    }
    drops = {names[t] for t in found.ways if ".reader." in names[t] and names[t].endswith(".drop")}
    assert longest == counted.longest
    assert {name.split(".")[-3] for name in drops} == set(counted.lost)
    assert fired(found, ".miss") == set(counted.missed)


def test_times_are_used_only_if_the_model_says_any() -> None:
    model = model_of(COUNTED[1].system)
    for each in model.channels:
        each.latency = None
    pages = [find(model, name, sym.CallbackPage) for name in ("tick", "log")]
    for page in pages:
        page.duration = page.offset = None
    assert not says_times(model)
    assert not timed_base_subject(model).timed.has_times
    pages[1].duration = seconds(0.002, None)
    assert not says_times(model), "nothing would ever have to happen"
    pages[1].duration = seconds(0.002, 0.005)
    assert says_times(model)
    assert timed_base_subject(model).timed.has_times


def test_without_times_nothing_has_an_interval() -> None:
    net = flatten(model_of(COUNTED[1].system), "none").net
    assert all(each.interval is None for each in transitions(net))


@pytest.mark.parametrize(("number", "most"), [(1, 4), (5, 3), (6, 4)])
def test_so_many_messages_can_be_on_their_way(number: int, most: int) -> None:
    """Figures 5 and 6 have two and three at once; the bound may be higher, not lower."""
    (channel,) = channels(model_of(COUNTED[number].system), sym.TopicChannel)
    found = on_the_way(channel.publishers[0], channel.subscribers[0])
    assert {1: 1, 5: 2, 6: 3}[number] <= found <= most + 1


@pytest.mark.long
def test_a_service_without_a_latency_may_take_any_time() -> None:
    """With its latency, the timer that calls it loses no tick; without, a response may come too late."""
    model = model_of(COUNTED[15].system, 0.01)
    assert fired(explored(model), ".miss") == set()
    (service,) = channels(model, sym.ServiceChannel)
    service.latency = None
    assert fired(explored(model), ".miss") == {"ask"}


def test_too_many_messages_on_their_way_are_refused() -> None:
    model = model_of(COUNTED[1].system)
    model.channels[0].latency = seconds(0, 5000)
    with pytest.raises(DinerosError, match="on their way at once"):
        flatten(model, "none", times=True)


def test_jitter_does_not_shift_later_strikes() -> None:
    """A timer whose callback takes its whole period never loses a tick, unless one is late by a period."""
    model = model_of(COUNTED[3].system)
    tick = find(model, "tick", sym.CallbackPage)
    tick.duration, tick.jitter = seconds(5, 5), 4.0
    assert fired(explored(model), ".miss") == set()
    tick.jitter = 5.0
    assert fired(explored(model), ".miss") == {"tick"}


def burst(limit: int) -> sym.SystemModel:
    """Return a node net that can send six messages at any moment, to a reader that keeps four."""
    pool, send, out = sym.Place(id="Pool", tokens=6), sym.Transition(id="Send"), sym.Place(id="Out")
    talker = sym.NodeNet(id="talker", objects=[pool, send, out])
    flow(pool, send, out)
    heard, work, done = sym.Place(id="Heard"), sym.Transition(id="Work"), sym.Place(id="Done", kind="end")
    page = sym.CallbackPage(id="OnMessage", kind="subscriber", objects=[heard, work, done])
    page.duration = seconds(0, 0.02)
    flow(heard, work, done)
    channel = sym.TopicChannel(id="T", topic="/t", latency=seconds(0.1, 0.1))
    channel.publishers.append(sym.PublisherPort(place=out, limit=limit))
    channel.subscribers.append(sym.SubscriberPort(place=heard, limit=4))
    log = sym.NodeNet(id="log", execution="callbacks", objects=[page])
    return sym.SystemModel(id="burst", middleware="ros2", pages=[talker, log], channels=[channel])


@pytest.mark.parametrize("limit", [1, 3, 8])
def test_a_burst_overflows_the_reader_however_few_the_publisher_keeps(limit: int) -> None:
    """Nothing bounds what is on its way, so no message may wait for another one's clock."""
    found = explored(burst(limit))
    names = found.net.untimed.transitions
    assert "T.reader.Heard.drop" in {names[t] for t in found.ways}


def test_a_client_without_a_bound_has_no_clocks() -> None:
    client = sym.ClientPort(client="office", latency=seconds(0.1, 0.2), outstanding=2)
    assert CallsOnTheWay._answer(client) == 2
    client.outstanding = UNLIMITED
    assert CallsOnTheWay._answer(client) == 0


@pytest.mark.long
@pytest.mark.parametrize("number", [number for number in COUNTED if COUNTED[number].system["latency"]])
def test_more_clocks_change_nothing(number: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """The bound on messages on their way is large enough: with two more clocks, the facts are the same."""

    def facts() -> tuple[dict[str, int], set[str], set[str]]:
        found = explored(model_of(COUNTED[number].system, 0.01))
        places, names = found.net.untimed.places, found.net.untimed.transitions
        top = dict(zip(places, found.markings.max(axis=0).tolist(), strict=True))
        longest = {name: most for name, most in top.items() if name.endswith(".Load")}
        return longest, {names[t] for t in found.ways if names[t].endswith(".drop")}, fired(found, ".miss")

    few = facts()
    monkeypatch.setattr(
        OnTheWay, "_answer", staticmethod(lambda *ends: found + 2 if (found := on_the_way(*ends)) else 0)
    )
    assert facts() == few
