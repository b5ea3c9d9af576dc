"""Fires the transitions of the net, for the replay of nodes, topics, calls and goals."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.reasons import why_not
from dineros.analysis.conformance.refusals import Fault
from dineros.metamodel.records.schema import Step


class Player:
    """A marking of the flattened net, and the firings that led to it.

    `firings`: list to which each firing of the net is appended.

    Attributes
    ----------
    marking : list of int
        The marking; always the same list object.
    """

    def __init__(self, net: ConformanceNet, firings: list[int] | None = None) -> None:
        self.net, self.firings = net, firings
        self.marking: list[int] = net.net.initial.tolist()
        self.fired = 0

    def fire(self, transition: int) -> None:
        """Fire an enabled transition."""
        marking = self.marking
        assert all(marking[place] >= weight for place, weight in self.net.pre[transition]), transition
        for place, tokens in self.net.net.delta[transition].items():
            marking[place] += tokens
        self.fired += 1
        if self.firings is not None:
            self.firings.append(transition)

    def add_between(self, transition: int) -> None:
        """Apply an unrecorded firing before the traces begin: its effect on places outside of all nodes."""
        for place, tokens in self.net.net.delta[transition].items():
            if place not in self.net.own_places:
                self.marking[place] += tokens

    def is_enabled(self, transition: int) -> bool:
        """Return whether a transition is enabled."""
        marking = self.marking
        return all(marking[place] >= weight for place, weight in self.net.pre[transition]) and all(
            marking[place] < weight for place, weight in self.net.inhibitor[transition]
        )

    def why_not(self, transition: int) -> str:
        """Return why a transition is not enabled; empty if it is."""
        return why_not(self.net, transition, self.marking)

    def at(self, record: Step, transition: int) -> Fault | None:
        """Refuse a step at a port that another node or place records, or with another change."""
        role = self.net.roles[self.net.net.transitions[transition]]
        if role.node != record.node:
            return Fault(f"the port belongs to node {role.node}, not {record.node}")
        if role.place != getattr(record, "place", None):
            return Fault(f"the place of the port is {role.place}")
        return self._differs(record, transition)

    def fire_recorded(self, record: Step, transition: int) -> Fault | None:
        """Fire the transition of a record, if it is enabled and the record has the same change."""
        fault = self._differs(record, transition)
        if fault is None:
            self._supply(transition)
        if fault is None and not self.is_enabled(transition):
            fault = Fault(self.why_not(transition))
        if fault is None:
            self.fire(transition)
        return fault

    def fire_at(self, record: Step, transition: int) -> Fault | None:
        """Fire the transition of a record at a port, if node and place are also those of the model."""
        return self.at(record, transition) or self.fire_recorded(record, transition)

    def _supply(self, transition: int) -> None:
        """Fire unrecorded transitions that a transition needs: the tick of its timer."""
        for place, weight in self.net.pre[transition]:
            for other in self.net.suppliers.get(place, ()):
                if self.marking[place] < weight and self.is_enabled(other):
                    self.fire(other)

    def _differs(self, record: Step, transition: int) -> Fault | None:
        """Compare the recorded change with that of the net, on the places of the node."""
        own = self.net.places_of.get(record.node or "", {})
        told = {place: tokens for place, tokens in record.change.items() if tokens}
        net_places = self.net.net.places
        change = {
            net_places[place]: tokens
            for place, tokens in self.net.net.delta[transition].items()
            if net_places[place] in own
        }
        if told == change:
            return None
        return Fault(f"it changes {_shown(told)}; in the model it changes {_shown(change)}")


def _shown(change: Mapping[str, int]) -> str:
    return ", ".join(f"{place} by {tokens:+}" for place, tokens in change.items()) or "nothing"
