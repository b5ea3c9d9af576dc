"""Breaking models: features set to bad values, references dropped or turned, elements moved."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any

from hypothesis import strategies as st

from dineros.metamodel import pn
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.errors import DinerosError

NASTY: list[object] = [
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


def vandalise(draw: Callable[..., Any], net: pn.Net, values: Sequence[object] = NASTY) -> None:
    """Do one thing to a model that the typed API lets through.

    Classes are equally likely, so that what a model has few of is hit as often as its arcs.
    """
    kinds: dict[str, list[EObject]] = {}
    for element in everything(net):
        kinds.setdefault(type(element).__name__, []).append(element)
    element = draw(st.sampled_from(kinds[draw(st.sampled_from(sorted(kinds)))]))
    feature: Any = draw(st.sampled_from(list(features_of(type(element)).values())))
    if feature.many:
        _move(draw, net, element, feature)
        return
    if hasattr(feature, "containment"):
        fitting = [other for other in everything(net) if _fits(other, feature)]
        others = [other for other in fitting if not feature.containment and not feature.container]
        value: object = draw(st.sampled_from([None, *others]))
    elif hasattr(feature.eType, "eLiterals"):
        value = draw(st.sampled_from([str(each) for each in feature.eType.eLiterals]))
    else:
        value = draw(st.sampled_from(list(values)))
    with suppress(DinerosError):  # what the typed API refuses cannot be in a model
        setattr(element, feature.name, value)


def _move(draw: Callable[..., Any], net: pn.Net, element: EObject, feature: Any) -> None:
    """Take an element out of a list, or put one into it that stood elsewhere."""
    values = getattr(element, feature.name)
    around = {element, *_containers(element)}
    fitting = [other for other in everything(net) if _fits(other, feature) and other not in around]
    if len(values) and draw(st.booleans()):
        values.remove(draw(st.sampled_from(list(values))))
    elif fitting:
        with suppress(DinerosError):
            values.append(draw(st.sampled_from(fitting)))


def _fits(value: EObject, feature: Any) -> bool:
    return isinstance(feature.eType, type) and isinstance(value, feature.eType)


def _containers(element: EObject) -> list[EObject]:
    found = []
    container = element.eContainer()
    while container is not None:
        found.append(container)
        container = container.eContainer()
    return found
