"""From records to the steps and lanes that are drawn.

A `TraceBuilder` takes one record at a time, so that the picture of a running application grows with it.
The effect of a record on a lane is a *mark*: a list of the lane's number, a letter, and more:

| lane | marks |
|---|---|
| managed node | ``l`` number of its state, 1 where it failed to change |
| signal | ``v`` value |
| queue | ``p`` level (publish), ``k`` level (take), ``d`` level, count (drop), ``n`` level |
| client | call, after ``q`` request, ``s`` serve, ``r`` reply, ``a`` answer, ``o`` late, ``g`` given up |
| goals | as of a client, and ``c`` (asks to cancel), ``x`` (is to be), ``b`` (feedback), ``h`` (gets it) |
| transition | ``f`` handlers (fires), ``e`` (fails), ``z`` (leaves tokens), ``u`` (takes them again) |
| place | ``n`` tokens |
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from dineros.metamodel import records as rec
from dineros.metamodel.clauses import SignalSetting, setting_text
from dineros.metamodel.lifecycles.states import STATES, State
from dineros.metamodel.records import Header, Record, Start
from dineros.metamodel.records.schema import Step as StepRecord
from dineros.views.traces.calls import CallBars
from dineros.views.traces.facts import Facts, prototype
from dineros.views.traces.goals import GoalBars
from dineros.views.traces.lanes import Lane, Lanes
from dineros.views.traces.steps import Mark, Step, details_of

Queue = tuple[str, str, str]
"""Channel, kind of queue, and the place of its port or, for a dispatcher, its node net."""

_WORD = re.compile(r"[A-Za-z_][\w.\[\]]*")


class TraceBuilder:
    """Builds steps and lanes from records.

    Parameters
    ----------
    facts : Facts, optional
        Facts of the model.
    loads : mapping, optional
        Of a witness: the queue that each load place of the flattened net belongs to.
    """

    def __init__(self, facts: Facts | None = None, loads: Mapping[str, Queue] | None = None) -> None:
        self.facts = facts or Facts()
        self.header: Header | None = None
        self.lanes = Lanes()
        self.steps: list[Step] = []
        self.initial: dict[str, int] = {}
        self.marking: dict[str, int] = {}
        self.signals: dict[str, SignalSetting] = {}
        self.nodes: list[str] = list(dict.fromkeys(self.facts.owner.values()))
        self.loop: int | None = None
        self._loads = dict(loads or {})
        self._published: dict[str, int] = {}
        self._counts: dict[int, int] = {}
        self._calls = CallBars(self.lanes, self.facts)
        self._goals = GoalBars(self.lanes, self.facts)
        self._started: set[str] = set()
        self._watched: dict[str, list[Lane]] = {}
        self._begun = False

    def add(self, record: Record, node: str | None = None) -> Step | None:
        """Process the next record; return its step, if it has one.

        Parameters
        ----------
        record : Record
            The record.
        node : str, optional
            Its node, if the record does not have it.
        """
        node = record.node or node
        if node and node not in self.nodes:
            self.nodes.append(node)
        if isinstance(record, Header):
            self._head(record)
            return None
        if isinstance(record, Start):
            return self._start(record, node)
        step = self._step(record, node)
        if step is not None:
            self._apply(step)
            self.steps.append(step)
        return step

    def _head(self, header: Header) -> None:
        if self.header is not None:
            return  # of another node of the same run, or of a later part
        self.header = header
        self.initial = dict(header.marking)
        self.marking = dict(header.marking)
        asked = _WORD.findall(header.property or "")
        for node in self.facts.managed if header.kind == "witness" else ():
            self._state_lane(node)
        initial = {} if header.signals == "none" else header.signals_initial  # else they have no values
        for signal, value in sorted(initial.items(), key=lambda item: item[0] not in asked):
            self.signals[signal] = value
            self._signal_lane(signal, value)
        self._lanes_of_channels()
        if header.kind == "witness":
            self._lanes_of_property(asked)

    def _lanes_of_channels(self) -> None:
        """Create the lanes of all ports, for each topic in the order of the message flow."""
        order = ["publisher", "dispatcher", "subscriber"]
        found: list[tuple[str, str, str]] = []
        for channel, place in self.facts.limits:
            if (channel, place) in self.facts.subscribers:
                found.append((channel, "subscriber", place))
            elif place in self.nodes:
                found.append((channel, "dispatcher", place))
            else:
                found.append((channel, "publisher", place))
        channels = list(self.facts.channels)
        for channel, queue, place in sorted(
            found, key=lambda one: (channels.index(one[0]), order.index(one[1]))
        ):
            if queue != "dispatcher" or self._loads:
                self._queue_lane(channel, queue, place)
        for (channel, place), client in self.facts.ports.items():
            self._calls.lane(channel, client, self.facts.owner_of(place))
        for (channel, client), place in self.facts.goals.items():
            self._goals.lane(channel, client, self.facts.owner_of(place))

    def _lanes_of_property(self, asked: list[str]) -> None:
        """Add lanes for the places of the property; a prototype means the sum of its instances."""
        for name in dict.fromkeys(asked):
            for transition in self.facts.transitions:
                if name in (transition, prototype(transition)):
                    self._transition_lane(transition, self.facts.owner_of(transition), group="property")
            of_name = [place for place in self._places() if name in (place, prototype(place))]
            if not of_name:
                continue
            tokens = sum(self.initial.get(place, 0) for place in of_name)
            lane = self.lanes.make(
                "place", name, group="property", kind="place", id=name, label=self.facts.label_of(name),
                note="tokens", node=self.facts.owner_of(name), initial=tokens,
            )  # fmt: skip
            self._counts[lane.index] = tokens
            for place in of_name:
                self._watched.setdefault(place, []).append(lane)

    def _places(self) -> list[str]:
        return list(dict.fromkeys([*self.initial, *self.facts.places]))

    def _start(self, record: Start, node: str | None) -> Step | None:
        """Start a node with its tokens. Only the first start of a node is before the first step."""
        counts = {place: len(tokens) for place, tokens in record.marking.items()}
        known = node in self._started
        self._started.add(node or "")
        if isinstance(record, rec.Checkpoint) and known:
            return None  # what the records before it led to
        if not known and not self._begun:
            for place, tokens in counts.items():
                self.initial[place] = self.marking[place] = tokens
            for signal, value in record.signals.items():
                self.signals[signal] = value
                self._signal_lane(signal, value)
            state = record.lifecycle if isinstance(record, rec.Checkpoint) else ""
            if state or node in self.facts.managed:
                self._state_lane(node or "?", state or "unconfigured")
            return None
        mine = [place for place in self.marking if self.facts.owner_of(place) == node] if known else []
        change = {
            place: counts.get(place, 0) - self.marking.get(place, 0)
            for place in dict.fromkeys([*mine, *counts])
            if counts.get(place, 0) != self.marking.get(place, 0)
        }
        marks: list[Mark] = []
        for signal, value in record.signals.items():
            if self.signals.get(signal) != value:
                lane = self._signal_lane(signal, value)
                marks.append([lane.index, "v", lane.level_of(value)])
                self.signals[signal] = value
        if known and not change and not marks and not record.resumed:
            return None  # it follows the checkpoint that a journal begins with
        text = f"{node} continues" if record.resumed else f"{node} starts"
        step = Step(record.event, node, text, change, marks, time=record.time, details=details_of(record))
        self._apply(step)
        self.steps.append(step)
        return step

    def _apply(self, step: Step) -> None:
        self._begun = True
        if self.header is not None and self.header.kind == "run" and step.node:
            self._started.add(step.node)
        for place, tokens in step.change.items():
            self.marking[place] = self.marking.get(place, 0) + tokens
            for lane in self._watched.get(place, ()):
                self._counts[lane.index] += tokens
                step.marks = [mark for mark in step.marks if mark[0] != lane.index]
                step.marks.append([lane.index, "n", self._counts[lane.index]])
            queue = self._loads.get(place)
            if queue is not None:
                self._set_level(step, self._queue_lane(*queue), self.marking[place])

    def _set_level(self, step: Step, lane: Lane, level: int) -> None:
        self._counts[lane.index] = level
        for mark in step.marks:
            if mark[0] == lane.index:
                mark[2] = level
                return
        step.marks.append([lane.index, "n", level])

    def _step(self, record: Record, node: str | None) -> Step | None:
        change = dict(record.change) if isinstance(record, StepRecord) else {}
        transition = getattr(record, "transition", None)
        said = getattr(record, "text", None)
        step = Step(record.event, node, said or "", change, [], transition, record.time, details_of(record))
        if self.header is not None and self.header.loop == record.sequence and self.loop is None:
            self.loop = len(self.steps)
        match record:
            case rec.Fire() | rec.Error() | rec.Aside() | rec.Release():
                self._transition(step, record)
            case rec.Signal():
                lane = self._signal_lane(record.signal, self._before(record))
                self.signals[record.signal] = record.value
                step.node = node or lane.node
                step.marks.append([lane.index, "v", lane.level_of(record.value)])
                step.text = said or f"signal {record.signal} becomes {setting_text(record.value)}"
            case rec.Drop(queue="request"):
                self._bar(step, self._calls.mark_lost(record, node))
            case _ if record.declared.goal:
                self._goal(step, record)
            case rec.Timeout() if (record.channel, record.client) in self.facts.goals:
                self._goal(step, record)
            case rec.Publish() | rec.Take() | rec.Drop():
                self._topic(step, record)
            case rec.Timeout():
                step.node = node
                self._bar(step, self._calls.mark(record, node))
            case _ if record.declared.call:
                step.node = node or self.facts.owner_of(getattr(record, "place", None))
                self._bar(step, self._calls.mark(record, node))
            case rec.Transfer():
                step.text = said or f"{self.facts.channel_name(record.channel)}: {record.stage}"
            case rec.Lifecycle():
                self._lifecycle(step, record)
            case rec.Stop():
                step.text = f"{node} stops" + (f": {record.reason}" if record.reason else "")
            case _ if record.declared.is_of_topic:
                step.node = node or self.facts.owner_of(getattr(record, "place", None))
                step.text = said or f"{step.node} {record.declared.words(record)}"
        return step

    def _transition(self, step: Step, record: Record) -> None:
        transition = step.transition
        if transition is None:
            step.text = f"error: {step.details.get('error', '')}"
            return
        step.node = step.node or self.facts.owner_of(transition)
        lane = self._transition_lane(transition, step.node)
        label = self.facts.label_of(transition)
        if isinstance(record, rec.Fire):
            step.marks.append([lane.index, "f", len(record.handlers)])
            step.text = step.text or label
        elif isinstance(record, rec.Error):
            step.marks.append([lane.index, "e"])
            step.text = f"{label} fails: {record.error}"
        else:
            aside = isinstance(record, rec.Aside)
            step.marks.append([lane.index, "z" if aside else "u"])
            step.text = f"{label} {'sets tokens aside' if aside else 'takes its tokens again'}"

    def _lifecycle(self, step: Step, record: rec.Lifecycle) -> None:
        lane, state = self._state_lane(step.node or "?"), STATES.index(record.state)
        failed = self._counts[lane.index] == state
        self._counts[lane.index] = state
        step.marks.append([lane.index, "l", state, int(failed)])
        outcome = f"it stays {record.state}" if failed else f"it is {record.state}"
        step.text = step.text or f"{step.node}: {record.label}; {outcome}"

    def _topic(self, step: Step, record: rec.Publish | rec.Take | rec.Drop) -> None:
        channel, place = record.channel, record.place
        name = self.facts.channel_name(channel)
        step.node = step.node or self.facts.owner_of(place)
        if isinstance(record, rec.Drop):
            lane = self._queue_lane(channel, record.queue, place or step.node or "")
            if not self._loads and record.queue != "publisher":
                self._counts[lane.index] = max(0, self._counts[lane.index] - record.count)
            step.marks.append([lane.index, "d", self._waiting(lane), record.count])
            lost = "a message" if record.count == 1 else f"{record.count} messages"
            step.text = (
                step.text or f"{record.queue} queue of {place or step.node} (topic {name}) loses {lost}"
            )
        elif isinstance(record, rec.Publish):
            lane = self._queue_lane(channel, "publisher", record.place)
            step.marks.append([lane.index, "p", self._counts[lane.index]])
            step.text = step.text or f"{record.place} publishes on topic {name}"
            self._published[channel] = self._published.get(channel, 0) + 1
            for other in () if self._loads else self.lanes.all:
                if other.channel == channel and other.queue == "subscriber":
                    self._counts[other.index] += 1
                    step.marks.append([other.index, "n", self._waiting(other)])
        else:
            lane = self._queue_lane(channel, "subscriber", record.place)
            if not self._loads:
                self._counts[lane.index] = max(0, self._counts[lane.index] - 1)
            step.marks.append([lane.index, "k", self._waiting(lane)])
            step.text = step.text or f"{record.place} takes from topic {name}"

    def _waiting(self, lane: Lane) -> int:
        """Return the number of messages in a queue; losses of a history come with its next message."""
        count, most = self._counts[lane.index], lane.capacity if self.facts.has_histories else None
        return count if most is None or self._loads else min(count, most)

    def _goal(self, step: Step, record: Record) -> None:
        step.node = step.node or self.facts.owner_of(getattr(record, "place", None))
        self._bar(step, self._goals.mark(record, step.node))

    def _bar(self, step: Step, drawn: tuple[Lane, list[Any] | None, str]) -> None:
        """Draw on the lane of a client; records of a goal without effect are text only."""
        lane, mark, text = drawn
        step.node = step.node or lane.node
        step.marks += [] if mark is None else [[lane.index, *mark]]
        step.text = step.text or text

    def _state_lane(self, node: str, initial: State = "unconfigured") -> Lane:
        state = STATES.index(initial)
        lane = self.lanes.make(
            "state", node, group="lifecycle", kind="state", id=node, label=self.facts.label_of(node),
            node=node, initial=state,
        )  # fmt: skip
        self._counts.setdefault(lane.index, state)
        return lane

    def _before(self, record: rec.Signal) -> SignalSetting:
        """Return the value of a signal before it changed, if known."""
        if isinstance(record.value, bool):
            return not record.value
        return next((each for each in self.facts.values.get(record.signal, ()) if each != record.value), "?")

    def _signal_lane(self, signal: str, initial: SignalSetting) -> Lane:
        values = None if isinstance(initial, bool) else list(self.facts.values.get(signal, ()))
        lane = self.lanes.get("signal", signal)
        if lane is not None:
            return lane
        if values is not None and initial not in values:
            values.append(str(initial))
        return self.lanes.make(
            "signal", signal, group="signals", kind="signal", id=signal, label=self.facts.label_of(signal),
            node=self.facts.owner_of(signal), values=values,
            initial=int(initial) if values is None else values.index(str(initial)),
        )  # fmt: skip

    def _queue_lane(self, channel: str, queue: str, place: str) -> Lane:
        if queue == "publisher" and place not in self.facts.owner:
            place = prototype(place)  # the instances of a server page share the queue
        before = 0 if self._loads or queue != "subscriber" else self._published.get(channel, 0)
        asks = queue == "request"
        capacity = (self.facts.depths if asks else self.facts.limits).get((channel, place))
        lane = self.lanes.make(
            "queue", channel, queue, place, group="services" if asks else "topics", kind="queue", id=place,
            label=self.facts.channel_name(channel), note=f"{queue} {self.facts.label_of(place)}",
            node=self.facts.owner_of(place) or place, channel=channel, queue=queue, capacity=capacity,
        )  # fmt: skip
        self._counts.setdefault(lane.index, before)
        return lane

    def _transition_lane(self, transition: str, node: str | None, group: str = "transitions") -> Lane:
        return self.lanes.make(
            "transition", transition, group=group, kind="transition", id=transition,
            label=self.facts.label_of(transition), node=node,
        )  # fmt: skip
