"""The consequences of each cause are what a check no longer finds where the modeller fixes that cause.

The models are chains of nodes: each passes a message on to the next one. Faults are put into them at random.
A model without one of them is built anew by the test, and checked as a whole, without any folding.
"""

from __future__ import annotations

from random import Random
from typing import TypeAlias

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.checks.check import check
from dineros.analysis.consequences.folding import fold_consequences
from dineros.analysis.witnesses.findings import Finding
from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.clauses import set_clause

Fault: TypeAlias = tuple[str, int]
"""Its kind, and the number of its node."""

KINDS = {"group": "callback-deadlock", "quality": "ports-not-matched", "clause": "unsatisfiable-clause"}
"""Kinds of faults, with the rules that find them."""

Key: TypeAlias = tuple[str, tuple[str, ...]]


def chain(length: int, faults: frozenset[Fault]) -> sym.SystemModel:
    """Return a chain of nodes with faults."""
    model = sym.SystemModel(id="chain", middleware="ros2")
    first = node_net(model, "n0", execution="net")
    sent = place(first, "Sent0")
    step(first, "Say0", [place(first, "Budget", tokens=2)], [sent])
    for number in range(1, length + 1):
        node = node_net(model, f"n{number}", execution="callbacks", threads=2)
        page = callback(node, f"On{number}")
        heard = place(page, f"Heard{number}")
        before = heard
        if ("group", number) in faults or number % 2:
            before = call(model, node, page, number, heard, is_shared=("group", number) in faults)
        onward = place(page, f"Sent{number}")
        passes = step(page, f"Pass{number}", [before], [onward])
        if ("clause", number) in faults:
            node.signals.append(sym.InputSignal(id=f"dark{number}"))
            set_clause(passes, f"dark{number} & !dark{number}")
        link(model, number, sent, heard, is_matched=("quality", number) not in faults)
        sent = onward
    last = node_net(model, "last", execution="net")
    noted = place(last, "Heard")
    step(last, "Note", [noted], [place(last, "Noted")])
    link(model, length + 1, sent, noted, is_matched=True)
    return model


def call(
    model: sym.SystemModel,
    node: sym.NodeNet,
    page: sym.CallbackPage,
    number: int,
    heard: sym.Place,
    *,
    is_shared: bool,
) -> sym.Place:
    """Let a callback call a service, in its own group or in another one; return where the response comes."""
    helper = node_net(model, f"helper{number}", execution="net")
    serves = callback(helper, f"Serve{number}", "server")
    asked, answered = place(serves, f"Asked{number}"), place(serves, f"Answered{number}")
    step(serves, f"Answer{number}", [asked], [answered])
    request, response = place(page, f"Request{number}"), place(page, f"Response{number}")
    waits = place(page, f"Waits{number}")
    step(page, f"Ask{number}", [heard], [request, waits])
    has = place(page, f"Has{number}")
    step(page, f"Take{number}", [response, waits], [has])
    client = sym.ClientPort(client=f"n{number}", request=request, response=response)
    if not is_shared:
        node.callbackGroups.append(own := sym.CallbackGroup(id=f"calls{number}", kind="exclusive"))
        client.group = own
    port = sym.ServerPort(page=serves, entry=asked, exit=answered)
    service = sym.ServiceChannel(id=f"S{number}", service=f"/s{number}", server=port, clients=[client])
    model.channels.append(service)
    return has


def link(model: sym.SystemModel, number: int, sent: sym.Place, heard: sym.Place, *, is_matched: bool) -> None:
    """Connect two nodes by a topic that keeps two messages."""
    writer, reader = sym.PublisherPort(place=sent, limit=2), sym.SubscriberPort(place=heard, limit=2)
    if not is_matched:
        writer.qos = sym.QualityOfService(reliability="bestEffort")
        reader.qos = sym.QualityOfService(reliability="reliable")
    topic = sym.TopicChannel(id=f"T{number}", topic=f"/t{number}", publishers=[writer], subscribers=[reader])
    model.channels.append(topic)


def keys(findings: list[Finding]) -> set[Key]:
    return {(each.rule, each.elements) for each in findings if each.severity != "note"}


def found(length: int, faults: frozenset[Fault]) -> set[Key]:
    report = check(chain(length, faults))
    assert not report.unknown
    return keys(report.findings)


def fault_of(finding: Finding) -> Fault | None:
    """Return the fault that is a cause, by its rule and the number in the names of its elements."""
    kind = next((kind for kind, rule in KINDS.items() if rule == finding.rule), None)
    digits = "".join(each for each in finding.elements[0] if each.isdigit())
    return None if kind is None else (kind, int(digits))


@pytest.mark.long
@pytest.mark.parametrize("seed", range(6))
def test_consequences_are_what_is_gone_with_their_cause(seed: int) -> None:
    chance = Random(seed)
    length = chance.randint(2, 3)
    every = [(kind, number) for kind in KINDS for number in range(1, length + 1)]
    faults = frozenset(chance.sample(every, chance.randint(1, 3)))
    model = chain(length, faults)
    budget = Budget(seconds=600).begun()
    report = check(model, budget)
    before = keys(report.findings)
    found_causes = [each for each in report.findings if fault_of(each) in faults]
    fold_consequences(model, report, budget)
    listed = {fault_of(each): keys(list(each.consequences)) for each in report.findings if each.consequences}
    assert None not in listed
    # A fault that another one hides is found only where that one is fixed.
    known = {fault_of(each): (each.rule, each.elements) for each in found_causes}
    alone = {fault: before - found(length, faults.difference({fault})) for fault in known}
    together = before - found(length, faults.difference(known)) - set().union(*alone.values())
    causes = set(known.values())
    for fault in known:
        expected = {key for key in alone[fault] if key not in causes}
        more = listed.get(fault, set()) - expected
        assert expected <= listed.get(fault, set())
        assert more <= together, fault
    for cause in report.findings:
        for each in cause.consequences:
            if each.together:
                needed = {fault_of(cause), *map(fault_of, each.together)}
                assert (each.rule, each.elements) not in found(length, faults.difference(needed))
    folded = set().union(*listed.values()) if listed else set()
    assert together - causes <= folded
    assert keys(report.findings) == before - folded
