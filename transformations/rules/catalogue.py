"""All rules by family, the paper's in its order; the names of rules, and the order in which they run."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from types import ModuleType

from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.language.rule import Rule, RuleType
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
    starts,
    timers,
    topics,
)
from dineros.transformations.rules.actions import callbacks as served
from dineros.transformations.rules.actions import ends, feedback, goals, managed, publishing, slots
from dineros.transformations.rules.clients import acceptances, answers, cancels, living
from dineros.transformations.rules.clients import goals as many_goals
from dineros.transformations.rules.clients import requests as unbounded
from dineros.transformations.rules.phases import (
    MiddlewareVariant,
    OverflowVariant,
    SignalVariant,
    StandardRule,
    in_order,
)
from dineros.transformations.rules.times import (
    deadlines,
    latencies,
    lifespans,
    orders,
    reactions,
    strikes,
    time_outs,
    work,
)
from dineros.transformations.rules.times import goals as of_goals


@dataclass(frozen=True)
class Family:
    """A family of rules.

    Attributes
    ----------
    name : str
        One word: ``topics``.
    title : str
        Description of the rules.
    section : str
        Section of the paper; empty if the paper does not have them.
    rules : tuple of Rule
        By their numbers.
    about : str
        Their origin, if it is not the paper.
    modules : tuple of module
        The modules that define them.
    """

    name: str
    title: str
    section: str
    rules: tuple[type[Rule], ...]
    about: str = ""
    modules: tuple[ModuleType, ...] = ()


def _family(name: str, title: str, section: str, modules: tuple[ModuleType, ...], about: str = "") -> Family:
    rules = sorted(_defined_in(modules), key=lambda rule: rule.__name__[:2])
    return Family(name, title, section, tuple(rules), about, modules)


def _defined_in(modules: Iterable[ModuleType]) -> Iterator[type[StandardRule]]:
    """Yield the rules that modules define, in the order of definition."""
    for module in modules:
        for value in vars(module).values():
            if isinstance(value, RuleType) and value.__module__ == module.__name__:
                assert issubclass(value, StandardRule), f"{value.__name__} declares no phase"
                yield value


FAMILIES = (
    _family(
        "topics",
        "Topics: publisher, dispatcher and subscriber queues",
        "Sect. 5.5.1, Fig. 8",
        (topics,),
    ),
    _family(
        "services",
        "Services: server instances and the clients' calls",
        "Sect. 5.5.3, Fig. 10",
        (services,),
    ),
    _family(
        "signals",
        "Signals: values, clauses, and when they may change",
        "Sect. 5.5.4, Fig. 11 and 12",
        (signals,),
    ),
    _family(
        "histories",
        "Topics of ROS 2: writer and reader histories",
        "",
        (histories,),
        "They take the place of T1 to T4 where the middleware is `ros2`.",
    ),
    _family(
        "deadlines",
        "Deadlines of subscriptions of ROS 2",
        "",
        (deadlines,),
        "They run where the middleware is `ros2`, for subscriptions that name a place for missed deadlines.",
    ),
    _family(
        "timers",
        "Timers of ROS 2",
        "",
        (starts, timers),
        "They run where the middleware is `ros2`.",
    ),
    _family(
        "executors",
        "Executors and callback groups of ROS 2",
        "",
        (executors,),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    _family(
        "requests",
        "Services of ROS 2: request histories and time-outs",
        "",
        (requests, living, unbounded),
        "They come after S1 to S4 where the middleware is `ros2`, for services that can lose requests; R8 "
        "for clients that do not wait.",
    ),
    _family(
        "lifecycle",
        "Managed nodes of ROS 2",
        "",
        (lifecycle, coming_and_going, managed, absent_servers),
        "They run where the middleware is `ros2`, for node nets that have a lifecycle.",
    ),
    _family(
        "actions",
        "Actions: goals, slots, requests to cancel, outcomes, feedback",
        "",
        (slots, goals, ends, feedback, publishing, cancels, acceptances),
        "They run under every middleware, after those of services; A6 runs before all others, A5-room, "
        "A5-first, A5-hand, A8-room, A8-answer, A8-send, those of A8-more but A8-more itself, and A8-any "
        "with those about capacities.",
    ),
    _family(
        "clients",
        "Actions of ROS 2: clients that do not wait",
        "",
        (many_goals, answers),
        "They run where the middleware is `ros2`, for actions that have a client which sends a goal before "
        "its last one is over.",
    ),
    _family(
        "goals",
        "Executors and callback groups of ROS 2: goals of actions",
        "",
        (served,),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
    ),
    _family(
        "times",
        "Times of ROS 2: strikes, work, messages on their way, reactions, time-outs, orders",
        "",
        (strikes, work, latencies, lifespans, reactions, time_outs, orders, of_goals),
        "They run where the middleware is `ros2` and a question asks about time.",
    ),
    _family(
        "capacities",
        "Capacities of places",
        "",
        (capacities,),
        "They run last of all rules: B1 and B4 under every middleware, the others where it is `ros2`.",
    ),
)


def name_of(rule: type[Rule] | str) -> str:
    """Return the public name of a rule: ``T2``, and ``I5-input-enabled`` for the class `I5InputEnabled`."""
    name = rule if isinstance(rule, str) else rule.__name__
    numbered = re.fullmatch(r"([A-Z]\d)([A-Z]\w*)", name)
    if numbered is None:
        return name
    words = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", numbered[2])
    return f"{numbered[1]}-{words.lower()}"


def summary_of(rule: type[Rule]) -> str:
    """Return the first line of a rule's docstring, without the full stop."""
    return (rule.__doc__ or "").strip().partition("\n")[0].rstrip(".")


def find_rule(name: str, families: Sequence[Family] = FAMILIES) -> type[Rule]:
    """Return the rule with a name, ignoring case.

    Raises
    ------
    UnknownElementError
        There is none; the hint has similar names.
    """
    rules = [rule for family in families for rule in family.rules]
    for rule in rules:
        if name.lower() in (name_of(rule).lower(), rule.__name__.lower()):
            return rule
    known = [name_of(rule) for rule in rules]
    hint = near_matches(name, known) or f"known are {', '.join(known)}"
    raise UnknownElementError(f"there is no rule {name!r}", hint=hint)


@cache
def rules_of(
    signals: SignalVariant,
    overflow: OverflowVariant,
    middleware: MiddlewareVariant = "ros1",
    times: bool = False,
) -> tuple[type[StandardRule], ...]:
    """Return the rules of a variant, in the order in which they run.

    If lookups do not determine the order of two rules, the order of definition does.
    """
    defined = _defined_in(module for family in FAMILIES for module in family.modules)
    chosen = [rule for rule in defined if rule.runs_with(signals, overflow, middleware, times)]
    return tuple(in_order(chosen))
