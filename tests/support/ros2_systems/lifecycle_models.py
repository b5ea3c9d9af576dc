"""A Hypothesis strategy for models of ROS 2 with managed nodes beside all the rest."""

from __future__ import annotations

from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.elements import node_nets
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models


@st.composite
def lifecycle_models(draw: st.DrawFn) -> sym.SystemModel:
    """Return a small system some of whose nodes are managed, and some of whose topics keep messages."""
    model = draw(st.one_of(history_models(), executor_models(), action_models()))
    nets = node_nets(model)
    for net in draw(st.lists(st.sampled_from(nets), min_size=1, max_size=3, unique=True)):
        net.lifecycle = draw(lifecycles())
    for channel in model.channels:
        if isinstance(channel, sym.TopicChannel) and draw(st.booleans()):
            channel.qos = sym.QualityOfService(durability="transientLocal")
            for port in (*channel.publishers, *channel.subscribers):
                port.limit = draw(st.integers(1, 2))
                if draw(st.integers(0, 3)):
                    port.qos = None
    for channel in model.channels:
        for client in channel.clients if isinstance(channel, sym.ServiceChannel) else ():
            client.waitsForService = draw(st.booleans())
    return model


@st.composite
def lifecycles(draw: st.DrawFn) -> sym.Lifecycle:
    """Return the life of a managed node."""
    often = st.sampled_from([False, True, True])
    configured, activated = draw(st.integers(0, 3)), draw(st.integers(0, 4))
    return sym.Lifecycle(
        deactivates=draw(often),
        cleansUp=draw(often),
        shutsDown=draw(st.booleans()),
        configureFails=draw(st.booleans()),
        activateFails=draw(st.booleans()),
        pauses=draw(st.booleans()),
        configureStep=configured,
        activateStep=0 if activated <= configured else activated,
    )
