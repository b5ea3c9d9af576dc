"""The operations on sets of states that CTL needs, for all representations."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, TypeVar

from dineros.analysis.logic.language.syntax import Atom, Formula

States = TypeVar("States")

Run = tuple[tuple[int, ...], tuple[int, ...]]
"""Transitions of a stem and of a loop; the loop is empty for a finite path and in a deadlock."""


class StateSets(Protocol[States]):
    """The interface of an engine for CTL: sets of reachable states and the three basic operators."""

    def constant(self, value: bool) -> States:
        """Return all states or none."""

    def atom(self, atom: Atom) -> States:
        """Return the states in which an atom is true."""

    def complement(self, states: States) -> States:
        """Return the other states."""

    def intersection(self, left: States, right: States) -> States:
        """Return the states in both sets."""

    def union(self, left: States, right: States) -> States:
        """Return the states in at least one of the sets."""

    def some_next(self, states: States) -> States:
        """EX: return the states with a successor in a set."""

    def some_until(self, stay: States, goal: States) -> States:
        """EU: return the states from which some run stays in one set until it is in the other."""

    def some_globally(self, states: States) -> States:
        """EG: return the states from which some run never leaves a set."""

    def initially(self, states: States) -> bool:
        """Whether the initial state is in a set."""

    def path(self, path: Formula, found: Mapping[Formula, States]) -> Run:
        """Return a replayed run from the initial state that shows a basic path formula.

        Some run must satisfy it.
        """
