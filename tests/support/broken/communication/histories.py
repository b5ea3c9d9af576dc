"""Models that break the constraints of `histories`."""

from __future__ import annotations

from dineros.metamodel import sym
from dineros.metamodel.build import flow
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, plain

CASES = Cases()
HEARD = "subscriber port 'Heard' of topic channel 'chatter'"


@CASES.breaks(
    "capacity-positive",
    "place 'q' has the capacity 0",
    "give it a capacity of 1 or more, or none",
    of=plain,
)
def capacity_0(small: Small) -> None:
    small["q"].capacity = 0


@CASES.breaks(
    "capacity-holds-tokens",
    "place 'p' holds 3 tokens at the start, and its capacity is 2",
    "give it fewer tokens or more capacity",
    of=plain,
)
def more_tokens_than_capacity(small: Small) -> None:
    small["p"].tokens, small["p"].capacity = 3, 2


@CASES.breaks(
    "in-hand-positive",
    "subscriber port 'Heard' of topic channel 'chatter' has 0 messages in hand",
    "use 1 or more, or -1 for any number",
)
def nothing_in_hand(small: Small) -> None:
    small["chatter"].subscribers[0].inHand = 0


@CASES.breaks(
    "in-hand-or-capacity",
    "subscriber port 'Heard' of topic channel 'chatter' gives the number of messages in hand, "
    "and its place 'Heard' has a capacity",
    "give only one of the two",
)
def in_hand_twice(small: Small) -> None:
    small["chatter"].subscribers[0].inHand = -1
    small["Heard"].capacity = 4


@CASES.breaks(
    "in-hand-holds-tokens",
    "subscriber port 'Heard' of topic channel 'chatter' has 1 messages in hand, "
    "and its place holds 2 at the start",
    "give the place fewer tokens, or the port more in hand",
)
def more_at_the_start_than_in_hand(small: Small) -> None:
    small["Heard"].tokens = 2
    small["chatter"].subscribers[0].inHand = 1


@CASES.breaks(
    "quality-times-positive",
    "quality of service of publisher port 'Said' of topic channel 'chatter' has the lifespan -1.0",
    "use a time in seconds above 0, or none",
)
def negative_lifespan(small: Small) -> None:
    small["chatter"].publishers[0].qos = sym.QualityOfService(lifespan=-1.0)


def _differ(small: Small, name: str, offered: object, requested: object) -> None:
    (publisher,), (subscriber,) = small["chatter"].publishers, small["chatter"].subscribers
    publisher.qos = sym.QualityOfService(**{name: offered})  # type: ignore[arg-type]
    subscriber.qos = sym.QualityOfService(**{name: requested})  # type: ignore[arg-type]


_NOTHING = (
    "subscriber port 'Heard' of topic channel 'chatter' receives no message of "
    "publisher port 'Said' of topic channel 'chatter': the publisher's "
)


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}reliability is bestEffort, and the subscriber requests reliable",
    "chatter.publisher.Said.qos.reliability=reliable or chatter.subscriber.Heard.qos.reliability=bestEffort",
)
def best_effort_for_reliable(small: Small) -> None:
    _differ(small, "reliability", "bestEffort", "reliable")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}durability is volatile, and the subscriber requests transientLocal",
    "chatter.publisher.Said.qos.durability=transientLocal or "
    "chatter.subscriber.Heard.qos.durability=volatile",
)
def volatile_for_transient_local(small: Small) -> None:
    _differ(small, "durability", "volatile", "transientLocal")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}deadline is without bound, and the subscriber requests 0.5 s",
    "chatter.publisher.Said.qos.deadline=0.5 or chatter.subscriber.Heard.qos.deadline=",
)
def no_deadline_for_one(small: Small) -> None:
    _differ(small, "deadline", None, 0.5)


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}liveliness is automatic, and the subscriber requests manualByTopic",
    "chatter.publisher.Said.qos.liveliness=manualByTopic or "
    "chatter.subscriber.Heard.qos.liveliness=automatic",
)
def automatic_for_manual(small: Small) -> None:
    _differ(small, "liveliness", "automatic", "manualByTopic")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}lease duration is 3 s, and the subscriber requests 2 s",
    "chatter.publisher.Said.qos.leaseDuration=2.0 or chatter.subscriber.Heard.qos.leaseDuration=3.0",
)
def longer_lease(small: Small) -> None:
    _differ(small, "leaseDuration", 3.0, 2.0)


def _watched(small: Small) -> sym.SubscriberPort:
    """Return the subscriber, with a deadline and a place for missed ones."""
    port: sym.SubscriberPort = small["chatter"].subscribers[0]
    small.net.middleware = "ros2"
    small["chatter"].qos = sym.QualityOfService(deadline=1.0)
    net = small["chatter"].subscribers[0].place.page
    port.missed = sym.Place(id="Missed", page=net)
    flow(port.missed, sym.Transition(id="Complain", page=net))
    return port


@CASES.breaks(
    "missed-has-deadline",
    f"{HEARD} names the place 'Missed' for missed deadlines, and has no deadline",
    "give its quality of service a deadline, or name no place",
)
def no_deadline_to_miss(small: Small) -> None:
    _watched(small)
    small["chatter"].qos = None


@CASES.breaks(
    "missed-in-one-node-net",
    f"{HEARD} has its messages in node net 'listener' and the place of its missed deadlines "
    "in node net 'talker'",
    "put both places into one node net",
)
def another_node_misses(small: Small) -> None:
    port = _watched(small)
    port.missed = sym.Place(id="There", page=small["talker"])
    flow(port.missed, sym.Transition(id="Wonder", page=small["talker"]))


@CASES.breaks(
    "missed-begins-no-callback",
    f"{HEARD} has its place for missed deadlines on callback page 'later', "
    "which a missed deadline does not begin",
    "put the place on the callback page that takes the messages, or on none",
)
def another_callback_misses(small: Small) -> None:
    port = _watched(small)
    net = small["listener"]
    net.execution = "callbacks"
    page = sym.CallbackPage(id="later", kind="timer", timer=1.0, page=net)
    port.missed = sym.Place(id="Late", page=page)
    flow(sym.Transition(id="Also", page=page), port.missed, sym.Transition(id="Then", page=page))


@CASES.breaks(
    "deadlines-of-ros2",
    f"{HEARD} names a place for missed deadlines, which the rules of ros1 do not have",
    "set the model's middleware to ros2, or name no place",
)
def deadline_of_ros1(small: Small) -> None:
    _watched(small)
    small.net.middleware = "ros1"
