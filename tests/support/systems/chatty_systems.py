"""A Hypothesis strategy for systems whose small queues overflow: many messages, little room, answers back."""

from __future__ import annotations

from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import flow


@st.composite
def chatty_systems(draw: st.DrawFn) -> sym.SystemModel:
    """Return a system of two or three nodes that publish to each other through very short queues."""
    model = sym.SystemModel(id="chatty")
    count = draw(st.integers(2, 3))
    nets = [sym.NodeNet(id=f"n{number}", net=model) for number in range(count)]
    limits = st.integers(1, 2)
    for number in range(draw(st.integers(1, 2))):
        channel = sym.TopicChannel(id=f"t{number}", topic=f"/t{number}", model=model)
        publishers = draw(st.lists(st.integers(0, count - 1), min_size=1, max_size=2, unique=True))
        for publisher in publishers:
            net = nets[publisher]
            sent = sym.Place(id=f"sent{number}{publisher}", page=net)
            pool = sym.Place(id=f"pool{number}{publisher}", tokens=draw(st.integers(1, 3)), page=net)
            flow(pool, sym.Transition(id=f"say{number}{publisher}", page=net), sent)
            channel.publishers.append(sym.PublisherPort(place=sent, limit=draw(limits)))
        for subscriber in draw(st.lists(st.integers(0, count - 1), max_size=2)):
            net = nets[subscriber]
            port = len(channel.subscribers)
            heard = sym.Place(id=f"heard{number}{port}", page=net)
            # What is heard may be said again, on a topic that comes later: so nodes depend on each other.
            targets = [
                node
                for node in net.objects
                if isinstance(node, sym.Place) and node.id.startswith(f"pool{number + 1}")
            ]
            after = targets[0] if targets else sym.Place(id=f"noted{number}{port}", page=net)
            flow(heard, sym.Transition(id=f"hear{number}{port}", page=net), after)
            channel.subscribers.append(sym.SubscriberPort(place=heard, limit=draw(limits)))
            if all(dispatcher.node is not net for dispatcher in channel.dispatchers):
                channel.dispatchers.append(sym.Dispatcher(node=net, limit=draw(limits)))
    if len(model.channels) > 1:
        _connect(model)
    return model


def _connect(model: sym.SystemModel) -> None:
    """Let nodes say on the second topic what they have heard on the first, where they can."""
    first, second = model.channels[0], model.channels[1]
    assert isinstance(first, sym.TopicChannel)
    assert isinstance(second, sym.TopicChannel)
    for port in first.subscribers:
        net = port.place.page
        for publisher in second.publishers:
            if publisher.place.page is net:
                again = sym.Transition(id=f"repeat{port.place.id}{publisher.place.id}", page=net)
                flow(port.place, again, publisher.place)
