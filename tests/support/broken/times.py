"""Models that break the constraints on times."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.files.exact import exact_number
from tests.support.broken.cases import Cases
from tests.support.broken.small import Small, callbacks

CASES = Cases()
IN_NET = "set the execution of its node net to callbacks, or give the duration to its transitions"
LATE = "set the jitter to 0 or more, and to less than the period"


def timer(small: Small) -> sym.CallbackPage:
    """Make the page of a timer that strikes every tenth of a second."""
    return sym.CallbackPage(id="tick", kind="timer", timer=0.1, page=small["talker"])


@CASES.breaks(
    "callback-duration-usable",
    "callback page 'serve' has a duration, but its node net does not run callbacks",
    IN_NET,
)
def duration_of_a_callback_in_a_net(small: Small) -> None:
    small["serve"].duration = pn.TimeInterval(latest=0.1)


@CASES.breaks(
    "strikes-of-timers",
    "callback page 'serve' has an offset and a jitter, but is not called by a timer",
    "remove it, or set its kind to timer",
)
def strikes_of_a_server(small: Small) -> None:
    small["serve"].offset, small["serve"].jitter = pn.TimeInterval(latest=0.1), 0.01


@CASES.breaks(
    "jitter-within-period",
    "callback page 'tick' has the jitter 0.10000000000000000001, longer than its period 0.1",
    LATE,
)
def jitter_that_is_longer_by_a_hair(small: Small) -> None:
    timer(small).jitter = exact_number("0.10000000000000000001")


@CASES.breaks("jitter-within-period", "callback page 'tick' has the jitter -0.1, which is not a time", LATE)
def negative_jitter(small: Small) -> None:
    timer(small).jitter = -0.1


@CASES.breaks(
    "order-usable",
    "node net 'talker' takes callbacks in the order rclpy, but does not run callbacks",
    "set its execution to callbacks, or its order to any",
)
def order_of_a_net(small: Small) -> None:
    small["talker"].order = "rclpy"


@CASES.breaks(
    "interval-not-empty",
    "time interval of topic channel 'chatter' is empty: it runs from 0.2 to 0.1",
    "use a latest time after the earliest one, or the same time with both ends included",
)
def latency_upside_down(small: Small) -> None:
    small["chatter"].latency = pn.TimeInterval(earliest=0.2, latest=0.1)


@CASES.breaks(
    "interval-finite",
    "time interval of default times of system model 'small' runs from -1.0 to None",
    "use finite bounds of 0 or more, or no latest time for a transition that may wait forever",
)
def negative_default(small: Small) -> None:
    small.net.times = sym.DefaultTimes(duration=pn.TimeInterval(earliest=-1.0))


@CASES.breaks(
    "handler-duration-usable",
    "transition 'Note' has a duration, but its node net runs callbacks, which have durations of their own",
    "give the duration to its callback page, or an interval to the transition",
    of=callbacks,
)
def duration_of_a_transition_of_a_callback(small: Small) -> None:
    small["Note"].duration = pn.TimeInterval(latest=0.1)


@CASES.breaks(
    "reaction-usable",
    "node net 'node' has a reaction, but runs callbacks",
    "give durations to its callback pages, or set its execution to net",
    of=callbacks,
)
def reaction_of_an_executor(small: Small) -> None:
    small["node"].reaction = pn.TimeInterval(latest=0.1)
