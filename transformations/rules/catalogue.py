"""All rules by family, the paper's in its order; how rules are called, and in which order they run."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from types import ModuleType
from typing import Literal, TypeAlias

from dineros.metamodel import sym
from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules import (
    absent_servers,
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
from dineros.transformations.rules.clients import acceptances, cancels
from dineros.transformations.rules.clients import requests as unbounded


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


def _defined_in(*modules: ModuleType) -> tuple[type[Rule], ...]:
    """Return the rules that modules define, by their numbers; those of one number as they stand there."""
    found = (
        value
        for module in modules
        for value in vars(module).values()
        if isinstance(value, type) and issubclass(value, Rule) and value.__module__ == module.__name__
    )
    return tuple(sorted(found, key=lambda rule: rule.__name__[:2]))


_MANAGED = _defined_in(lifecycle, coming_and_going, managed, absent_servers)
"""The rules of managed nodes, as they are shown and run."""

FAMILIES = (
    Family(
        "topics",
        "Topics: publisher, dispatcher and subscriber queues",
        "Sect. 5.5.1, Fig. 8",
        _defined_in(topics),
    ),
    Family(
        "services",
        "Services: server instances and the clients' calls",
        "Sect. 5.5.3, Fig. 10",
        _defined_in(services),
    ),
    Family(
        "signals",
        "Signals: values, clauses, and when they may change",
        "Sect. 5.5.4, Fig. 11 and 12",
        (
            *(signals.I1, signals.I2, signals.I3, signals.I4, signals.I5FullyEnabled),
            *(signals.I5InputEnabled, signals.I6InputEnabled, signals.I5IoEnabled, signals.I6IoEnabled),
        ),
    ),
    Family(
        "histories",
        "Topics of ROS 2: writer and reader histories",
        "",
        _defined_in(histories),
        "They take the place of T1 to T4 where the middleware is `ros2`.",
    ),
    Family(
        "timers",
        "Timers of ROS 2",
        "",
        _defined_in(timers),
        "They run where the middleware is `ros2`.",
    ),
    Family(
        "executors",
        "Executors and callback groups of ROS 2",
        "",
        _defined_in(executors),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    Family(
        "requests",
        "Services of ROS 2: request histories and time-outs",
        "",
        _defined_in(requests, unbounded),
        "They come after S1 to S4 where the middleware is `ros2`, for services that can lose requests; R8 "
        "for clients that do not wait.",
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
        _defined_in(goals, ends, feedback, slots, publishing, cancels, acceptances),
        "They run under every middleware, after those of services; A6 runs before all others, A5-room, "
        "A5-first, A5-hand, A8-room and A8-answer with those about capacities.",
    ),
    Family(
        "goals",
        "Executors and callback groups of ROS 2: goals of actions",
        "",
        _defined_in(served),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    Family(
        "capacities",
        "Capacities of places",
        "",
        _defined_in(capacities),
        "They run last of all rules: B1 and B4 under every middleware, the others where it is `ros2`.",
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
    *(
        cancels.A8,
        cancels.A8Twice,
        goals.A3Hear,
        goals.A3Refuse,
        ends.A4,
        ends.A4Late,
        ends.A4Cancel,
        ends.A4Unheeded,
    ),
    *(feedback.A5, feedback.A5Tell),
    *(acceptances.A9, acceptances.A9Accept, acceptances.A9Once, acceptances.A9First),
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
LIFECYCLE_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {"ros1": [], "ros2": list(_MANAGED)}
"""They run after all others but those of capacities: they say when what those made may happen."""
SERVICE_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [services.S3, services.S1, services.S2],
    "ros2": [
        *(services.S3, services.S1, services.S2),
        *_defined_in(requests),
        *(unbounded.R8, unbounded.R8GiveUp, unbounded.R8Place, unbounded.R8Always, unbounded.R8Ready),
    ],
}
FORGETTING_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [],
    "ros2": [unbounded.R8Forgets, unbounded.R8Lost],
}
"""They run after those of managed nodes: they take away where all others put requests that are lost."""
_CANCELS = (cancels.A8Room, cancels.A8Answer)
CAPACITY_RULES: dict[MiddlewareVariant, list[type[Rule]]] = {
    "ros1": [capacities.B1, feedback.A5Room, feedback.A5First, feedback.A5Hand, *_CANCELS, capacities.B4],
    "ros2": [
        *(capacities.B1, capacities.B2, capacities.B2Ask, capacities.B3),
        *(feedback.A5Room, feedback.A5First, feedback.A5Hand, *_CANCELS, capacities.B4),
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
        *FORGETTING_RULES[middleware],
    ]
