"""A Hypothesis strategy for unbounded models: timers that publish forever, put into other random models."""

from __future__ import annotations

from collections.abc import Callable

from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import node_nets, transitions
from tests.support.systems.calling_systems import calling_systems
from tests.support.systems.chatty_systems import chatty_systems
from tests.support.systems.small_systems import small_system_models


@st.composite
def unbounded_systems(draw: st.DrawFn) -> sym.SystemModel:
    """Return a random model with one or two timers that publish forever."""
    model = draw(st.one_of(small_system_models(), chatty_systems(), calling_systems()))
    for transition in transitions(model):
        transition.overrides.clear()  # priorities are not analysed
    for number in range(draw(st.integers(1, 2))):
        _put_timer(draw, model, number)
    return model


def _put_timer(draw: st.DrawFn, model: sym.SystemModel, number: int) -> None:
    """Publish on a topic that is there, or on a new one that a node net subscribes to."""
    nets, limits = node_nets(model), st.integers(1, 3)
    said = add_timer(model, f"beat{number}")
    topics = [channel for channel in model.channels if isinstance(channel, sym.TopicChannel)]
    if draw(st.booleans()) and topics:
        topics[0].publishers.append(sym.PublisherPort(place=said, limit=draw(limits)))
        return
    topic = sym.TopicChannel(id=f"beats{number}", topic=f"/beats{number}", model=model)
    topic.publishers.append(sym.PublisherPort(place=said, limit=draw(limits)))
    listener = draw(st.sampled_from(nets))
    page = sym.CallbackPage(id=f"on_beat{number}", page=listener)
    heard, take = (
        sym.Place(id=f"beat_heard{number}", page=page),
        sym.Transition(id=f"take{number}", page=page),
    )
    flow(heard, take)
    match draw(st.sampled_from(["forget", "count", "use"])):
        case "count":
            flow(take, sym.Place(id=f"beats_counted{number}", page=page))
        case "use":
            own = [node for node in listener.objects if isinstance(node, sym.Place)]
            if own:
                used = draw(st.sampled_from(own))
                flow(take, pn.ReferencePlace(id=f"used{number}", target=used, page=page))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=draw(limits)))
    if draw(st.booleans()):
        topic.dispatchers.append(sym.Dispatcher(node=listener, limit=draw(limits)))


def add_timer(model: sym.SystemModel, name: str) -> sym.Place:
    """Add a node net that fires forever, and return the place that each firing puts a token on."""
    net = sym.NodeNet(id=name, net=model)
    clock = sym.Place(id=f"{name}_clock", tokens=1, page=net)
    said = sym.Place(id=f"{name}_said", page=net)
    tick = sym.Transition(id=f"{name}_tick", page=net)
    flow(clock, tick, clock)
    flow(tick, said)
    return said


def timer_and_logger(counter: bool = False, dispatcher: int | None = None) -> sym.SystemModel:
    """Return a timer that publishes forever (limit 3) to a logger that forgets, or counts (limit 2)."""
    model = sym.SystemModel(id="timer_and_logger")
    said = add_timer(model, "timer")
    logger = sym.NodeNet(id="logger", net=model)
    page = sym.CallbackPage(id="on_tick", page=logger)
    heard, log = sym.Place(id="heard", page=page), sym.Transition(id="log", page=page)
    flow(heard, log)
    if counter:
        flow(log, sym.Place(id="counted", page=page))
    topic = sym.TopicChannel(id="ticks", topic="/ticks", model=model)
    topic.publishers.append(sym.PublisherPort(place=said, limit=3))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=2))
    if dispatcher is not None:
        topic.dispatchers.append(sym.Dispatcher(node=logger, limit=dispatcher))
    return model


def each_of(count: int, examine: Callable[[sym.SystemModel], str]) -> None:
    """Examine so many models, always the same, and print what is said of each."""
    number = 0

    @settings(
        max_examples=count,
        deadline=None,
        derandomize=True,
        database=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @given(unbounded_systems())
    def one(model: sym.SystemModel) -> None:
        nonlocal number
        number += 1
        print(f"{number}: {examine(model)}", flush=True)

    one()
