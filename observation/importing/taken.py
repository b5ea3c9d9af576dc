"""What is taken to be so where code leaves something open, and what a model lacks because of that."""

from __future__ import annotations


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
