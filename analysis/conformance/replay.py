"""Replays recorded steps on the flattened net, one at a time."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from random import Random
from typing import Any

from dineros.analysis.conformance.data.arrivals import Arrivals
from dineros.analysis.conformance.data.values import Values
from dineros.analysis.conformance.goals import GoalFlow
from dineros.analysis.conformance.messages import Messages
from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.services.nameless import is_nameless
from dineros.analysis.conformance.services.replaying import Calls
from dineros.analysis.conformance.topics.fates import Fates
from dineros.analysis.conformance.topics.replaying import Topics
from dineros.metamodel.clauses import SignalSetting, setting_text
from dineros.metamodel.records import (
    EVENTS,
    Checkpoint,
    Drop,
    Fire,
    Header,
    Lifecycle,
    Publish,
    Record,
    Response,
    Serve,
    Signal,
    Start,
    Take,
)
from dineros.metamodel.records.schema import ChannelStep, Step


class Replay(Player):
    """A marking of the flattened net, and the messages under way.

    Parameters
    ----------
    keep : collection of (str, str)
        Channel and place of publishers whose queues should stay as full as possible.
    firings : list of int, optional
        List to which each firing of the net is appended.
    fates : Fates, optional
        Fates of messages, for topics with histories.
    draw : Random, optional
        Draws decisions about messages without ids.
    """

    def __init__(
        self,
        net: ConformanceNet,
        keep: Collection[tuple[str, str]] = (),
        firings: list[int] | None = None,
        fates: Fates | None = None,
        draw: Random | None = None,
    ) -> None:
        super().__init__(net, firings)
        self.messages = Messages(net)
        self.steps = 0
        self._recorded = 0
        self.topics = Topics(self, self.messages, keep, fates or Fates(), draw)
        self._goals = GoalFlow(self)
        self.values = Values(net.decisions)
        self.arrivals = Arrivals(net.model)
        self.calls = Calls(self, self.messages)

    @property
    def silent(self) -> int:
        """Number of firings without a record."""
        return self.fired - self._recorded

    @property
    def noted(self) -> list[int]:
        """The firings, if they are stored."""
        return self.firings or []

    def is_ambiguous(self, record: Record) -> bool:
        """Return whether the order of a step matters, since the server does not know the client."""
        if isinstance(record, Serve):
            return is_nameless(record) and len(self.net.clients_of(record.channel)) > 1
        return isinstance(record, Response) and self.calls.are_ambiguous(record.channel)

    def step(
        self,
        record: Record,
        dropped: bool = False,
        forced: bool = False,
        following: Record | None = None,
    ) -> Refusal | None:
        """Replay a record; if this is impossible, return the reason and change nothing.

        Parameters
        ----------
        dropped : bool
            Whether a later record reports that this message was lost in the publisher's queue.
        forced : bool
            Whether a message may be lost that is not reported as lost, since nothing else can be replayed.
        following : Record, optional
            The next record of the node, for a record of losses.
        """
        handle = _HANDLERS.get(type(record))
        before = self.fired
        refusal: Refusal | None = self.values.fault(record) or self.arrivals.fault(record)
        if refusal is not None:
            return refusal
        if isinstance(record, Publish):
            refusal = self.topics.publish(record, dropped, forced)
        elif isinstance(record, Drop):
            refusal = self._drop(record, following)
        elif record.declared.goal:
            refusal = self._goals.step(record, forced)
        elif handle is None:
            return None
        else:
            refusal = handle(self, record)
        if refusal is None:
            self.values.happen(record)
            self.arrivals.happen(record)
            self.steps += isinstance(record, Step)
            self._recorded += min(self.fired - before, _firings_of(record))
            for transition in filter(self.is_enabled, self.net.follow_ups):
                self.fire(transition)
        return refusal

    def _header(self, record: Header) -> Fault | None:
        if record.kind != "run":
            return Fault("a witness is not a trace of a run")
        if record.model != self.net.model.id:
            return Fault(f"the trace is of model {record.model!r}, not of {self.net.model.id!r}")
        return None

    def _start(self, record: Start) -> Fault | None:
        places = self.net.places_of.get(record.node or "")
        if places is None:
            return Fault(f"the model has no node net {record.node!r}")
        for place in record.marking:
            if place not in places and not self.net.is_of_idle_server(place):
                return Fault(f"node {record.node} has no place {place!r}")
        for place, index in places.items():
            held, expected = len(record.marking.get(place, ())), self.marking[index]
            if held != expected:
                return Fault(f"{place} holds {held} tokens, in the model {expected}")
        for signal, value in record.signals.items():
            wrong = self._no_setting(record.node, signal, value)
            if wrong is not None:
                return wrong
            self._set(signal, value)
        return None

    def _no_setting(self, node: str | None, signal: str, value: SignalSetting) -> Fault | None:
        """Return what is wrong with a signal or its value in a record."""
        owner, settings = self.net.signals.get(signal, ("", ()))
        if owner != node:
            return Fault(f"node {node} has no signal {signal!r}")
        if value not in settings:
            return Fault(f"signal {signal} has no value {setting_text(value)!r}")
        return None

    def _set(self, signal: str, value: SignalSetting) -> None:
        place = self.net.setting_places.get((signal, value))
        if place is not None and not self.marking[place]:
            changes = self.net.changes_of_signals[signal, value]
            self.fire(next(transition for transition in changes if self.is_enabled(transition)))

    def _signal(self, record: Signal) -> Fault | None:
        wrong = self._no_setting(record.node, record.signal, record.value)
        if wrong is not None:
            return wrong
        place = self.net.setting_places.get((record.signal, record.value))
        if place is not None and self.marking[place]:
            return Fault(f"signal {record.signal} is {setting_text(record.value)} already")
        self._set(record.signal, record.value)
        return None

    def _lifecycle(self, record: Lifecycle) -> Refusal | None:
        changes = self.net.changes_of(record)
        if not changes:
            return Fault(f"the model has no such change of node {record.node}")
        for transition in self.net.emptying.get(record.node or "", ()) if record.label == "configure" else ():
            while self.is_enabled(transition):
                self.fire(transition)
        transition = next((each for each in changes if self.is_enabled(each)), changes[0])
        if not self.is_enabled(transition):
            short = {place for place, weight in self.net.pre[transition] if self.marking[place] < weight}
            others = {self.net.node_of_state.get(place, "") for place in short}
            if others and others.isdisjoint({"", record.node or ""}):
                return Waiting(self.why_not(transition), tuple(sorted(others)))
        return self.fire_recorded(record, transition)

    def _transition(self, record: Fire) -> Fault | None:
        transition = self.net.fire(record.transition)
        if transition is None:
            return Fault("the model has no such transition")
        node = self.net.roles[record.transition].node
        if node != record.node:
            return Fault(f"the transition belongs to node {node}, not {record.node}")
        return self.fire_recorded(record, transition)

    def _at_topic(self, record: ChannelStep) -> Refusal | None:
        """Replay a step at the port of a topic that moves no message."""
        transition = self.net.end(type(record), record.channel, record.place)
        if transition is None:
            return Fault(f"topic channel {record.channel!r} has no such port")
        return self.fire_at(record, transition)

    def _drop(self, record: Drop, following: Record | None) -> Refusal | None:
        if record.queue == "feedback":
            return self._goals.drop(record)
        if record.channel in self.net.depths:
            return self.calls.lose(record)
        return self.topics.drop(record, following)


_HANDLERS: Mapping[type[Record], Callable[..., Any]] = {
    **{kind: Replay._at_topic for kind in EVENTS.values() if kind.declared.is_of_topic},
    Header: Replay._header,
    Start: Replay._start,
    Checkpoint: Replay._start,
    Signal: Replay._signal,
    Fire: Replay._transition,
    Lifecycle: Replay._lifecycle,
    Take: lambda self, record: self.topics.take(record),
    Drop: Replay._drop,
    **{kind: lambda self, record: self.calls.step(record) for kind in EVENTS.values() if kind.declared.call},
}


def _firings_of(record: Record) -> int:
    """Return the maximum number of firings of the net for a record."""
    if isinstance(record, Start):  # signals whose values differ from the model
        return len(record.signals)
    return record.count if isinstance(record, Drop) else 1
