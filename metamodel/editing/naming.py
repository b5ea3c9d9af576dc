"""Default ids of new objects: readable, and unique in the model."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Mapping

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.editing.commands import CommandError, Value
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.editing.values import checked_id


def new_id(used: set[str], stem: str) -> str:
    """Return an unused id, and mark it as used: the stem, or the stem with the next number.

    Examples
    --------
    >>> used = {"Words", "Words2", "P7"}
    >>> new_id(used, "Words"), new_id(used, "Words2"), new_id(used, "P7"), new_id(used, "Said")
    ('Words3', 'Words4', 'P8', 'Said')
    """
    ending = re.search(r"[0-9]{1,6}$", stem)
    begin, first = (stem[: ending.start()], int(ending[0]) + 1) if ending else (stem, 2)
    numbered = (f"{begin}{number}" for number in itertools.count(first))
    found = next(each for each in itertools.chain([stem], numbered) if each not in used)
    used.add(found)
    return found


def used_ids(root: EObject) -> set[str]:
    """Return all ids of a model."""
    return {each.id for each in subtree(root) if isinstance(each, pn.Element) and each.id}


def default_id(
    used: set[str],
    cls: type[EObject],
    owner: EObject,
    values: Mapping[str, Value],
    find: Callable[[str], EObject],
) -> str:
    """Return the id of a new object without a given id.

    An arc is named after its ends, as in `dineros.metamodel.build`; a reference after its target and its
    page; other objects after their class.

    Parameters
    ----------
    used : set of str
        All ids of the model.
    cls : type of EObject
        The class of the object.
    owner : EObject
        Its container.
    values : mapping of str to Value
        Its attributes and references.
    find : callable
        Returns the target of a reference, by its handle.
    """

    def called(feature: str) -> str:
        value = values.get(feature)
        try:
            return getattr(find(value), "id", None) or "" if isinstance(value, str) else ""
        except CommandError:
            return ""  # the error is reported when the reference is set

    stem = ""
    if issubclass(cls, pn.Arc):
        kind = values.get("kind") or "normal"
        stem = f"{called('source')}-{called('target')}" + ("" if kind == "normal" else f"-{kind}")
    elif issubclass(cls, (pn.ReferencePlace, pn.ReferenceTransition)):
        stem = f"{called('target')}@{getattr(owner, 'id', '')}"
    if stem:
        try:
            return checked_id(new_id(used, stem))
        except CommandError:
            pass  # ids in external files may be unusual, or very long
    numbered = (f"{cls.__name__}{number}" for number in itertools.count(1))
    return next(each for each in numbered if each not in used)
