"""Waits for condition variables that no code notifies."""

from __future__ import annotations

import re
from collections.abc import Iterable

from dineros.sources.cpp.parsing import Source
from dineros.sources.facts import NEVER_SET, Effect, NodeFact

_WAIT = "condition variable, without time-out"
_NAME = re.compile(r"(\w+)(?: \(\d+\))?$")


def mark_never_notified(nodes: Iterable[NodeFact], sources: Iterable[Source]) -> None:
    """Mark waits without a predicate for a condition variable whose name all code uses for waits only.

    Parameters
    ----------
    nodes : iterable of NodeFact
        The nodes of the program.
    sources : iterable of Source
        All code.
    """
    texts = {each.path: each.text for each in sources}
    for effect in (each for node in nodes for fact in node.callbacks for each in fact.effects):
        found = _NAME.search(effect.what)
        if (effect.do, effect.how) != ("wait", _WAIT) or found is None:
            continue
        name = found[1].encode()
        if _has_no_predicate(effect, name, texts) and not any(
            _may_notify(each, name) for each in texts.values()
        ):
            effect.how += NEVER_SET


def _has_no_predicate(effect: Effect, name: bytes, texts: dict[str, bytes]) -> bool:
    lines = texts.get(effect.at.file, b"").split(b"\n")
    line = lines[effect.at.line - 1] if effect.at.line <= len(lines) else b""
    return re.search(rb"\b" + name + rb"\s*(?:\.|->)\s*wait\s*\(\s*\w+\s*\)", line) is not None


def _may_notify(text: bytes, name: bytes) -> bool:
    """Return whether code does more with a name than to declare a condition variable and to wait for it."""
    for use in re.finditer(rb"\b" + name + rb"\b", text):
        before = text[text.rfind(b"\n", 0, use.start()) + 1 : use.start()]
        after = text[use.end() : use.end() + 20].lstrip()
        is_declared = re.search(rb"\bcondition_variable(?:_any)?\s", before) and after[:1] in (
            b";",
            b",",
            b"{",
        )
        if not is_declared and not re.match(rb"(?:\.|->)\s*wait", after):
            return True
    return False
