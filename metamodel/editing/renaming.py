"""Renaming: texts that refer to an element by name, not by a reference, are changed with it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses.expressions import KEYWORDS, WORDS, quoted, unquoted
from dineros.metamodel.constraints.index import Index
from dineros.metamodel.editing.commands import CommandError
from dineros.metamodel.editing.handles import subtree
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.json_text import decode_json


@dataclass(frozen=True)
class Rewriting:
    """A text that contains a name, and the changed text."""

    element: EObject
    feature: str
    text: str


def rewritings(root: pn.Net, element: EObject, feature: str, value: str | None) -> list[Rewriting]:
    """Return the texts that change, with the new ones, if an element with its old name or id gets another.

    Raises
    ------
    CommandError
        Another element next to it has the new name, so that texts would become ambiguous.
    """
    if isinstance(element, sym.InputSignal) and feature in ("name", "id"):
        before = label(element)
        after = value or element.id if feature == "name" else element.name or value or ""
        found = _clauses(element, before, after) if before != after else []
        former = element.id if feature == "id" else element.name
        return [*found, *_properties(root, former, value or element.id)]
    if isinstance(element, pn.Element) and feature == "id" and value:
        return _properties(root, element.id, value)
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
        ) or (isinstance(part, sym.InputClause) and replaced(part.text, {before: after}) != part.text):
            found.append(Rewriting(part, "text", replaced(part.text, {before: after})))
    if found and any(label(other) == after for other in node_net.signals if other is not signal):
        raise CommandError(f"the node net has a signal {after!r} already", hint="clauses would be ambiguous")
    return found


def replaced(text: str, names: Mapping[str, str]) -> str:
    """Return the text of a clause with signals renamed.

    Examples
    --------
    >>> replaced('a & !(ab | "a") -> a', {"a": "is there"})
    '"is there" & !(ab | "is there") -> "is there"'
    """

    def other(found: re.Match[str]) -> str:
        word, name = found[0], unquoted(found[0])
        is_name = word[0] == '"' or word not in KEYWORDS
        return quoted(names[name]) if is_name and name in names else word

    return WORDS.sub(other, text)


def _properties(root: pn.Net, before: str | None, after: str) -> list[Rewriting]:
    """Return the changes of stored properties and assumptions, which refer to elements by id."""
    if not isinstance(root, sym.SystemModel) or not before or before == after:
        return []
    texts = [
        *((each, "text", in_formula(each.text or "", before, after)) for each in root.properties),
        *(
            (each, "of", in_words(each.of or "", before, after))
            for each in root.assumptions
            if isinstance(each, sym.Fairness)
        ),
    ]
    return [Rewriting(*each) for each in texts if getattr(*each[:2]) != each[2]]


_FORMULA_NAMES = re.compile(
    r'"(?:[^"\\]|\\["\\])*"|\{(?:[^{}\\]|\\[{}\\])*\}|[^\W\d]\w*(?:\[\d+\])?(?:\.\w+(?:\[\d+\])?)*'
)
"""Names in formulas: plain, in quotes, or in braces."""

_FORMULA_WORDS = {
    *("true", "false", "deadlock", "enabled", "fired", "signal", "or", "and", "not"),
    *("never", "always", "happens", "until", "leads", "to", "only", "after", "before", "between"),
    *("at", "most", "once", "twice", "times", "is", "stays", "possible"),
    *("U", "R", "W", "A", "E", "G", "F", "X", "GF", "FG", "AG", "AF", "AX", "EG", "EF", "EX"),
}
_COUNTED = re.compile(r"\s*(?:[=≤≥≠+*]|!=|>|<(?![>-])|-(?!>))")
"""Pattern of the text after a word, if the word names a place."""


def in_formula(text: str, before: str, after: str) -> str:
    """Return a formula, or a pattern in words, with the id of an element changed.

    Examples
    --------
    >>> in_formula('never Topic.publisher.Said + "Said" >= 2 after fired(Said2)', "Said", "is said")
    'never "Topic.publisher.is said" + "is said" >= 2 after fired(Said2)'
    """

    def other(found: re.Match[str]) -> str:
        word = found[0]
        is_plain = word[0] not in '"{'
        if is_plain and word in _FORMULA_WORDS and not _COUNTED.match(text, found.end()):
            return word
        name = word if is_plain else re.sub(r"\\(.)", r"\1", word[1:-1])
        changed = in_name(name, before, after)
        if changed == name:
            return word
        if word[0] == "{":
            return "{" + re.sub(r"([{}\\])", r"\\\1", changed) + "}"
        fits = _FORMULA_NAMES.fullmatch(changed) and changed[0] not in '"{' and changed not in _FORMULA_WORDS
        return changed if is_plain and fits else '"' + re.sub(r'(["\\])', r"\\\1", changed) + '"'

    return _FORMULA_NAMES.sub(other, text)


def in_name(name: str, before: str, after: str) -> str:
    """Return the name of an element of the flattened net, which joins ids by dots, with an id changed.

    Examples
    --------
    >>> in_name("Pick[2].PickRun", "Pick", "Grasp")
    'Grasp[2].PickRun'
    """
    if name == before:
        return after
    parts = (re.fullmatch(r"(.*?)((?:\[\d+\])?)", part, re.DOTALL) for part in name.split("."))
    return ".".join((after if part[1] == before else part[1]) + part[2] for part in parts if part)


def in_words(of: str, before: str, after: str) -> str:
    """Return the scope of a fairness, such as ``all-but:Ask,Answer``, with the id of an element changed.

    Examples
    --------
    >>> in_words("all-but:Ask,Answer", "Answer", "Reply"), in_words("node:Ask", "Ask", "Beg")
    ('all-but:Ask,Reply', 'node:Beg')
    """
    for word in ("node:", "all-but:"):
        if of.startswith(word):
            names = of.removeprefix(word).split(",") if word == "all-but:" else [of.removeprefix(word)]
            return word + ",".join(in_name(each, before, after) for each in names)
    return of if of in ("all", "signals") else in_name(of, before, after)


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
        return  # reported by a constraint
    if isinstance(data, dict) and before in data:
        changed = {after if name == before else name: value for name, value in data.items()}
        yield Rewriting(balloon, "data", json.dumps(changed, ensure_ascii=False))
