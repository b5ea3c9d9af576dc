"""Assumptions about a node for facts that a source does not have."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import sym

USUAL_DEPTH = 10
"""Default depth of a history; the most common number in programs."""
USUAL_PERIOD = 1.0
"""Period of an invented timer in seconds; no answer depends on it."""
TIMER = "timer"
"""Name of the timer that represents all spontaneous actions of a node."""


Marked = sym.NodeNet | sym.CallbackPage | sym.TopicPort
"""The list that records the assumptions."""


@dataclass(frozen=True)
class Assumed:
    """An assumption about a fact that a source does not have."""

    node: str
    """Full name of the node."""
    key: str
    value: str
    """`key`, `value`: its notation in the file of given facts, under the node: ``depths."/scan"``, ``10``."""
    words: str
    """The assumption in words."""

    @property
    def kind(self) -> str:
        """Its subject: ``depths``, ``threads``, ``timers``, ``lifecycle``, or the steps of callbacks."""
        return "what callbacks do" if self.key.startswith("callback.") else self.key.partition(".")[0]

    def __str__(self) -> str:
        return f"node {self.node}: {self.words}"


def of_client(name: str) -> str:
    """Return the key for a client's handling of responses, in a node that also serves this service."""
    return f"{name} (client)"


def quoted(text: str) -> str:
    """Return a text as TOML has it."""
    return f'"{text}"'


class Taken:
    """Messages about the decisions of an import, without duplicates, in their order."""

    def __init__(self) -> None:
        self._lines: dict[str, bool] = {}

    def add(self, line: str) -> None:
        """Add a decision that the model follows."""
        self._lines.setdefault(line, False)

    def lack(self, line: str) -> None:
        """Add a part that the model lacks, so that proofs about the model may not hold for the code."""
        self._lines[line] = True

    @property
    def lines(self) -> tuple[str, ...]:
        """All lines."""
        return tuple(self._lines)

    @property
    def lacks(self) -> tuple[str, ...]:
        """The lines about parts that the model lacks."""
        return tuple(line for line, is_lack in self._lines.items() if is_lack)
