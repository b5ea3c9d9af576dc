"""Renaming everywhere: what speaks of an element by its name, not by a reference, is changed with it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses.expressions import KEYWORDS, quoted
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import decode_json


@dataclass(frozen=True)
class Rewriting:
    """A text that speaks of a name, and what it becomes."""

    element: EObject
    feature: str
    text: str


def rewritings(root: pn.Net, element: EObject, feature: str, value: str | None) -> list[Rewriting]:
    """Return which texts speak of an element that gets another name or id, and what they become.

    Parameters
    ----------
    root : pn.Net
        The model.
    element : EObject
        The element, which still has its name.
    feature : str
        What changes.
    value : str or None
        What it becomes.

    Raises
    ------
    CommandError
        The new name is one that something else beside it has, so that texts would become ambiguous.
    """
    if isinstance(element, sym.InputSignal) and feature in ("name", "id"):
        before = label(element)
        after = value or element.id if feature == "name" else element.name or value or ""
        return _clauses(element, before, after) if before != after else []
    if isinstance(element, sym.TokenField) and feature == "name" and value and value != element.name:
        return _token_data(root, element, element.name, value)
    return []


def _clauses(signal: sym.InputSignal, before: str, after: str) -> list[Rewriting]:
    node_net = node_net_of(signal)
    if node_net is None:
        return []
    found = []
    for part in subtree(node_net):
        if (
            isinstance(part, sym.InputClause)
            and any(literal.signal is signal for each in part.disjunctions for literal in each.literals)
        ) or (isinstance(part, sym.InputClause) and replaced(part.text, before, after) != part.text):
            found.append(Rewriting(part, "text", replaced(part.text, before, after)))
    if found and any(label(other) == after for other in node_net.signals if other is not signal):
        raise CommandError(f"the node net has a signal {after!r} already", hint="clauses would be ambiguous")
    return found


_WORDS = re.compile(r'"(?:[^"\\]|\\["\\])*"|\w+(?:[.-]+\w+)*')


def replaced(text: str, before: str, after: str) -> str:
    """Return the text of a clause with one signal called by another name.

    Examples
    --------
    >>> replaced('a & !(ab | "a") -> a', "a", "is there")
    '"is there" & !(ab | "is there") -> "is there"'
    """

    def other(found: re.Match[str]) -> str:
        word = found[0]
        name = re.sub(r"\\(.)", r"\1", word[1:-1]) if word[0] == '"' else word
        is_name = word[0] == '"' or word not in KEYWORDS
        return quoted(after) if is_name and name == before else word

    return _WORDS.sub(other, text)


def _token_data(root: pn.Net, field: sym.TokenField, before: str, after: str) -> list[Rewriting]:
    token_type = field.eContainer()
    if isinstance(token_type, sym.TokenType) and any(other.name == after for other in token_type.fields):
        raise CommandError(f"the token type has a field {after!r} already")
    index = Index(root)
    found: list[Rewriting] = []
    for mapping in index.all(sym.FieldMapping):
        holder = mapping.eContainer()
        if mapping.tokenField != before or holder is None:
            continue
        place = index.place_of_part(holder, str(mapping.part))
        if place is not None and index.token_type_of(place) is token_type:
            found.append(Rewriting(mapping, "tokenField", after))
    for balloon in index.all(sym.BalloonToken):
        holder = balloon.eContainer()
        if isinstance(holder, sym.Place) and index.token_type_of(holder) is token_type:
            found += _in_data(balloon, before, after)
    return found


def _in_data(balloon: sym.BalloonToken, before: str, after: str) -> Iterator[Rewriting]:
    try:
        data = decode_json(balloon.data)
    except DinerosError:
        return  # a constraint says so
    if isinstance(data, dict) and before in data:
        changed = {after if name == before else name: value for name, value in data.items()}
        yield Rewriting(balloon, "data", json.dumps(changed, ensure_ascii=False))
