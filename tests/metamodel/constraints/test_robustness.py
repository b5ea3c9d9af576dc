"""No model, however broken, makes a constraint fail instead of reporting."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import elements
from tests.support.broken.small import flat, plain, runtime, system
from tests.support.vandalism import vandalise

MAKERS = [plain, system, runtime, flat]


@pytest.mark.long
@settings(max_examples=100)
@given(st.data())
def test_reports_instead_of_failing(data: st.DataObject) -> None:
    net = data.draw(st.sampled_from(MAKERS))().net
    for _ in range(data.draw(st.integers(1, 6))):
        vandalise(data.draw, net)
    for violation in validate(net):
        assert "\n" not in str(violation)


def test_signals_without_ids_are_reported() -> None:
    net = system().net
    signals = [element for element in elements(net) if isinstance(element, sym.InputSignal)]
    for signal in signals:
        signal.id = None  # type: ignore[assignment]
    assert signals
    assert validate(net)


def test_deep_pages() -> None:
    net = pn.Net(id="deep")
    page = pn.Page(id="p0", net=net)
    for number in range(1, 200):
        page = pn.Page(id=f"p{number}", page=page)
    pn.Place(id="bottom", tokens=-1, page=page)
    assert [violation.constraint for violation in validate(net)] == ["tokens-not-negative"]


def test_long_chains_of_references() -> None:
    net = pn.Net(id="chain")
    pages = [pn.Page(id=f"page{number}", net=net) for number in range(2)]
    node: pn.PlaceNode = pn.Place(id="end", page=pages[1])
    for number in range(3000):
        node = pn.ReferencePlace(id=f"r{number}", target=node, page=pages[number % 2])
    assert validate(net) == []
