"""The order of rules follows from their phases and from what they look up."""

from __future__ import annotations

import random
import sys
from collections.abc import Iterator
from types import ModuleType
from typing import get_args

import pytest

from dineros.metamodel import sym
from dineros.transformations import rules as package
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.language.engine import makers
from dineros.transformations.language.errors import RuleError
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.rules import catalogue, topics
from dineros.transformations.rules.catalogue import FAMILIES, Family, rules_of
from dineros.transformations.rules.notation import OverflowQueue, arc, place
from dineros.transformations.rules.phases import (
    MiddlewareVariant,
    OverflowVariant,
    Phase,
    SignalVariant,
    StandardRule,
    in_order,
)
from dineros.transformations.rules.topics import T1
from tests.support.systems.talker import talker

VARIANTS = [
    (signals, overflow, middleware)
    for signals in get_args(SignalVariant)
    for overflow in get_args(OverflowVariant)
    for middleware in get_args(MiddlewareVariant)
]


@pytest.mark.parametrize("variant", VARIANTS)
def test_a_rule_comes_after_all_that_make_what_it_looks_up(
    variant: tuple[SignalVariant, OverflowVariant, MiddlewareVariant],
) -> None:
    rules = rules_of(*variant)
    shuffled = list(rules)
    random.Random(1).shuffle(shuffled)
    for order in (list(rules), in_order(shuffled)):
        assert set(order) == set(rules)
        assert [rule.phase for rule in order] == sorted(rule.phase for rule in order)
        for number, rule in enumerate(order):
            assert makers(rule, order) <= set(order[:number]), rule


def test_each_rule_of_the_package_runs_in_some_variant() -> None:
    used = {rule for variant in VARIANTS for times in (False, True) for rule in rules_of(*variant, times)}
    assert used == {
        rule for rule in _subclasses(StandardRule) if rule.__module__.startswith(package.__name__)
    }


@pytest.mark.parametrize("family", FAMILIES, ids=lambda family: family.name)
def test_a_family_that_is_not_imported_has_no_rule_that_would_run(family: Family) -> None:
    for signals, overflow, middleware in VARIANTS:
        for times in (False, True):
            if not family.may_run(middleware, times):
                assert not [
                    rule for rule in family.defined() if rule.runs_with(signals, overflow, middleware, times)
                ]


def _subclasses(rule: type[StandardRule]) -> Iterator[type[StandardRule]]:
    for each in rule.__subclasses__():
        yield each
        yield from _subclasses(each)


class CountsLeaving(StandardRule, phase=Phase.deliveries, middleware="ros1"):
    """Needs the queues of its own phase and of the one before."""

    channel = Node(sym.TopicChannel)
    queue = Made(OverflowQueue, of=channel)

    counted = place("{channel.id}.counted")
    arcs = [arc(queue.leave, counted)]


@pytest.fixture
def with_one_more(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Define a rule in a module that no other code names, and show it before all others."""
    module = ModuleType(f"{package.__name__}.elsewhere")
    monkeypatch.setattr(CountsLeaving, "__module__", module.__name__)
    monkeypatch.setattr(module, "CountsLeaving", CountsLeaving, raising=False)
    monkeypatch.setitem(sys.modules, module.__name__, module)
    more = Family("more", "One more", "", ("elsewhere",))
    monkeypatch.setattr(catalogue, "FAMILIES", (more, *FAMILIES))
    rules_of.cache_clear()
    yield
    monkeypatch.undo()
    rules_of.cache_clear()


@pytest.mark.usefixtures("with_one_more")
def test_a_rule_that_a_module_defines_runs_in_its_place() -> None:
    order = rules_of("none", "weighted", "ros1")
    place_of = order.index(CountsLeaving)
    assert max(order.index(rule) for rule in (topics.T2, topics.T3, topics.T4)) < place_of
    assert place_of < order.index(topics.T5b)
    assert CountsLeaving not in rules_of("none", "weighted", "ros2")

    model = talker()
    model.middleware = sym.Middleware.ros1
    roles = [link.role for link in flatten(model).trace if link.rule == "CountsLeaving"]
    queues = [link for link in flatten(model).trace if link.role == "queue.load"]
    assert queues
    assert roles.count("counted") == len(queues)


def test_a_lookup_of_what_a_later_phase_makes_is_refused() -> None:
    class Early(StandardRule, phase=Phase.services):
        channel = Node(sym.TopicChannel)
        topic = Made(T1.topic, of=channel)
        marked = place("{channel.id}.marked")

    with pytest.raises(RuleError, match="Early looks up what T1 makes, which runs later") as refused:
        in_order([Early, T1])
    assert refused.value.hint == "phase publications comes after services"


def test_rules_that_look_each_other_up_are_refused() -> None:
    class Left(OverflowQueue):
        """Of one rule."""

    class Right(OverflowQueue):
        """Of the other one."""

    class One(StandardRule, phase=Phase.drops):
        found = Made(Right)
        queue = Left("one", source=found.load, limit=found.load.tokens)

    class Other(StandardRule, phase=Phase.drops):
        found = Made(Left)
        queue = Right("other", source=found.load, limit=found.load.tokens)

    with pytest.raises(RuleError, match="in a circle: One, Other"):
        in_order([One, Other, T1])
