"""What goes with objects that are deleted: their parts, and whatever cannot be without them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

from dineros.metamodel import sym
from dineros.metamodel.base import EObject
from dineros.metamodel.constraints.wording import describe
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.files.schema import Kind, class_of


def referrers(root: EObject) -> dict[EObject, list[tuple[EObject, str]]]:
    """Return for each object of a model which references, that files hold, lead to it."""
    found: dict[EObject, list[tuple[EObject, str]]] = defaultdict(list)
    for element in subtree(root):
        for name, feature in class_of(element).features.items():
            if feature.kind is Kind.REFERENCE and element.eIsSet(name):
                value = getattr(element, name)
                targets = value if feature.many else [value] if value is not None else []
                for target in targets:
                    found[target].append((element, name))
    return found


def closure(root: EObject, chosen: Iterable[EObject]) -> list[EObject]:
    """Return the outermost objects to be taken away so that the chosen ones are gone and nothing lacks them.

    Who needs an object by a mandatory reference goes too, and so does the owner of a mandatory part.

    Raises
    ------
    CommandError
        The model itself would have to go, or a clause speaks of a signal.
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
    """A signal stays while clauses speak of it: without it, their text and their normal form would differ."""
    for element in gone:
        if not isinstance(element, sym.InputSignal):
            continue
        for literal, _ in leading[element]:
            clause = literal.eContainer()
            clause = clause.eContainer() if clause is not None else None
            transition = clause.eContainer() if clause is not None else None
            if transition is not None and transition not in gone:
                raise CommandError(
                    f"the clause of {describe(transition)} speaks of {describe(element)}",
                    hint="change the clause first",
                )
