"""Hypothesis strategies for models of ROS 2: depths, quality of service, capacities, messages in hand."""

from __future__ import annotations

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.small_systems import small_system_models


@st.composite
def history_models(
    draw: st.DrawFn, systems: st.SearchStrategy[sym.SystemModel] | None = None
) -> sym.SystemModel:
    """Return a small system of topics and services, with every feature that the rules of ROS 2 look at."""
    usual = st.one_of(small_system_models(clients=0), calling_systems(circles=True, services=2))
    model = draw(usual if systems is None else systems)
    model.middleware = "ros2"
    bounded = draw(st.booleans())
    declared: set[pn.Place] = set()
    for place in _places(model):
        if bounded and draw(st.integers(0, 3)) == 0:
            place.capacity = max(1, place.tokens) + draw(st.integers(0, 1))
            declared.add(place)
    for channel in model.channels:
        if isinstance(channel, sym.ServiceChannel):
            _ask(draw, channel)
        if not isinstance(channel, sym.TopicChannel):
            continue
        channel.qos = draw(qualities())
        for publisher in channel.publishers:
            publisher.qos = draw(qualities())
        for subscriber in channel.subscribers:
            subscriber.qos = draw(qualities())
            least = max(1, subscriber.place.tokens)
            if subscriber.place not in declared:
                subscriber.inHand = draw(st.sampled_from([None, None, least, least + 1, -1]))
    return model


def qualities() -> st.SearchStrategy[sym.QualityOfService | None]:
    """Return none, or some quality of service; most match each other."""
    some = st.builds(
        sym.QualityOfService,
        reliability=st.sampled_from(["reliable", "reliable", "bestEffort"]),
        durability=st.sampled_from(["volatile", "volatile", "volatile", "transientLocal"]),
        deadline=st.sampled_from([None, None, None, 0.1, 1.0]),
        lifespan=st.sampled_from([None, 5.0]),
        liveliness=st.sampled_from(["automatic", "automatic", "automatic", "manualByTopic"]),
        leaseDuration=st.sampled_from([None, None, None, 2.0, 3.0]),
    )
    return st.one_of(st.none(), st.none(), some)


def _ask(draw: st.DrawFn, channel: sym.ServiceChannel) -> None:
    """Say how a service is asked: how many requests wait, how many a client sends, when it gives up."""
    channel.depth = draw(st.sampled_from([1, 1, 2, 10]))
    for client in channel.clients:
        client.outstanding = draw(st.sampled_from([None, 1, 1, 2, 3, -1]))
        client.timeout = draw(st.sampled_from([None, None, 0.5]))
        if client.timeout is not None:
            page, told = client.request.page, draw(st.sampled_from(["", "again", "answered", "told"]))
            assert page is not None
            if told == "told":
                client.timedOut = sym.Place(id=f"told.{client.client}", page=page)
                flow(client.timedOut, sym.Transition(id=f"goOn.{client.client}", page=page))
            elif told:
                client.timedOut = client.request if told == "again" else client.response


def _places(model: sym.SystemModel) -> list[pn.Place]:
    return [element for element in model.eAllContents() if isinstance(element, pn.Place)]
