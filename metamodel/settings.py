"""Changing a model by text such as ``RedObjects.tokens=2``: what ``--set`` of the command line does.

==========================================  =========================================================
``RedObjects.tokens=2``                     an attribute of the element with that id, or unique name
``LeftCell.publisher.SortRed.limit=5``      a port of a channel, by its place (also ``subscriber``)
``LeftCell.dispatcher.controller.limit=8``  what a node net buffers of a topic; made where it is absent
``LeftCell.qos.reliability=bestEffort``     quality of service; made where it is absent
``LeftCell.publisher.SortRed.qos.deadline=1``  that of a port; made as its topic's where it is absent
``middleware=ros2``                         the rules that flatten a system model
``OnTimer.group=calls``                     the callback group of a callback page; made where it is absent
``Pick.client.left.timeout=2.5``            a client of a service, by its name; its group is set alike
``camera.lifecycle.deactivates=true``        the lifecycle of a node net; made where it is absent
``Move.interval.latest=2.5``                firing time of a transition; made where it is absent
``OnTimer.duration.latest=0.05``            what a callback takes; offset, latency and reaction are set alike
``times.latency.latest=0.01``               the default of all latencies; of durations and reactions alike
``SortingToken.field.color.default="red"``  a field of a token type, by its name
``NoCollision.text=never A >= 2``           a property of the model, or an assumption
``TStop.clause=Danger & !RobotIsIdle``      the input clause of a transition; no text removes it
==========================================  =========================================================

A channel also answers to its topic, service or action. If the names of elements contain dots, the longest
that fits is meant. Ids and other references cannot be set. An empty text removes the value of a feature
that has no default: ``Pick.instances=``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from types import UnionType
from typing import Any, TypeVar

from pyecore.ecore import EAttribute, EEnum

from dineros.metamodel import elements, pn, sym
from dineros.metamodel.base import EObject, features_of
from dineros.metamodel.errors import (
    DinerosError,
    FeatureValueError,
    UnknownElementError,
    UnknownFeatureError,
    near_matches,
    with_article,
)
from dineros.metamodel.files.exact import exact_number

Value = str | int | float | bool | None
_Grouped = sym.CallbackPage | sym.ClientPort | sym.ActionClientPort
T = TypeVar("T")

_PARTS: dict[str, Callable[[], EObject]] = {
    "qos": sym.QualityOfService,
    "interval": pn.TimeInterval,
    "duration": pn.TimeInterval,
    "offset": pn.TimeInterval,
    "latency": pn.TimeInterval,
    "reaction": pn.TimeInterval,
    "times": sym.DefaultTimes,
    "lifecycle": sym.Lifecycle,
}


_CALLED = ("topic", "service", "action")
"""What channels answer to besides their names."""


class SettingError(DinerosError):
    """A text is not of the form ``ELEMENT.FEATURE=VALUE``."""


def apply(model: pn.Net, setting: str) -> None:
    """Change one attribute, or one input clause, of a model in place.

    Parameters
    ----------
    model : pn.Net
        A model of any kind; it is not validated here.
    setting : str
        ``ELEMENT.FEATURE=VALUE``, in one of the forms above.

    Raises
    ------
    SettingError
        The text has another form.
    UnknownElementError
        No element has the name, or several have it.
    UnknownFeatureError
        The element has no such attribute, or it cannot be set.
    FeatureValueError
        The value does not fit the attribute's type.
    ClauseError
        The value is not an expression over signals of the transition's node net.
    """
    if re.match(r"middleware=|times\.(latency|duration|reaction)\.", setting):
        _set_of_model(model, setting)
        return
    if not re.search(r".\.[^.=]+=", setting):
        raise SettingError(
            f"{setting!r} is not of the form ELEMENT.FEATURE=VALUE", hint="for example RedObjects.tokens=2"
        )
    element, rest = _element(model, setting)
    path, _, value = rest.partition("=")
    try:
        if path == "clause" and isinstance(element, sym.Transition):
            _set_clause(element, value)
        else:
            _set(element, path, value.strip())
    except DinerosError as error:
        error.message = f"{setting.partition('=')[0]}: {error.message}"
        error.element = element.id
        raise


def _set_of_model(model: pn.Net, setting: str) -> None:
    if not isinstance(model, sym.SystemModel):
        raise UnknownFeatureError(
            f"{setting.partition('=')[0]}: the model is not a system model", hint="leave it out"
        )
    _set(model, *map(str.strip, setting.split("=", 1)))


def _element(model: pn.Net, setting: str) -> tuple[pn.Element, str]:
    """Return the element that a setting begins with, and the rest of the text behind the dot."""
    by_id: dict[str, pn.Element] = {}
    by_name: dict[str, list[pn.Element]] = {}
    for element in elements.named_elements(model):
        if element.id:
            by_id.setdefault(element.id, element)
        for name in {
            element.name,
            *(getattr(element, each, None) for each in ("topic", "service", "action")),
        }:
            if name:
                by_name.setdefault(name, []).append(element)
    for dot in reversed([found.start() for found in re.finditer(r"\.", setting)]):
        name, rest = setting[:dot], setting[dot + 1 :]
        if "=" not in rest:
            continue
        if name in by_id:
            return by_id[name], rest
        if name in by_name:
            return _only(by_name[name], name), rest
    path = setting.partition("=")[0]
    name = re.split(rf"\.(?:{'|'.join([*_KEYED, *_PARTS])})\.", path)[0]
    if name == path:
        name = path.rpartition(".")[0]
    raise UnknownElementError(
        f"{path}: no element has the id or name {name!r}", hint=near_matches(name, {**by_id, **by_name})
    )


def _only(found: list[pn.Element], name: str) -> pn.Element:
    if len(found) > 1:  # references often bear the name of what they refer to
        references = (pn.ReferencePlace, pn.ReferenceTransition)
        found = [element for element in found if not isinstance(element, references)] or found
    if len(found) > 1:
        ids = " or ".join(repr(element.id) for element in found[:4])
        raise UnknownElementError(f"{len(found)} elements have the name {name!r}", hint=f"use an id: {ids}")
    return found[0]


def _set(owner: EObject, path: str, text: str) -> None:
    """Follow the steps of a path, such as ``publisher.SortRed.limit``, and set the attribute at its end."""
    step, _, rest = path.partition(".")
    if rest and step in _PARTS and step in features_of(type(owner)):
        part = getattr(owner, step) or _part(owner, step)
        _set(part, rest, text)
        setattr(owner, step, part)
    elif rest and step in _KEYED and isinstance(owner, _KEYED[step][0]):
        key, feature = _key(rest)
        part = _KEYED[step][1](owner, key)
        _set(part, feature, text)
        if isinstance(part, sym.Dispatcher) and isinstance(owner, sym.TopicChannel):
            part.channel = owner
    elif path == "group" and isinstance(owner, _Grouped):
        owner.group = _group(owner, text) if text else None
    else:
        _set_attribute(owner, path, text)


def _group(owner: _Grouped, id: str) -> sym.CallbackGroup:
    """Return the callback group with an id of the node net that a callback page or a client belongs to."""
    asks = owner.request if isinstance(owner, sym.ClientPort) else getattr(owner, "goal", owner)
    node = elements.node_net_of(asks)
    if node is None or node.net is None:
        raise UnknownElementError("is not in a node net, which has callback groups", hint="leave it out")
    for group in node.callbackGroups:
        if group.id == id:
            return group
    other = next((element for element in elements.elements(node.net) if element.id == id), None)
    if other is not None:
        raise FeatureValueError(
            f"takes a callback group of {node.id}, and {id!r} is {_kind(other)} that is not one of them",
            hint=f"known here: {', '.join(str(group.id) for group in node.callbackGroups) or 'none'}",
        )
    made = sym.CallbackGroup(id=id)
    node.callbackGroups.append(made)
    return made


def _part(owner: EObject, step: str) -> EObject:
    """Make a part that is absent; a port's quality of service begins as its topic's."""
    part = _PARTS[step]()
    channel = owner.eContainer() if isinstance(owner, sym.TopicPort) else None
    if isinstance(channel, sym.TopicChannel) and channel.qos is not None:
        for name in features_of(sym.QualityOfService):
            setattr(part, name, getattr(channel.qos, name))
    return part


def _key(path: str) -> tuple[str, str]:
    """Split the part after ``publisher.``: the key of a port, and its feature or that of its part."""
    key, _, feature = path.rpartition(".")
    inner, _, step = key.rpartition(".")
    if inner and step in _PARTS and feature in features_of(_PARTS[step]):  # type: ignore[arg-type]
        return inner, f"{step}.{feature}"
    return key, feature


def _set_attribute(owner: EObject, name: str, text: str) -> None:
    feature = features_of(type(owner)).get(name)
    if not isinstance(feature, EAttribute) or feature.iD:
        known = _known(owner)
        problem = "cannot be set" if feature is not None else f"is not a feature of {_kind(owner)}"
        hint = near_matches(name, known) or f"known here: {', '.join(known) or 'none'}"
        if feature is not None and name in _PARTS:
            inner = features_of(_PARTS[name])  # type: ignore[arg-type]
            hint = "set " + " or ".join(f"{name}.{each}" for each in list(inner)[:2])
        raise UnknownFeatureError(f"{name!r} {problem}", hint=hint)
    value = _value(feature, text)
    setattr(owner, name, value)
    if name == "tokens" and isinstance(owner, sym.Place) and isinstance(value, int) and value >= 0:
        for surplus in list(owner.balloons)[value:]:  # the data of tokens that are no more
            owner.balloons.remove(surplus)


def _known(owner: EObject) -> list[str]:
    """Return what may stand behind an element's name, as the hints of errors show it."""
    features = features_of(type(owner))
    attributes = [
        name for name, feature in features.items() if isinstance(feature, EAttribute) and not feature.iD
    ]
    clause = ["clause"] if isinstance(owner, sym.Transition) else []
    parts = [name for name in _PARTS if name in features]
    keyed = [name for name, (kind, _) in _KEYED.items() if isinstance(owner, kind)]
    group = ["group"] if isinstance(owner, _Grouped) else []
    return [*attributes, *clause, *parts, *keyed, *group]


def _set_clause(transition: sym.Transition, text: str) -> None:
    from dineros.metamodel.clauses import remove_clause, set_clause

    if text.strip():
        set_clause(transition, text, transition.clause.name if transition.clause else None)
    else:
        remove_clause(transition)


def _value(feature: Any, text: str) -> Value:
    """Read a value by the type of its feature."""
    if not text and feature.lower == 0 and feature.get_default_value() is None:
        return None
    kind = feature._eType
    if isinstance(kind, EEnum):
        return text  # checked, with near matches, when it is set
    expected, read = _READERS[kind.name]
    try:
        return read(text)
    except (KeyError, ValueError):
        shown = text if len(text) <= 40 else f"{text[:40]}..."
        raise FeatureValueError(f"takes {expected}, not {shown!r}") from None


def _integer(text: str) -> int:
    if not re.fullmatch(r"[+-]?[0-9]{1,18}", text):
        raise ValueError(text)
    return int(text)


def _number(text: str) -> float:
    return exact_number(text)


def _boolean(text: str) -> bool:
    return {"true": True, "false": False}[text.lower()]


_READERS: dict[str, tuple[str, Callable[[str], Value]]] = {
    "EInt": ("a whole number", _integer),
    "EIntegerObject": ("a whole number", _integer),
    "EDouble": ("a number", _number),
    "EDoubleObject": ("a number", _number),
    "EBoolean": ("true or false", _boolean),
    "EString": ("a text", str),
}


def _kind(owner: EObject) -> str:
    return with_article(type(owner).__name__)


def _part_of(
    role: str, feature: str, named: Callable[[Any], object] = lambda part: part
) -> Callable[[EObject, str], EObject]:
    return lambda owner, key: _keyed(role, key, getattr(owner, feature), named)


def _dispatcher(channel: sym.TopicChannel, key: str) -> EObject:
    node_nets = {elements.node_net_of(port.place) for port in channel.subscribers}
    node_nets |= {dispatcher.node for dispatcher in channel.dispatchers}
    node = _keyed("subscribing node net", key, node_nets, lambda found: found)
    assert isinstance(node, sym.NodeNet)
    here = [dispatcher for dispatcher in channel.dispatchers if dispatcher.node is node]
    return here[0] if here else sym.Dispatcher(node=node)


_KEYED: dict[str, tuple[type[EObject] | UnionType, Callable[[Any, str], EObject]]] = {
    "publisher": (sym.TopicChannel, _part_of("publisher", "publishers", lambda port: port.place)),
    "subscriber": (sym.TopicChannel, _part_of("subscriber", "subscribers", lambda port: port.place)),
    "dispatcher": (sym.TopicChannel, _dispatcher),
    "client": (sym.ServiceChannel | sym.ActionChannel, _part_of("client", "clients")),
    "field": (sym.TokenType, _part_of("field", "fields")),
}
"""Whose parts a setting names by a key, and what finds them."""


def _keyed(role: str, key: str, candidates: Iterable[T], named: Callable[[T], object]) -> T:
    """Return the candidate whose namesake has the id or client `key`, else the only one of the name `key`."""
    names: dict[str, list[T]] = {}
    for feature in ("id", "client", "name"):
        found: dict[str, list[T]] = {}
        for candidate in candidates:
            name = getattr(named(candidate), feature, None)
            if name:
                found.setdefault(name, []).append(candidate)
        names = {**found, **names}
    if len(names.get(key, [])) == 1:
        return names[key][0]
    if key in names:
        raise UnknownElementError(f"{len(names[key])} have the name {key!r}", hint="use an id")
    known = near_matches(key, names) or (f"known here: {', '.join(sorted(names))}" if names else None)
    raise UnknownElementError(f"there is no {role} {key!r}", hint=known)
