"""Models that break the constraints of `histories`."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, plain

CASES = Cases()


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
    "subscriber port 'Heard' of topic channel 'chatter' says how many messages are in hand, "
    "and its place 'Heard' has a capacity",
    "say only one of both",
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
    "subscriber port 'Heard' of topic channel 'chatter' gets no message of "
    "publisher port 'Said' of topic channel 'chatter': the publisher's "
)


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}reliability is bestEffort, and the subscriber asks for reliable",
    "chatter.publisher.Said.qos.reliability=reliable or chatter.subscriber.Heard.qos.reliability=bestEffort",
)
def best_effort_for_reliable(small: Small) -> None:
    _differ(small, "reliability", "bestEffort", "reliable")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}durability is volatile, and the subscriber asks for transientLocal",
    "chatter.publisher.Said.qos.durability=transientLocal or "
    "chatter.subscriber.Heard.qos.durability=volatile",
)
def volatile_for_transient_local(small: Small) -> None:
    _differ(small, "durability", "volatile", "transientLocal")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}deadline is without bound, and the subscriber asks for 0.5 s",
    "chatter.publisher.Said.qos.deadline=0.5 or chatter.subscriber.Heard.qos.deadline=",
)
def no_deadline_for_one(small: Small) -> None:
    _differ(small, "deadline", None, 0.5)


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}liveliness is automatic, and the subscriber asks for manualByTopic",
    "chatter.publisher.Said.qos.liveliness=manualByTopic or "
    "chatter.subscriber.Heard.qos.liveliness=automatic",
)
def automatic_for_manual(small: Small) -> None:
    _differ(small, "liveliness", "automatic", "manualByTopic")


@CASES.breaks(
    "ports-match",
    f"{_NOTHING}lease duration is 3 s, and the subscriber asks for 2 s",
    "chatter.publisher.Said.qos.leaseDuration=2.0 or chatter.subscriber.Heard.qos.leaseDuration=3.0",
)
def longer_lease(small: Small) -> None:
    _differ(small, "leaseDuration", 3.0, 2.0)
