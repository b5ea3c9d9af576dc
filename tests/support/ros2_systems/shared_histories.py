"""Systems whose subscribers have one history for the messages of several publishers, and lose many."""

from __future__ import annotations

from random import Random

from dineros.metamodel import sym
from dineros.metamodel.build import flow


def shared_histories(draw: Random) -> sym.SystemModel:
    """Return a topic with one to three talkers that have some things to say, and one or two loggers."""
    model = sym.SystemModel(id="shared", middleware="ros2")
    quality = sym.QualityOfService(reliability="bestEffort" if draw.random() < 0.2 else "reliable")
    topic = sym.TopicChannel(id="Talk", topic="/talk", model=model, qos=quality)
    for number in range(draw.randint(1, 3)):
        talker = sym.NodeNet(id=f"talker{number}", net=model)
        words = sym.Place(id=f"Words{number}", tokens=draw.randint(1, 6), page=talker)
        said = sym.Place(id=f"Said{number}", page=talker)
        flow(words, sym.Transition(id=f"Say{number}", page=talker), said)
        topic.publishers.append(sym.PublisherPort(place=said, limit=draw.randint(1, 3)))
    for number in range(draw.randint(1, 2)):
        logger = sym.NodeNet(id=f"logger{number}", net=model)
        heard = sym.Place(id=f"Heard{number}", page=logger)
        flow(heard, sym.Transition(id=f"Log{number}", page=logger))
        in_hand = draw.choice([None, 2, -1])
        topic.subscribers.append(sym.SubscriberPort(place=heard, limit=draw.randint(1, 3), inHand=in_hand))
    return model
