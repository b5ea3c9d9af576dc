"""Services whose callback gets no response to fill: the program sends it later by ``send_response``."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from dineros.sources.cpp.declarators import function_of, parameters_of
from dineros.sources.cpp.parsing import Source, text_of
from dineros.sources.facts import LATER, NodeFact

if TYPE_CHECKING:
    from tree_sitter import Node

_SENDS = b"send_response"


def is_deferred(function: Node) -> bool:
    """Return whether the callback of a service gets the request only, with the id to answer it later.

    `function`: the definition of a function, or a lambda.
    """
    declarator = function.child_by_field_name("declarator")
    found = function_of(declarator) or declarator
    kinds = [] if found is None else [text_of(each.type) for each in parameters_of(found)]
    is_id = any("request_id" in each for each in kinds[:-1])
    return is_id and "Request" in kinds[-1] and not any("Response" in each for each in kinds)


def find_unanswered(nodes: Iterable[NodeFact], sources: Iterable[Source]) -> None:
    """Mark the deferred services of a program to which no code sends a response.

    If code sends responses in a way that could not be followed, nothing is marked.

    Parameters
    ----------
    nodes : iterable of NodeFact
        The nodes of the program; deferred callbacks of services lack their response `LATER`.
    sources : iterable of Source
        All code.
    """
    nodes = list(nodes)
    deferred = [
        (entity, fact)
        for node in nodes
        for entity in node.of("services")
        for fact in entity.callbacks.values()
        if fact.lacks == LATER
    ]
    if not deferred:
        return
    effects = [each for node in nodes for fact in node.callbacks for each in fact.effects]
    answered = {id(each.entity) for each in effects if each.do == "respond"}
    sent = sum(each.text.count(_SENDS) for each in sources)
    followed = {each.at for each in effects if each.do == "respond"}
    for entity, fact in deferred:
        if id(entity) in answered or entity.is_lent:
            continue
        if sent <= len(followed):
            fact.lacks = "always"
