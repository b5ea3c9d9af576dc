"""Deletion of objects: with their parts, and with all objects that require them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses import signal_names
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing.changes import Change, Inserted, Removed
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.elements import is_within, label, node_net_of
from dineros.metamodel.files.schema import Kind, class_of, values_of


def referrers(root: EObject) -> dict[EObject, list[tuple[EObject, str]]]:
    """Return for each object of a model the stored references to it."""
    found: dict[EObject, list[tuple[EObject, str]]] = defaultdict(list)
    for element in subtree(root):
        for name, feature in class_of(element).features.items():
            if feature.kind is Kind.REFERENCE and element.eIsSet(name):
                for target in values_of(element, feature):
                    found[target].append((element, name))
    return found


def closure(root: EObject, chosen: Iterable[EObject]) -> list[EObject]:
    """Return the outermost objects to delete, so that the chosen objects are deleted and none is missing.

    Objects with a required reference to a deleted object are deleted, too, and so are the containers of
    required parts.

    Raises
    ------
    CommandError
        The model itself would have to be deleted, or a clause uses a signal.
    """
    leading = referrers(root)
    gone: dict[EObject, None] = {}
    outermost: dict[EObject, None] = {}
    waiting = list(chosen)[::-1]
    while waiting:
        element = waiting.pop()
        if element in gone:
            continue
        owner = element.eContainer()
        if element is root or owner is None:
            raise CommandError("the model itself cannot be deleted")
        outermost[element] = None
        for part in subtree(element):
            gone[part] = None
            outermost.pop(part, None) if part is not element else None
        for part in subtree(element):
            waiting += [
                other for other, name in leading[part] if other not in gone and _needs(other, name, gone)
            ]
        feature = class_of(owner).features[element.eContainmentFeature().name]
        if feature.required and owner not in gone and _is_emptied(owner, feature.name, feature.many, gone):
            waiting.append(owner)
    _refuse_clauses(gone, leading)
    return list(outermost)


def _needs(other: EObject, name: str, gone: dict[EObject, None]) -> bool:
    feature = class_of(other).features[name]
    return feature.required and _is_emptied(other, name, feature.many, gone)


def _is_emptied(owner: EObject, name: str, many: bool, gone: dict[EObject, None]) -> bool:
    value = getattr(owner, name)
    return all(each in gone for each in value) if many else value in gone


def _refuse_clauses(gone: dict[EObject, None], leading: dict[EObject, list[tuple[EObject, str]]]) -> None:
    """Refuse to delete a signal used in clauses: their text and their normal form would differ."""
    for element in gone:
        if not isinstance(element, sym.InputSignal):
            continue
        for literal, _ in leading[element]:
            clause = literal.eContainer()
            clause = clause.eContainer() if clause is not None else None
            transition = clause.eContainer() if clause is not None else None
            if transition is not None and transition not in gone:
                raise CommandError(
                    f"the clause of {describe(transition)} refers to {describe(element)}",
                    hint="change the clause first",
                )


def check_clauses(changes: Sequence[Change], root: EObject) -> None:
    """Refuse changes after which a clause uses a signal that its ROS node does not have.

    Such a clause cannot be read again; its normal form may not even have a literal for the signal.

    Raises
    ------
    CommandError
        The message names the transition and the signal.
    """
    moved = {
        part
        for change in changes
        if isinstance(change, Inserted | Removed)
        and class_of(change.element).features[change.feature].kind is Kind.CONTAINMENT
        for part in subtree(change.value)
    }
    nets = {
        node_net_of(change.element)
        for change in changes
        if isinstance(change, Removed) and isinstance(change.value, sym.InputSignal)
    }
    beside = (part for net in nets if net is not None and is_within(net, root) for part in subtree(net))
    for transition in dict.fromkeys([*moved, *beside]):
        if (
            not isinstance(transition, sym.Transition)
            or transition.clause is None
            or not is_within(transition, root)
        ):
            continue
        node_net = node_net_of(transition)
        known = {label(signal): signal for signal in node_net.signals} if node_net is not None else {}
        spoken = [literal.signal for each in transition.clause.disjunctions for literal in each.literals]
        lost = [name for name in signal_names(transition.clause.text) if name not in known]
        lost += [label(signal) for signal in spoken if known.get(label(signal)) is not signal]
        if lost:
            raise CommandError(
                f"the clause of {describe(transition)} refers to the signal {lost[0]!r}",
                hint="change the clause first; signals belong to one ROS node",
            )
