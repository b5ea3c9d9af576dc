"""All rules by family, the paper's in its order; how rules are called, and in which order they run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, TypeAlias

from dineros.metamodel import sym
from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules import (
    capacities,
    coming_and_going,
    executors,
    histories,
    lifecycle,
    requests,
    services,
    signals,
    timers,
    topics,
)
from dineros.transformations.rules.actions import callbacks as served
from dineros.transformations.rules.actions import ends, feedback, goals, managed, publishing, slots


@dataclass(frozen=True)
class Family:
    """Rules that belong together.

    Attributes
    ----------
    name : str
        One word: ``topics``.
    title : str
        What the rules do.
    section : str
        Where the paper has them; empty where it has none.
    rules : tuple of Rule
        In the paper's order.
    about : str
        Where they come from, if not from the paper.
    """

    name: str
    title: str
    section: str
    rules: tuple[type[Rule], ...]
    about: str = ""


_MANAGED = (
    lifecycle.L1,
    lifecycle.L1ConfigureFails,
    lifecycle.L1ActivateFails,
    lifecycle.L1Deactivate,
    lifecycle.L1Cleanup,
    lifecycle.L1Shutdown,
    lifecycle.L1Configured,
    lifecycle.L1ConfiguredActive,
    lifecycle.L1Activated,
    lifecycle.L1ActivatedActive,
    lifecycle.L1Thread,
    lifecycle.L1Exclusive,
    lifecycle.L2,
    lifecycle.L3,
    lifecycle.L3Begin,
    lifecycle.L3Outside,
    lifecycle.L3Tick,
    lifecycle.L3Take,
    lifecycle.L3Serve,
    lifecycle.L3Ask,
    lifecycle.L3GiveUp,
    managed.L3Accept,
    managed.L3Goal,
    managed.L3Tell,
    managed.L3End,
    managed.L3Send,
    managed.L3Wish,
    managed.L3Hear,
    coming_and_going.L4,
    coming_and_going.L4Kept,
    coming_and_going.L4Deliver,
    coming_and_going.L4Left,
    coming_and_going.L4LeftKept,
    coming_and_going.L4Gone,
    coming_and_going.L4Written,
    coming_and_going.L4Read,
    coming_and_going.L4Clear,
    coming_and_going.L4Cleared,
    managed.L4Feedback,
    managed.L4FeedbackCleared,
    coming_and_going.L5,
    coming_and_going.L5Replace,
    coming_and_going.L5ReplaceFinalized,
    coming_and_going.L5Again,
    coming_and_going.L5Forget,
    coming_and_going.L5Left,
    coming_and_going.L5Drained,
    coming_and_going.L5Forgotten,
)
"""The rules of managed nodes, as they are shown and run."""

FAMILIES = (
    Family(
        "topics",
        "Topics: publisher, dispatcher and subscriber queues",
        "Sect. 5.5.1, Fig. 8",
        (
            topics.T1,
            topics.T2,
            topics.T2History,
            topics.T2Instance,
            topics.T3,
            topics.T4,
            topics.T5a,
            topics.T5b,
        ),
    ),
    Family(
        "services",
        "Services: server instances and the clients' calls",
        "Sect. 5.5.3, Fig. 10",
        (services.S1, services.S2, services.S3, services.S4, services.S4Client),
    ),
    Family(
        "signals",
        "Signals: values, clauses, and when they may change",
        "Sect. 5.5.4, Fig. 11 and 12",
        (
            signals.I1,
            signals.I2,
            signals.I3,
            signals.I4,
            signals.I5FullyEnabled,
            signals.I5InputEnabled,
            signals.I6InputEnabled,
            signals.I5IoEnabled,
            signals.I6IoEnabled,
        ),
    ),
    Family(
        "histories",
        "Topics of ROS 2: writer and reader histories",
        "",
        (histories.R1, histories.R1Instance, histories.R2, histories.R3, histories.R4),
        "They take the place of T1 to T4 where the middleware is `ros2`.",
    ),
    Family(
        "timers",
        "Timers of ROS 2",
        "",
        (timers.C1,),
        "They run where the middleware is `ros2`.",
    ),
    Family(
        "executors",
        "Executors and callback groups of ROS 2",
        "",
        (
            executors.E1,
            executors.E2,
            executors.E2Default,
            executors.E3,
            executors.E3Take,
            executors.E3Tick,
            executors.E3Serve,
            executors.E3Exclusive,
            executors.E3Once,
            executors.E3OnceExclusive,
            executors.E4,
            executors.E4Reply,
            executors.E4Exclusive,
            executors.E5,
            executors.E5Exclusive,
            executors.E6,
            executors.E6Exclusive,
            executors.E7,
            executors.E7Call,
            executors.E7GiveUp,
        ),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    Family(
        "requests",
        "Services of ROS 2: request histories and time-outs",
        "",
        (
            requests.R5,
            requests.R5Client,
            requests.R6,
            requests.R6Client,
            requests.R6Instance,
            requests.R7,
            requests.R7Instance,
            requests.R7Place,
        ),
        "They come after S1 to S4 where the middleware is `ros2`, for services that can lose requests.",
    ),
    Family(
        "lifecycle",
        "Managed nodes of ROS 2",
        "",
        _MANAGED,
        "They run where the middleware is `ros2`, for node nets that have a lifecycle.",
    ),
    Family(
        "actions",
        "Actions: goals, slots, requests to cancel, outcomes, feedback",
        "",
        (
            *(goals.A1, goals.A1Result, goals.A1Fetch, goals.A2, goals.A2Reject, goals.A2Tell),
            *(goals.A3, goals.A3Again, goals.A3Nothing, goals.A3Over, goals.A3Hear, goals.A3Refuse),
            *(ends.A4, ends.A4Late, ends.A4Cancel, ends.A4Unheeded),
            *(feedback.A5, feedback.A5Tell, feedback.A5Room, feedback.A5First, feedback.A5Hand),
            *(slots.A6, slots.A6Client, slots.A7, slots.A7Ask, slots.A7Cancel),
            *(publishing.R1Slot, publishing.T2SlotHistory, publishing.T2Slot),
        ),
        "They run under every middleware, after those of services; A6 runs before all others, A5-room, "
        "A5-first and A5-hand with those about capacities.",
    ),
    Family(
        "goals",
        "Executors and callback groups of ROS 2: goals of actions",
        "",
        (
            *(served.E3Accept, served.E3AcceptAwaiting, served.E3AcceptExclusive, served.E3Step),
            *(served.E4End, served.E5Serve, served.E5ServeExclusive, served.E5Answer),
            *(served.E5AnswerExclusive, served.E6Answer, served.E6AnswerExclusive),
            *(served.E7Send, served.E7Answer),
        ),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    Family(
        "capacities",
        "Capacities of places",
        "",
        (capacities.B1, capacities.B2, capacities.B3, capacities.B4),
        "They run last of all rules: B1 and B4 under every middleware, B2 and B3 where it is `ros2`.",
    ),
)

SignalVariant: TypeAlias = Literal["none", "fully-enabled", "input-enabled", "io-enabled"]
MiddlewareVariant: TypeAlias = Literal["ros1", "ros2"]
OverflowVariant: TypeAlias = Literal["weighted", "inhibitor"]

_INPUT_ENABLED = [signals.I4, signals.I5InputEnabled, signals.I6InputEnabled]
_COUNT_LITERALS = [signals.I1, signals.I2, signals.I3]
_IO_ENABLED = [signals.I5IoEnabled, signals.I6IoEnabled]

SIGNAL_RULES: dict[SignalVariant, list[type[Rule]]] = {
    "none": [],
    "fully-enabled": [signals.I4, signals.I5FullyEnabled, *_COUNT_LITERALS],
    "input-enabled": [*_INPUT_ENABLED, *_COUNT_LITERALS],
    "io-enabled": [*_INPUT_ENABLED, *_IO_ENABLED, *_COUNT_LITERALS],
}
OVERFLOW_RULES: dict[OverflowVariant, type[Rule]] = {"weighted": topics.T5b, "inhibitor": topics.T5a}
INSTANCE_RULES: dict[type[sym.Channel], tuple[type[Rule], type[Rule]]] = {
    sym.ActionChannel: (slots.A6, slots.A6Client),
    sym.ServiceChannel: (services.S4, services.S4Client),
}
"""What copies the server page of a channel, and the clients that stand there."""
ACTION_RULES: list[type[Rule]] = [
    *(slots.A7, slots.A7Ask, slots.A7Cancel, goals.A1, goals.A1Result, goals.A1Fetch),
    *(goals.A2, goals.A2Reject, goals.A2Tell, goals.A3, goals.A3Again, goals.A3Nothing, goals.A3Over),
    *(goals.A3Hear, goals.A3Refuse, ends.A4, ends.A4Late, ends.A4Cancel, ends.A4Unheeded),
    *(feedback.A5, feedback.A5Tell),
]
TOPIC_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [
        *(topics.T1, topics.T2, topics.T2History, topics.T2Instance),
        *(publishing.T2SlotHistory, publishing.T2Slot, topics.T3, topics.T4),
    ],
    "ros2": [histories.R3, histories.R2, histories.R1, histories.R1Instance, publishing.R1Slot, histories.R4],
}
CALLBACK_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [],
    "ros2": [
        timers.C1,
        *(executors.E1, executors.E2, executors.E2Default, executors.E3),
        *(executors.E3Take, executors.E3Tick, executors.E3Serve, executors.E6),
        *(served.E3Accept, served.E3AcceptAwaiting, served.E3AcceptExclusive, served.E3Step, served.E6Answer),
        *(executors.E4, executors.E4Reply, served.E4End, executors.E3Once),
        *(executors.E3Exclusive, executors.E4Exclusive, executors.E3OnceExclusive),
        *(executors.E5, executors.E5Exclusive, executors.E6Exclusive, executors.E7, executors.E7Call),
        *(executors.E7GiveUp, served.E5Serve, served.E5ServeExclusive, served.E5Answer),
        *(served.E5AnswerExclusive, served.E6AnswerExclusive, served.E7Send, served.E7Answer),
    ],
}
"""They run after those of signals, whose places are those of the model."""
LIFECYCLE_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [],
    "ros2": list(_MANAGED),
}
"""They run after all others but those of capacities: they say when what those made may happen."""
SERVICE_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [services.S3, services.S1, services.S2],
    "ros2": [
        services.S3,
        services.S1,
        services.S2,
        requests.R5,
        requests.R5Client,
        requests.R6,
        requests.R6Client,
        requests.R6Instance,
        requests.R7,
        requests.R7Instance,
        requests.R7Place,
    ],
}
CAPACITY_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [capacities.B1, feedback.A5Room, feedback.A5First, feedback.A5Hand, capacities.B4],
    "ros2": [
        *(capacities.B1, capacities.B2, capacities.B3),
        *(feedback.A5Room, feedback.A5First, feedback.A5Hand, capacities.B4),
    ],
}
"""They run last, after rules of one's own: they look at all arcs."""


def name_of(rule: type[Rule] | str) -> str:
    """Return what people call a rule: ``T2``, and ``I5-input-enabled`` for the class `I5InputEnabled`."""
    name = rule if isinstance(rule, str) else rule.__name__
    numbered = re.fullmatch(r"([A-Z]\d)([A-Z]\w*)", name)
    if numbered is None:
        return name
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", numbered[2])
    return f"{numbered[1]}-{words.lower()}"


def summary_of(rule: type[Rule]) -> str:
    """Return the first line of what a rule says about itself, without the full stop."""
    return (rule.__doc__ or "").strip().partition("\n")[0].rstrip(".")


def find_rule(name: str, families: Sequence[Family] = FAMILIES) -> type[Rule]:
    """Return the rule of a name, whichever way its letters are written.

    Raises
    ------
    UnknownElementError
        There is none; the hint names near matches.
    """
    rules = [rule for family in families for rule in family.rules]
    for rule in rules:
        if name.lower() in (name_of(rule).lower(), rule.__name__.lower()):
            return rule
    known = [name_of(rule) for rule in rules]
    hint = near_matches(name, known) or f"known are {', '.join(known)}"
    raise UnknownElementError(f"there is no rule {name!r}", hint=hint)


def rules_of(
    signals: SignalVariant, overflow: OverflowVariant, middleware: MiddlewareVariant = "ros1"
) -> list[type[Rule]]:
    """Return the rules of a variant, in the order they run.

    Those of `INSTANCE_RULES` run before them, those of `CAPACITY_RULES` after them.
    """
    return [
        *SERVICE_RULES[middleware],
        *ACTION_RULES,
        *TOPIC_RULES[middleware],
        OVERFLOW_RULES[overflow],
        *SIGNAL_RULES[signals],
        *CALLBACK_RULES[middleware],
        *LIFECYCLE_RULES[middleware],
    ]
