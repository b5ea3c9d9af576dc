"""Copies elements of this model or of another one, by commands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses import signal_names
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing import commands as c
from dineros.metamodel.editing.handles import Handles, subtree
from dineros.metamodel.editing.naming import new_id, used_ids
from dineros.metamodel.editing.offered import classes_for, name_of
from dineros.metamodel.editing.renaming import replaced
from dineros.metamodel.elements import is_within, label, node_net_of
from dineros.metamodel.files.schema import Kind, class_of

_NAMES = ("topic", "service", "action")
"""Attributes of channels that must be unique in a model."""


class Copier:
    """Copies elements into a model.

    Parameters
    ----------
    root : pn.Net
        The model that gets the copies.
    handles : Handles
        Its handles.
    owner : EObject
        The page, or the model, that contains the copies; channels are put into the model.
    shift : pair of float
        Distance of the copies from the originals.
    """

    def __init__(self, root: pn.Net, handles: Handles, owner: EObject, shift: tuple[float, float]) -> None:
        self._root, self._handles, self._owner, self._shift = root, handles, owner, shift
        self._used = used_ids(root)
        self._called: dict[EObject, str] = {}
        self._ids: dict[str, str] = {}
        self._signals: set[str] = set()
        self._commands: list[c.Command] = []
        self._later: list[c.Command] = []
        self._shifted: set[EObject] = set()

    def copied(self, elements: Sequence[EObject]) -> list[c.Command]:
        """Return the commands that copy elements, including the arcs between them.

        Raises
        ------
        CommandError
            The owner cannot contain one of them.
        """
        chosen = _outermost(elements)
        inside = {part for element in chosen for part in subtree(element)}
        arcs = [each for each in _arcs_between(chosen, inside) if each not in inside]
        everything = [*chosen, *arcs]
        for number, element in enumerate(everything, 1):
            self._called[element] = f"$copy{number}"
        for element in everything:
            for part in subtree(element):
                self._called.setdefault(part, f"$part{len(self._called)}")
                self._name(part)
        for element in everything:
            if element.eContainer() is not None:
                self._shifted.add(element)
            self._make(element, *self._home(element))
        return [*self._commands, *self._later]

    def _home(self, element: EObject) -> tuple[str, str]:
        """Return the container of an element's copy, and the containment feature."""
        owners = [self._owner, self._root] if isinstance(element, sym.Channel) else [self._owner]
        former = element.eContainmentFeature()
        for owner in owners:
            features = class_of(owner).features
            names = [former.name] if former is not None and former.name in features else []
            for name in [*names, *features]:
                feature = features[name]
                if feature.kind is Kind.CONTAINMENT and feature.many and isinstance(element, feature.type):
                    return self._handles.of(owner) or "", name
        raise c.CommandError(f"{describe(self._owner)} cannot hold a copy of {describe(element)}")

    def _name(self, part: EObject) -> None:
        if isinstance(part, pn.Element) and part.id:
            self._ids[part.id] = self._new_id(part)

    def _new_id(self, part: pn.Element) -> str:
        if isinstance(part, pn.Arc):
            ends = [end.id for name in ("source", "target") if isinstance(end := _led(part, name), pn.Node)]
            if len(ends) == 2 and part.id.startswith("-".join(ends)):
                copied = "-".join(self._ids.get(each, each) for each in ends)
                return new_id(self._used, copied + part.id.removeprefix("-".join(ends)))
        return new_id(self._used, part.id)

    def _make(self, element: EObject, owner: str, feature: str) -> None:
        """Make a copy with its parts; references to objects that may not exist yet are made later."""
        cls = type(element)
        if isinstance(element, sym.InputClause):
            self._clause(element, owner)
            return
        if name_of(cls) not in classes_for(type(self._root)):
            raise c.CommandError(f"the model cannot hold {describe(element)}")
        called = self._called[element]
        values: dict[str, c.Value] = {}
        parts: list[tuple[str, EObject]] = []
        for name, information in class_of(element).features.items():
            if information.kind is Kind.NOT_STORED or not element.eIsSet(name):
                continue
            value = getattr(element, name)
            found = list(value) if information.many else [] if value is None else [value]
            if information.kind is Kind.CONTAINMENT:
                parts += [(name, each) for each in found]
            elif information.kind is Kind.ATTRIBUTE:
                values[name] = self._value(element, name, value)
            else:
                for each in found:
                    self._refer(called, name, each, information.many)
        self._commands.append(c.Create(owner, feature, name_of(cls), values, called=called))
        for name, part in parts:
            self._make(part, called, name)

    def _value(self, element: EObject, name: str, value: Any) -> c.Value:
        if name == "id":
            return self._ids[value]
        if name == "name" and isinstance(element, pn.Element) and value == element.id:
            return self._ids[value]  # the copies refer to each other as the originals do
        if isinstance(element, pn.Point) and name in ("x", "y") and self._is_shifted(element):
            return float(value) + self._shift[name == "y"]
        if isinstance(element, sym.Channel) and name in _NAMES:
            return new_id({str(getattr(each, name, "")) for each in self._channels()}, value)
        return value if isinstance(value, str | int | float | bool) else str(value)

    def _channels(self) -> list[sym.Channel]:
        return list(self._root.channels) if isinstance(self._root, sym.SystemModel) else []

    def _is_shifted(self, point: EObject) -> bool:
        """Return whether a point is a position on the page, or a bend point."""
        graphics = point.eContainer()
        return (
            graphics is not None
            and graphics.eContainer() in self._shifted
            and point.eContainmentFeature().name == "positions"
        )

    def _refer(self, called: str, name: str, target: EObject, many: bool) -> None:
        handle = self._called.get(target)
        if handle is None:
            handle = self._handles.of(target) if is_within(target, self._root) else None
        if handle is None:
            return  # deleted, or of another model; an object that requires it is refused
        self._later.append(c.Add(called, name, handle) if many else c.Set(called, name, handle))

    def _clause(self, clause: sym.InputClause, transition: str) -> None:
        node_net = node_net_of(clause)
        known = {label(each): each for each in node_net.signals} if node_net is not None else {}
        literals = (literal for disjunction in clause.disjunctions for literal in disjunction.literals)
        known |= {
            label(signal): signal
            for literal in literals
            if isinstance(signal := _led(literal, "signal"), sym.InputSignal)
        }
        spoken_of = [known[name] for name in signal_names(clause.text) if name in known]
        names = {label(signal): self._name_here(signal) for signal in spoken_of}
        self._later.append(c.Clause(transition, replaced(clause.text, names)))

    def _name_here(self, signal: sym.InputSignal) -> str:
        """Return the name of a signal's copy, or of the signal that replaces it here."""
        name = label(signal)
        if signal in self._called:
            return name if signal.name and signal.name != signal.id else self._ids[signal.id]
        node_net = node_net_of(self._owner)
        if node_net is not None and name not in self._signals | {label(each) for each in node_net.signals}:
            self._signals.add(name)
            values: dict[str, c.Value] = {
                "id": new_id(self._used, signal.id),
                "name": name,
                "initial": bool(signal.initial),
            }
            owner = self._handles.of(node_net) or ""
            self._commands.append(c.Create(owner, "signals", "sym.InputSignal", values))
        return name


def _led(element: EObject, name: str) -> object:
    """Return the target of a reference; for a deleted object, even a required one may have none."""
    return getattr(element, name)


def _outermost(elements: Sequence[EObject]) -> list[EObject]:
    """Return elements without those that are parts of others."""
    chosen = dict.fromkeys(elements)

    def is_part(element: EObject) -> bool:
        above = element.eContainer()
        while above is not None and above not in chosen:
            above = above.eContainer()
        return above is not None

    return [each for each in chosen if not is_part(each)]


def _arcs_between(chosen: Sequence[EObject], inside: set[EObject]) -> list[pn.Arc]:
    nodes = [each for each in chosen if isinstance(each, pn.Node)]
    found = (arc for node in nodes for arc in node.outgoing)
    return [arc for arc in dict.fromkeys(found) if arc.target in inside and arc.source in inside]
