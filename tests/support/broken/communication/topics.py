"""Models that break the constraints of `topics`."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, runtime

CASES = Cases()


@CASES.breaks(
    "topic-has-publisher",
    "topic channel 'chatter' has no publisher",
    "add a publisher port",
)
def no_publisher(small: Small) -> None:
    small["chatter"].publishers.clear()


@CASES.breaks(
    "topic-has-subscriber",
    "topic channel 'chatter' has no subscriber",
    "add a subscriber port",
)
def no_subscriber(small: Small) -> None:
    small["chatter"].dispatchers.clear()
    small["chatter"].subscribers.clear()
    small["hear"].kind = "timer"
    small["hear"].timer = 1.0


def untyped(small: Small) -> sym.TopicChannel:
    """Give the topic messages of its own, with ids."""
    channel: sym.TopicChannel = small["chatter"]
    channel.type = None
    channel.mappings.clear()
    return channel


@CASES.breaks(
    "topic-survives-restarts",
    "messages of topic channel 'chatter' are lost when a node continues after a restart: it is volatile, so "
    "that nothing is kept for a subscriber that is down",
    "drop its quality of service: by default nothing is lost, and the limits are the depth",
)
def volatile_topic(small: Small) -> None:
    untyped(small).qos = sym.QualityOfService()


@CASES.breaks(
    "topic-survives-restarts",
    "messages of topic channel 'chatter' are lost when a node continues after a restart: it is bestEffort",
    "drop its quality of service: by default nothing is lost, and the limits are the depth",
)
def best_effort_topic(small: Small) -> None:
    small["chatter"].qos = sym.QualityOfService(reliability="bestEffort")


@CASES.breaks(
    "port-limit",
    "publisher port 'Said' of topic channel 'chatter' has the limit 0",
    "give it a limit of 1 or more",
)
def publisher_limit_0(small: Small) -> None:
    small["chatter"].publishers[0].limit = 0


@CASES.breaks(
    "port-limit",
    "subscriber port 'Heard' of topic channel 'chatter' has the limit -3",
    "give it a limit of 1 or more",
)
def negative_subscriber_limit(small: Small) -> None:
    small["chatter"].subscribers[0].limit = -3


@CASES.breaks(
    "dispatcher-limit",
    "dispatcher 'listener' of topic channel 'chatter' has the limit 0",
    "give it a limit of 1 or more",
)
def limit_0(small: Small) -> None:
    small["chatter"].dispatchers[0].limit = 0


@CASES.breaks(
    "dispatcher-subscribes",
    "dispatcher 'talker' of topic channel 'chatter' is for a node net that does not subscribe",
    "remove it or add a subscriber port",
)
def publishing_node_net(small: Small) -> None:
    small["chatter"].dispatchers[0].node = small["talker"]


@CASES.breaks(
    "dispatcher-once",
    "dispatcher 'listener' of topic channel 'chatter' is for node net 'listener', as another one is",
    "keep one of them",
)
def two_dispatchers(small: Small) -> None:
    small["chatter"].dispatchers.append(sym.Dispatcher(node=small["listener"]))


@CASES.breaks(
    "subscriber-on-callback-page",
    "subscriber port 'Count' of topic channel 'chatter' has its place on no callback page",
    "put the place on a callback page of the kind subscriber",
)
def no_callback_page(small: Small) -> None:
    small["chatter"].subscribers.append(sym.SubscriberPort(place=small["Count"]))


@CASES.breaks(
    "subscriber-on-callback-page",
    "subscriber port 'Late' of topic channel 'chatter' has its place on a timer callback page",
    "put the place on a callback page of the kind subscriber",
)
def timer_page(small: Small) -> None:
    small["chatter"].subscribers[0].place = small["Heard"]
    sym.Place(id="Late", page=small["clock"])
    small["chatter"].subscribers.append(sym.SubscriberPort(place=small["Late"]))


@CASES.breaks(
    "runtime-publisher-limit",
    "publisher port '/chatter' of place 'Said' has the limit 0",
    "give it a limit of 1 or more",
    of=runtime,
)
def limit_0_2(small: Small) -> None:
    small["Said"].ports[0].limit = 0


@CASES.breaks(
    "runtime-subscriber-limits",
    "subscriber port '/news' of place 'Heard' has the limit 10 and the dispatcher limit 0",
    "give it limits of 1 or more",
    of=runtime,
)
def dispatcher_limit_0(small: Small) -> None:
    small["Heard"].ports[0].dispatcherLimit = 0
