"""The ends of a transition's arcs, for templates and messages."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ArcEnd:
    """A place at a transition's arc; `kind` is ``normal``, ``read`` or ``inhibitor``."""

    place: str
    weight: int
    kind: str = "normal"

    def __str__(self) -> str:
        text = f"{self.weight} {self.place}" if self.weight > 1 else self.place
        if self.kind == "inhibitor":
            return f"fewer than {self.weight} {self.place}" if self.weight > 1 else f"no {self.place}"
        return f"{text} (read)" if self.kind == "read" else text
