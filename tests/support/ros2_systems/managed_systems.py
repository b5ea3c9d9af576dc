"""Small systems of ROS 2 with managed nodes."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow


def talk(
    writer: sym.Lifecycle | None = None,
    reader: sym.Lifecycle | None = None,
    *,
    tokens: int = 2,
    depth: int = 2,
    late: bool = False,
    reliability: str = "reliable",
) -> sym.SystemModel:
    """Return a talker who says a number of things, and a listener.

    Parameters
    ----------
    writer, reader : sym.Lifecycle or None
        The lives of both.
    tokens, depth : int
        How much is said, and how much is kept at both ends.
    late : bool
        Whether the topic is transient-local.
    reliability : {"reliable", "bestEffort"}
        Of the topic.
    """
    model = sym.SystemModel(id="talk", middleware="ros2")
    talker = sym.NodeNet(id="talker", net=model, lifecycle=writer)
    listener = sym.NodeNet(id="listener", net=model, lifecycle=reader)
    words, said = sym.Place(id="Words", tokens=tokens, page=talker), sym.Place(id="Said", page=talker)
    flow(words, sym.Transition(id="Say", page=talker), said)
    heard = sym.Place(id="Heard", page=listener)
    flow(heard, sym.Transition(id="Hear", page=listener))
    quality = sym.QualityOfService(
        durability="transientLocal" if late else "volatile", reliability=reliability
    )
    topic = sym.TopicChannel(id="Talk", topic="/talk", model=model, qos=quality)
    topic.publishers.append(sym.PublisherPort(place=said, limit=depth))
    topic.subscribers.append(sym.SubscriberPort(place=heard, limit=depth))
    return model


def camera() -> sym.SystemModel:
    """Return a camera whose images go to a detector, whose boxes go to a display: all are managed."""
    model = sym.SystemModel(id="cameras", middleware="ros2")
    shooting = sym.NodeNet(id="camera", net=model, lifecycle=sym.Lifecycle(pauses=True, deactivates=True))
    detecting = sym.NodeNet(id="detector", net=model, lifecycle=sym.Lifecycle())
    drawing = sym.NodeNet(id="display", net=model, lifecycle=sym.Lifecycle(cleansUp=True))
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=0.5, page=shooting)
    image = sym.Place(id="Image", page=page)
    flow(sym.Transition(id="Shoot", page=page), image)
    seen, box = sym.Place(id="Seen", page=detecting), sym.Place(id="Box", page=detecting)
    flow(seen, sym.Transition(id="Detect", page=detecting), box)
    shown = sym.Place(id="Shown", page=drawing)
    flow(shown, sym.Transition(id="Draw", page=drawing))
    for name, sent, got in (("Images", image, seen), ("Boxes", box, shown)):
        topic = sym.TopicChannel(id=name, topic=f"/{name.lower()}", model=model)
        topic.publishers.append(sym.PublisherPort(place=sent, limit=1))
        topic.subscribers.append(sym.SubscriberPort(place=got, limit=1))
    return model
