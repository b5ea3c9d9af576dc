"""Models with every element that the rules of ROS 2 look at, and token types; whole, or broken somewhere."""

from __future__ import annotations

from collections.abc import Iterable

from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import goal_parts
from dineros.metamodel.elements import places, transitions
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models
from tests.support.vandalism import vandalise

VALUES: list[object] = [None, "", " ", "x y", "../up", "\u2028", "Ä", "class", "{", "a" * 300]
VALUES += [-1, 0, 1, 2, 40, 2**31 - 1, 2**70, -0.5, 1e-9, 1e300, float("nan"), float("inf"), True, False]


@st.composite
def whole_models(draw: st.DrawFn) -> sym.SystemModel:
    """Return a valid model, most of them with several token types."""
    model = draw(
        st.one_of(history_models(), executor_models(), executor_models(), action_models(), lifecycle_models())
    )
    if draw(st.integers(0, 3)):
        _give_types(draw, model)
    if draw(st.integers(0, 3)):
        for transition in transitions(model):
            transition.overrides.clear()  # priorities are not analysed
    for channel in model.channels:
        for client in channel.clients if isinstance(channel, sym.ServiceChannel) else ():
            if client.timeout is not None:
                client.timeout = draw(st.sampled_from([0.001, 0.003, 0.02, 0.5]))
    if draw(st.integers(0, 9)) == 0:
        model.middleware = "ros1"  # which then meets what only ROS 2 knows
    return model


@st.composite
def broken_models(draw: st.DrawFn) -> sym.SystemModel:
    """Return a model with one to three things set to bad values, dropped or moved."""
    model = draw(whole_models())
    for _ in range(draw(st.integers(1, 3))):
        vandalise(draw, model, VALUES)
    return model


def _give_types(draw: st.DrawFn, model: sym.SystemModel) -> None:
    """Give the model token types, and places that a channel joins the same one."""
    model.tokenType = own = sym.TokenType(id="Order")
    own.fields.append(sym.TokenField(name="article", ros="string<=20", default='"nut"'))
    own.fields.append(sym.TokenField(name="count", kind="integer", ros="uint8"))
    note = sym.TokenType(id="Note")
    note.fields.append(sym.TokenField(name="tags", kind="list", bound=2))
    note.fields.append(sym.TokenField(name="of", kind="map", elementKind="number"))
    installed = sym.TokenType(id="Text", ros="std_msgs/msg/String")
    model.otherTokenTypes.extend([note, installed])
    group = {place: {place} for place in places(model)}
    for joined in _joined(model):
        every = set[pn.Place]().union(*(group[place] for place in joined))
        group.update(dict.fromkeys(every, every))
    types: list[sym.TokenType | None] = [None, None, own, note, installed]
    done: set[pn.Place] = set()
    for place in places(model):
        if place not in done:
            done |= group[place]
            chosen = draw(st.sampled_from(types))
            for each in group[place]:
                if isinstance(each, sym.Place):
                    each.tokenType = chosen
    for channel in model.channels:
        if draw(st.integers(0, 2)) == 0:
            _map(channel)
    data = {None: '{"count": 3}', own: '{"article": "bolt"}', note: '{"tags": ["a"]}', installed: "{}"}
    for place in places(model):
        if isinstance(place, sym.Place) and place.tokens and draw(st.booleans()):
            place.balloons.append(sym.BalloonToken(data=data[place.tokenType]))


def _map(channel: sym.Channel) -> None:
    """Let a topic or a service of the first token type carry existing messages of ROS."""
    used = {getattr(place, "tokenType", None) for places in _joined_by(channel) for place in places}
    if {each.id if each else "Order" for each in used} != {"Order"}:
        return
    if isinstance(channel, sym.TopicChannel):
        channel.type = "std_msgs/msg/String"
        channel.mappings.append(sym.FieldMapping(messageField="data", tokenField="article"))
    elif isinstance(channel, sym.ServiceChannel):
        channel.type = "std_srvs/srv/Trigger"
        carried = sym.FieldMapping(part="response", messageField="message", tokenField="article")
        channel.mappings.append(carried)


def _joined(model: sym.SystemModel) -> Iterable[list[pn.Place]]:
    """Yield places whose tokens are of one type."""
    for channel in model.channels:
        yield from _joined_by(channel)


def _joined_by(channel: sym.Channel) -> Iterable[list[pn.Place]]:
    if isinstance(channel, sym.TopicChannel):
        yield [port.place for port in (*channel.publishers, *channel.subscribers)]
    elif isinstance(channel, sym.ServiceChannel):
        yield [channel.server.entry, *(client.request for client in channel.clients)]
        answered = [client.response for client in channel.clients]
        yield [channel.server.exit, *answered, *(c.timedOut for c in channel.clients if c.timedOut)]
    elif isinstance(channel, sym.ActionChannel):
        yield from goal_parts(channel).values()
