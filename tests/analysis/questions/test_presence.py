"""Messages that are lost because a managed node is not there, or not active: found, excluded, left open."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.checks.overflow import Presence
from dineros.analysis.witnesses.records import witness_records
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find
from dineros.metamodel.records import Drop, Lifecycle
from tests.support.references.lifecycles import LifecycleInterpreter
from tests.support.ros2_systems.managed_systems import talk

RULES = {fault.rule for fault in Presence.faults}
PROVED = {proved for _, proved in Presence._KINDS.values()}


def found(model: sym.SystemModel) -> list[str]:
    return sorted({finding.rule for finding in check(model).findings if finding.rule in RULES})


LIFE = sym.Lifecycle
CASES: list[tuple[Callable[[], sym.SystemModel], list[str]]] = [
    (talk, []),
    (lambda: talk(None, LIFE()), ["subscriber-not-there"]),
    (lambda: talk(LIFE(), None), ["published-while-inactive"]),
    (lambda: talk(LIFE(pauses=True), None), []),
    (lambda: talk(LIFE(pauses=True, deactivates=True), None), ["published-while-inactive"]),
    (lambda: talk(None, LIFE(), late=True), []),
    (lambda: talk(None, LIFE(), late=True, reliability="bestEffort"), ["subscriber-not-there"]),
    (lambda: talk(None, LIFE(cleansUp=True), late=True), ["lost-with-node"]),
    (lambda: talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1)), []),
    (lambda: talk(LIFE(pauses=True, activateStep=1), LIFE(configureStep=2)), ["subscriber-not-there"]),
    (
        lambda: talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1, cleansUp=True)),
        ["lost-with-node", "subscriber-not-there"],
    ),
]


@pytest.mark.parametrize("number", range(len(CASES)))
def test_what_is_found(number: int) -> None:
    make, rules = CASES[number]
    assert found(make()) == rules
    # The same, counted by an interpreter that makes no net: what can happen of all its events.
    assert _happens(make()) == rules


def _happens(model: sym.SystemModel) -> list[str]:
    """Return which losses an exhaustive walk through the model sees."""
    named = {
        "discard": "published-while-inactive",
        "miss": "subscriber-not-there",
        "left": "lost-with-node",
        "gone": "lost-with-node",
        "clear": "lost-with-node",
    }
    play = LifecycleInterpreter(model)
    seen, queue, lost = {play.start}, [play.start], set()
    while queue:
        for event, after in play.successors(queue.pop()):
            lost.add(named.get(event.rpartition(".")[2], ""))
            if after not in seen:
                seen.add(after)
                queue.append(after)
    return sorted(lost - {""})


def test_a_witness_says_when_the_nodes_came_up() -> None:
    report = check(talk(LIFE(), LIFE()))
    finding = next(each for each in report.findings if each.rule == "subscriber-not-there")
    assert finding.elements == ("Talk", "Said", "Heard")
    assert finding.witness is not None
    assert [step.text for step in finding.witness.steps] == [
        "node net talker is configured",
        "Say",
        "node net talker is activated",
        "Said publishes a message on topic /talk",
        "a message of Said on topic /talk is lost: Heard of node net listener is not there",
    ]
    records = list(witness_records(finding.witness, source="talk.sym.xmi"))
    changes = [(each.node, each.label, each.state) for each in records if isinstance(each, Lifecycle)]
    assert changes == [("talker", "configure", "inactive"), ("talker", "activate", "active")]
    assert isinstance(records[-1], Drop)


def test_what_is_proved() -> None:
    report = check(talk(LIFE(pauses=True, activateStep=2), LIFE(configureStep=1)))
    assert PROVED.intersection(report.proved) == {
        "no managed node publishes while it is inactive",
        "every subscriber is there for what is published",
    }
    assert not PROVED.intersection(check(talk()).proved), "nobody asks where no node is managed"


def test_without_a_state_space() -> None:
    """A net without bounds: what can be answered on the way is."""
    model = talk(LIFE(), LIFE())
    talker = find(model, "talker", sym.NodeNet)
    grows = sym.Place(id="Grows", page=talker)
    flow(sym.Transition(id="Grow", page=talker), grows)
    report = check(model)
    assert {each.rule for each in report.findings} >= {"unbounded", "subscriber-not-there"}
    assert all(each.witness for each in report.findings if each.rule in RULES)


def test_a_budget_that_is_too_small() -> None:
    report = check(talk(LIFE(), LIFE()), Budget(seconds=0.0))
    assert not report.findings
    assert report.unknown
