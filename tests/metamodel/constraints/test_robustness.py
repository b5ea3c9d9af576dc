"""No model, however broken, makes a constraint fail instead of reporting."""

from collections.abc import Callable
from contextlib import suppress
from typing import Any

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.constraints import validate
from dineros.metamodel.errors import DinerosError
from tests.support.broken.small import flat, plain, runtime, system

MAKERS = [plain, system, runtime, flat]
NASTY = [
    None,
    "",
    " ",
    "\x00",
    "{",
    "[1",
    "a & ",
    "a" * 300,
    -1,
    0,
    2**70,
    float("nan"),
    float("inf"),
    True,
    "list",
]


def everything(net: pn.Net) -> list[EObject]:
    return [net, *net.eAllContents()]


def vandalise(draw: Callable[..., Any], net: pn.Net) -> None:
    """Do one thing to a model that the typed API lets through."""
    element = draw(st.sampled_from(everything(net)))
    feature: Any = draw(st.sampled_from([*features_of(type(element)).values()]))
    values = getattr(element, feature.name)
    if feature.many:
        if len(values) and draw(st.booleans()):
            values.remove(draw(st.sampled_from(list(values))))
        return
    if hasattr(feature, "containment"):
        others = [other for other in everything(net) if not feature.containment and not feature.container]
        value: object = draw(st.sampled_from([None, *others]))
    else:
        value = draw(st.sampled_from(NASTY))
    with suppress(DinerosError):  # what the typed API refuses cannot be in a model
        setattr(element, feature.name, value)


@settings(max_examples=100)
@given(st.data())
def test_reports_instead_of_failing(data: st.DataObject) -> None:
    net = data.draw(st.sampled_from(MAKERS))().net
    for _ in range(data.draw(st.integers(1, 6))):
        vandalise(data.draw, net)
    for violation in validate(net):
        assert "\n" not in str(violation)


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
