"""The certificate of a flattened net fails loudly when the net is not what the rules guarantee."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from case_study.build import build
from dineros.metamodel import pn, pnm
from dineros.metamodel.elements import find, places
from dineros.transformations.flattening import flatten as flattening
from dineros.transformations.flattening.certificate import CertificateError, check_certificate
from dineros.transformations.language.patterns import Made, Node
from dineros.transformations.language.rule import Rule
from dineros.transformations.rules.notation import arc, place, transition
from dineros.transformations.rules.topics import T1, T2

QUEUE = "RightCellObjects.publisher.SortGreen"


@pytest.fixture
def net() -> pnm.PetriNetModel:
    return flattening.flatten(build(), "input-enabled").net


def drop_arc(net: pn.Net, id: str) -> None:
    net.pages[0].arcs.remove(find(net, id, pn.Arc))


def test_the_net_as_it_is_has_its_certificate(net: pnm.PetriNetModel) -> None:
    check_certificate(net)

    assert len(net.certificate) > 40


# (what is wrong, the invariant named, the transition named)
FAULTS: list[tuple[str, Callable[[pn.Net], None], str, str | None]] = [
    (
        "arc of a queue dropped",
        lambda net: drop_arc(net, f"{QUEUE}.in-{QUEUE}.Load"),
        f"{QUEUE}.Load + {QUEUE}.Capacity",
        f"{QUEUE}.in",
    ),
    (
        "heavier arc of a queue",
        lambda net: setattr(find(net, f"{QUEUE}.out-{QUEUE}.Capacity", pn.Arc), "weight", 2),
        f"{QUEUE}.Load + {QUEUE}.Capacity",
        f"{QUEUE}.out",
    ),
    (
        "token in a queue",
        lambda net: setattr(find(net, f"{QUEUE}.Load", pn.Place), "tokens", 1),
        f"{QUEUE}.Load + {QUEUE}.Capacity",
        None,
    ),
    (
        "instance that stays active",
        lambda net: drop_arc(net, "Pick.client.L.return[1]-Pick[1].inactive"),
        "Pick[1].active or inactive",
        "Pick.client.L.return[1]",
    ),
    (
        "two active instances",
        lambda net: setattr(find(net, "Pick[2].active", pn.Place), "tokens", 1),
        "Pick[2].active or inactive",
        None,
    ),
    (
        "client with two requests",
        lambda net: setattr(find(net, "Pick.client.L.ready", pn.Place), "tokens", 2),
        "Pick.client.L.ready or one request under way",
        None,
    ),
    (
        "request that stays in use",
        lambda net: drop_arc(net, "Pick.client.L.inUse[2]-Pick.client.L.return[2]"),
        "Pick.client.L.ready or one request under way",
        "Pick.client.L.return[2]",
    ),
    (
        "signal that is true and false",
        lambda net: setattr(find(net, "Danger.true", pn.Place), "tokens", 1),
        "Danger.true or false",
        None,
    ),
    (
        "signal that never becomes false",
        lambda net: drop_arc(net, "Danger.toFalse.TStop-Danger.false"),
        "Danger.true or false",
        "Danger.toFalse.TStop",
    ),
    (
        "true literal that is not counted",
        lambda net: drop_arc(net, "Danger.toTrue.TStop-TStop.D1"),
        "TStop.D1 counts true literals",
        "Danger.toTrue.TStop",
    ),
    (
        "arc of another kind",
        lambda net: setattr(find(net, "Danger.toTrue.TStop-Danger.true", pn.Arc), "kind", "inhibitor"),
        "Danger.true or false",
        "Danger.toTrue.TStop",
    ),
]


@pytest.mark.long
@pytest.mark.parametrize(
    ("fault", "invariant", "element"), [fault[1:] for fault in FAULTS], ids=[f[0] for f in FAULTS]
)
def test_a_sabotaged_net_is_refused(
    net: pnm.PetriNetModel, fault: Callable[[pn.Net], None], invariant: str, element: str | None
) -> None:
    fault(net)

    with pytest.raises(CertificateError) as caught:
        check_certificate(net)

    assert repr(invariant) in caught.value.message
    assert caught.value.element == element
    assert "\n" not in str(caught.value)


def test_every_arc_of_a_certified_place_matters(net: pnm.PetriNetModel) -> None:
    certified = {term.place for invariant in net.certificate for term in invariant.terms}
    page = net.pages[0]
    for joint in list(page.arcs)[::7]:
        if joint.kind != pn.ArcKind.normal or not certified & {joint.source, joint.target}:
            continue
        page.arcs.remove(joint)
        with pytest.raises(CertificateError):
            check_certificate(net)
        page.arcs.append(joint)
    check_certificate(net)


def test_every_token_of_a_certified_place_matters(net: pnm.PetriNetModel) -> None:
    certified = {term.place for invariant in net.certificate for term in invariant.terms}
    for each in places(net):
        each.tokens += 1
        if each in certified:
            with pytest.raises(CertificateError):
                check_certificate(net)
        else:
            check_certificate(net)
        each.tokens -= 1


def test_a_rule_that_breaks_what_others_guarantee_is_found_when_flattening() -> None:
    class Leak(Rule):
        """Takes a token out of a publisher's queue without returning its capacity."""

        queue = Made(T2.queue)
        load = Node(pn.Place, of=queue.load)
        leak = transition("{load.id}.leak")
        arcs = [arc(load, leak)]

        lhs = [queue, load]
        rhs = [*lhs, leak, *arcs]

    with pytest.raises(CertificateError) as caught:
        flattening.flatten(build(), "none", extra=[Leak])

    assert caught.value.element is not None and caught.value.element.endswith(".leak")


def test_a_rule_that_adds_beside_them_keeps_the_certificate() -> None:
    class Counter(Rule):
        """Counts what is sent on a topic."""

        transport = Made(T1.transport)
        sent = place("{transport.id}.sent")
        arcs = [arc(transport, sent)]

        lhs = [transport]
        rhs = [*lhs, sent, *arcs]

    flattened = flattening.flatten(build(), "none", extra=[Counter])

    assert [link.target.id for link in flattened.trace.role("Counter", "sent")] == [
        "LeftCellObjects.transport.sent",
        "RightCellObjects.transport.sent",
        "UITopic.transport.sent",
    ]
