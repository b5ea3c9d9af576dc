"""What is taken of a node where a source does not tell it."""

from __future__ import annotations

from dataclasses import dataclass

from dineros.metamodel import sym

USUAL_DEPTH = 10
"""Messages that a history keeps where nobody has said it; the commonest number in programs."""
USUAL_PERIOD = 1.0
"""Seconds of a timer that nobody has seen; no answer depends on it."""
TIMER = "timer"
"""Name of the timer that stands for all that a node does of itself."""


Marked = sym.NodeNet | sym.CallbackPage | sym.TopicPort
"""What says what of it is assumed."""


@dataclass(frozen=True)
class Assumed:
    """Something that a source does not tell, and that is taken.

    Attributes
    ----------
    node : str
        Full name of the node.
    key, value : str
        How it would be said in the file of what is given, under the node: ``depths."/scan"``, ``10``.
    words : str
        What is taken, for people.
    """

    node: str
    key: str
    value: str
    words: str

    @property
    def kind(self) -> str:
        """What it is about: ``depths``, ``threads``, ``timers``, ``lifecycle``, or what callbacks do."""
        return "what callbacks do" if self.key.startswith("callback.") else self.key.partition(".")[0]

    def __str__(self) -> str:
        return f"node {self.node}: {self.words}"


def of_client(name: str) -> str:
    """Return the key of what a client does with answers, in a node that also serves what it calls."""
    return f"{name} (client)"


def quoted(text: str) -> str:
    """Return a text as TOML has it."""
    return f'"{text}"'


class Taken:
    """Lines for people about the decisions of an import, each line once, in their order."""

    def __init__(self) -> None:
        self._lines: dict[str, bool] = {}

    def add(self, line: str) -> None:
        """Add a decision that the model follows."""
        self._lines.setdefault(line, False)

    def lack(self, line: str) -> None:
        """Add something that the model lacks, so that proofs about the model need not hold for the code."""
        self._lines[line] = True

    @property
    def lines(self) -> tuple[str, ...]:
        """All lines."""
        return tuple(self._lines)

    @property
    def lacks(self) -> int:
        """How many of them say what the model lacks."""
        return sum(self._lines.values())
