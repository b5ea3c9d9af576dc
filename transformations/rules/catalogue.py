"""All rules by family, the paper's in its order; the names of rules, and the order in which they run."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib import import_module

from dineros.metamodel.errors import UnknownElementError, near_matches
from dineros.transformations.language import Rule
from dineros.transformations.language.rule import RuleType
from dineros.transformations.rules.phases import (
    MiddlewareVariant,
    OverflowVariant,
    SignalVariant,
    StandardRule,
    in_order,
)


@dataclass(frozen=True)
class Family:
    """A family of rules."""

    name: str
    """One word: ``topics``."""
    title: str
    """Description of the rules."""
    section: str
    """Section of the paper; empty if the paper does not have them."""
    modules: tuple[str, ...]
    """The modules that define them, relative to this package; they are imported when the rules are needed."""
    about: str = ""
    """Their origin, if it is not the paper."""
    middleware: MiddlewareVariant | None = None
    """The only middleware under which its rules run: ``ros1``, ``ros2``."""
    times: bool = False
    """Whether its rules run only if time is modelled."""

    @cached_property
    def rules(self) -> tuple[type[Rule], ...]:
        """The rules, by their numbers."""
        return tuple(sorted(self.defined(), key=lambda rule: rule.__name__[:2]))

    def defined(self) -> Iterator[type[StandardRule]]:
        """Yield the rules in the order of definition."""
        for name in self.modules:
            module = import_module(f"{__package__}.{name}")
            for value in vars(module).values():
                if isinstance(value, RuleType) and value.__module__ == module.__name__:
                    assert issubclass(value, StandardRule), f"{value.__name__} declares no phase"
                    yield value

    def may_run(self, middleware: MiddlewareVariant, times: bool) -> bool:
        """Return whether some of its rules may run in a variant."""
        return self.middleware in (None, middleware) and (times or not self.times)


@dataclass(frozen=True)
class OwnRules(Family):
    """Rules of a user's file."""

    modules: tuple[str, ...] = ()
    loaded: tuple[type[Rule], ...] = ()

    @cached_property
    def rules(self) -> tuple[type[Rule], ...]:
        """The rules, by their positions in the file."""
        return self.loaded


FAMILIES = (
    Family(
        "topics",
        "Topics: publisher, dispatcher and subscriber queues",
        "Sect. 5.5.1, Fig. 8",
        ("topics",),
    ),
    Family(
        "services",
        "Services: server instances and the clients' calls",
        "Sect. 5.5.3, Fig. 10",
        ("services",),
    ),
    Family(
        "signals",
        "Signals: values, clauses, and when they may change",
        "Sect. 5.5.4, Fig. 11 and 12",
        ("signals",),
    ),
    Family(
        "histories",
        "Topics of ROS 2: writer and reader histories",
        "",
        ("histories",),
        "They take the place of T1 to T4 where the middleware is `ros2`.",
        middleware="ros2",
    ),
    Family(
        "deadlines",
        "Deadlines of subscriptions of ROS 2",
        "",
        ("times.deadlines",),
        "They run where the middleware is `ros2`, for subscriptions that name a place for missed deadlines.",
        middleware="ros2",
    ),
    Family(
        "timers",
        "Timers of ROS 2",
        "",
        ("starts", "timers"),
        "They run where the middleware is `ros2`.",
        middleware="ros2",
    ),
    Family(
        "executors",
        "Executors and callback groups of ROS 2",
        "",
        ("executors",),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
        middleware="ros2",
    ),
    Family(
        "requests",
        "Services of ROS 2: request histories and time-outs",
        "",
        ("requests", "clients.living", "clients.requests"),
        "They come after S1 to S4 where the middleware is `ros2`, for services that can lose requests; R8 "
        "for clients that do not wait.",
        middleware="ros2",
    ),
    Family(
        "lifecycle",
        "Managed nodes of ROS 2",
        "",
        ("lifecycle", "coming_and_going", "actions.managed", "absent_servers"),
        "They run where the middleware is `ros2`, for node nets that have a lifecycle.",
        middleware="ros2",
    ),
    Family(
        "actions",
        "Actions: goals, slots, requests to cancel, outcomes, feedback",
        "",
        (
            "actions.slots",
            "actions.goals",
            "actions.ends",
            "actions.feedback",
            "actions.publishing",
            "clients.cancels",
            "clients.acceptances",
        ),
        "They run under every middleware, after those of services; A6 runs before all others, A5-room, "
        "A5-first, A5-hand, A8-room, A8-answer, A8-send, those of A8-more but A8-more itself, and A8-any "
        "with those about capacities.",
    ),
    Family(
        "clients",
        "Actions of ROS 2: clients that do not wait",
        "",
        ("clients.goals", "clients.answers"),
        "They run where the middleware is `ros2`, for actions that have a client which sends a goal before "
        "its last one is over.",
        middleware="ros2",
    ),
    Family(
        "goals",
        "Executors and callback groups of ROS 2: goals of actions",
        "",
        ("actions.callbacks",),
        "They run where the middleware is `ros2`, for node nets whose execution is `callbacks`.",
        middleware="ros2",
    ),
    Family(
        "times",
        "Times of ROS 2: strikes, work, messages on their way, reactions, time-outs, orders",
        "",
        (
            "times.strikes",
            "times.work",
            "times.latencies",
            "times.lifespans",
            "times.reactions",
            "times.time_outs",
            "times.orders",
            "times.results",
            "times.goals",
            "times.managed",
        ),
        "They run where the middleware is `ros2` and a question asks about time.",
        middleware="ros2",
        times=True,
    ),
    Family(
        "capacities",
        "Capacities of places",
        "",
        ("capacities",),
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
    defined = (rule for family in FAMILIES if family.may_run(middleware, times) for rule in family.defined())
    return tuple(in_order([rule for rule in defined if rule.runs_with(signals, overflow, middleware, times)]))
