"""Building models: arcs, steps, and references to places of other pages."""

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, flow, here, inhibit, node_net, place, read, step
from dineros.metamodel.errors import ClauseError, DinerosError


def test_flow_read_and_inhibit() -> None:
    page = pn.Page(id="page")
    before, step, after = (
        pn.Place(id="a", page=page),
        pn.Transition(id="t", page=page),
        pn.Place(id="b", page=page),
    )
    flow(before, step, after, weight=2)
    read(after, step)
    inhibit(after, step, weight=3)
    assert [(arc.id, str(arc.kind), arc.weight) for arc in page.arcs] == [
        ("a-t", "normal", 2),
        ("t-b", "normal", 2),
        ("b-t-read", "read", 1),
        ("b-t-inhibitor", "inhibitor", 3),
    ]


def test_flow_between_pages_is_refused() -> None:
    place, transition = pn.Place(id="p", page=pn.Page(id="x")), pn.Transition(id="t", page=pn.Page(id="y"))
    with pytest.raises(DinerosError, match=r"are not on the same page.*reference place"):
        flow(place, transition)


def test_a_step_takes_and_puts_in_the_order_that_is_given() -> None:
    net = node_net(sym.SystemModel(id="yard"), "dock", ["Open", "Lit"], package="yard_dock")
    ship, free, moored = place(net, "Ship"), place(net, "Free", tokens=2), place(net, "Moored")
    moor = step(net, "Moor", [ship, free], [moored], clause="Open & !Lit")
    assert [(arc.source, arc.target) for arc in net.arcs] == [(ship, moor), (free, moor), (moor, moored)]
    assert moor.clause is not None and moor.clause.text == "Open & !Lit"
    assert (net.package, [signal.id for signal in net.signals], free.tokens) == (
        "yard_dock",
        ["Open", "Lit"],
        2,
    )


def test_a_step_refers_once_to_each_place_of_another_page() -> None:
    net = node_net(sym.SystemModel(id="yard"), "dock")
    free, page = place(net, "Free"), callback(net, "OnShip", "timer", timer=0.5)
    take, give = step(page, "Take", [free]), step(page, "Give", puts=[free])
    (reference,) = (each for each in page.objects if isinstance(each, pn.ReferencePlace))
    assert (reference.id, reference.name, reference.target) == ("Free@OnShip", "Free", free)
    assert [arc.source for arc in take.incoming] == [arc.target for arc in give.outgoing] == [reference]
    assert here(free, page) is reference
    assert here(free, net) is free
    assert (page.kind, page.timer, page.page) == (sym.CallbackKind.timer, 0.5, net)


def test_a_clause_of_a_signal_that_the_node_net_has_not_is_refused() -> None:
    net = node_net(sym.SystemModel(id="yard"), "dock", ["Open"])
    with pytest.raises(ClauseError, match="Opened"):
        step(net, "Moor", clause="Opened")


def test_a_node_net_says_how_it_runs() -> None:
    model = sym.SystemModel(id="yard")
    life = sym.Lifecycle(deactivates=True)
    made = node_net(model, "dock", namespace="/left", execution="callbacks", threads=3, lifecycle=life)
    assert (made.namespace, str(made.execution), str(made.executor), made.threads) == (
        "/left",
        "callbacks",
        "multi",
        3,
    )
    assert made.lifecycle is life
    plain = node_net(model, "pier")
    assert (plain.namespace, str(plain.execution), str(plain.executor), plain.threads, plain.lifecycle) == (
        None,
        "net",
        "single",
        1,
        None,
    )
