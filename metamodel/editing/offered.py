"""The classes of objects that a model can contain: those of its metamodel, and of those that it extends."""

from __future__ import annotations

from typing import Any

from dineros.metamodel import pn, pnm, rtm, sym
from dineros.metamodel.base import EObject, remembered
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.errors import near_matches

_PACKAGES: dict[type[EObject], tuple[Any, ...]] = {
    pn.Net: (pn,),
    sym.SystemModel: (pn, sym),
    rtm.RuntimeModel: (pn, sym, rtm),
    pnm.PetriNetModel: (pn, sym, pnm),
}
_FOLLOWS = (sym.InputClause, sym.Disjunction, sym.Literal)
"""Classes of objects derived from the text of a clause, which are made with it."""

NOT_WITHIN: dict[type[EObject], type[EObject]] = {
    sym.NodeNet: sym.NodeNet,
    sym.CallbackPage: sym.CallbackPage,
}
"""Classes whose objects are not offered inside objects of another class, at any depth."""

ONLY_UNDER: dict[type[EObject], Any] = {sym.Dispatcher: sym.Middleware.ros1}
"""Classes whose objects are not offered under a middleware whose rules do not use them."""


def name_of(cls: type[EObject]) -> str:
    """Return the name of a class as commands write it, such as ``sym.Place``."""
    return f"{cls.eClass.ePackage.nsPrefix}.{cls.eClass.name}"


@remembered
def classes_for(root: type[EObject]) -> dict[str, type[EObject]]:
    """Return the classes of objects that a model of this class can contain, by name.

    If a class of a metamodel and a class of an extended one have the same name, only the latter is returned.
    """
    found: dict[str, type[EObject]] = {}
    value: Any
    for package in _PACKAGES.get(root, (pn,)):
        for value in package.eClassifiers.values():
            if not isinstance(value, type) or not issubclass(value, EObject) or issubclass(value, pn.Net):
                continue  # an enumeration, or another metamodel
            if not value.eClass.abstract:
                found[value.__name__] = value
    return {name_of(cls): cls for cls in found.values()}


def class_to_make(root: EObject, name: str) -> type[EObject]:
    """Return the class that a command names.

    Raises
    ------
    CommandError
        There is none, or its objects are made by other commands.
    """
    known = classes_for(type(root))
    cls = known.get(name)
    if cls is None:
        shown = name[:100]
        raise CommandError(
            f"an element of the class {shown!r} cannot be created here", hint=near_matches(shown, known)
        )
    if issubclass(cls, _FOLLOWS):
        raise CommandError(f"a {name} follows from the text of a clause", hint="use the command clause")
    return cls


def follows_from_text(element: EObject) -> bool:
    """Return whether an object belongs to the normal form of a clause."""
    return isinstance(element, (sym.Disjunction, sym.Literal))
