"""What those who replay the steps of topics and calls ask of the net."""

from __future__ import annotations

from typing import Protocol

from dineros.analysis.conformance.refusals import Fault
from dineros.metamodel.records.schema import Step


class Player(Protocol):
    """What fires transitions of the net."""

    @property
    def fired(self) -> int:
        """How many have fired."""

    def fire(self, transition: int) -> None:
        """Fire an enabled transition."""

    def at(self, record: Step, transition: int) -> Fault | None:
        """Refuse a port's step that another node or another place records, or with another change."""

    def fire_recorded(self, record: Step, transition: int) -> Fault | None:
        """Fire what a record stands for."""

    def add_between(self, transition: int, times: int = 1) -> None:
        """Let a transition have fired that the traces do not tell: its effect on places of no node."""
