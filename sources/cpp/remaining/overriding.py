"""Finds the methods that base classes of other packages call.

A driver calls ``run()`` of its thread class, a controller manager ``update()``. No code of the folder does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from dineros.sources.cpp.entries import ClassInfo, Routine
from dineros.sources.cpp.values import Frame, Method

if TYPE_CHECKING:
    from dineros.sources.cpp.following.routines import Routines


def overridden(machine: Routines) -> Iterator[tuple[Method, Routine, Frame]]:
    """Yield the methods of objects that a base class outside of the folder may call, and no other code did.

    These are methods that are declared as ``override``, and those that no code of the folder names.
    """
    for this in machine.extending:
        bases = machine.bases(this.cls) if this.cls is not None else []
        seen: set[str] = set()
        for cls in bases:
            for name, routines in cls.methods.items():
                if name in seen or name.startswith("~") or any(name == each.name for each in bases):
                    continue
                seen.add(name)
                for each in routines:
                    if each.body is None or each.node.id in machine.followed:
                        continue
                    if not machine.reach.does_matter(each):
                        continue
                    if _is_override(name, bases) or not machine.reach.is_named(each):
                        yield Method([each], name, this), each, Frame(cls.path, cls.full, this, cls)


def _is_override(name: str, classes: list[ClassInfo]) -> bool:
    pattern = re.compile(rf"\b{re.escape(name)}\s*\([^;{{}}]*\)[^;{{}}()]*\b(?:override|final)\b".encode())
    return any(pattern.search(each.node.text or b"") for each in classes)
