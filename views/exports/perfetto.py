"""A trace for Perfetto (https://ui.perfetto.dev): a process for each node net, with the tracks of its lanes.

Signals and queues are counters; calls of services and goals of actions are slices, the client's around the
server's, with requests to cancel and feedback as instants; firings are slices as long as their handlers took,
or instants. Arrows (flows) lead from requests to servers, and back.
"""

from __future__ import annotations

from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.views.exports.timing import FIRING, Call, calls_of, marks_of, times_of
from dineros.views.traces.building import Step, TraceBuilder
from dineros.views.traces.goals import ENDS
from dineros.views.traces.lanes import Lane

_SEQUENCE = 1
_GOAL_EVENTS = {"c": "asks to cancel", "x": "is to be canceled", "b": "feedback", "h": "hears feedback"}
_BEGIN, _END, _INSTANT, _COUNTER = 1, 2, 3, 4  # of TrackEvent.Type


def export(builder: TraceBuilder) -> bytes:
    """Return a trace as a protobuf of Perfetto.

    Raises
    ------
    DinerosError
        The package perfetto is not installed.
    """
    try:
        from perfetto.trace_builder.proto_builder import TraceProtoBuilder
    except ImportError:
        raise DinerosError(
            "this export needs the package perfetto", hint="pip install 'dineros[view]'"
        ) from None
    proto = TraceProtoBuilder()
    _Tracks(proto, builder).write()
    return bytes(proto.serialize())


class _Tracks:
    """The packets of a trace, in order of time."""

    def __init__(self, proto: Any, builder: TraceBuilder) -> None:
        self.proto, self.builder = proto, builder
        self.times = times_of(builder)
        self.end = (self.times[-1] if self.times else 0) + FIRING
        self._tracks: dict[tuple[str, ...], int] = {}
        self._events: list[tuple[int, int, Any]] = []

    def write(self) -> None:
        start = self.times[0] if self.times else 0
        for lane in self.builder.lanes.all:
            if lane.kind == "signal":
                self._count(start, lane, lane.initial)
        for index, step, lane, letter, values in marks_of(self.builder):
            time = self.times[index]
            if lane.kind in ("signal", "queue", "place"):
                self._count(time, lane, values[0])
            if lane.kind == "queue" and letter in "pkd":
                what = {"p": "publish", "k": "take", "d": "message lost"}[letter]
                self._instant(time, self._track(lane.node, f"{lane.label} {lane.note}"), what, step)
            elif lane.kind == "transition":
                self._firing(time, lane, letter, step)
            elif lane.kind == "client" and letter in "cxbh":
                self._instant(time, self._track(lane.node, _client_track(lane)), _GOAL_EVENTS[letter], step)
        for number, call in enumerate(calls_of(self.builder), 1):
            self._call(call, number)
        # Where two events are at the same time, they stay in the order they were made.
        for time, _, fill in sorted(self._events, key=lambda event: event[:2]):
            packet = self.proto.add_packet()
            packet.timestamp = time
            packet.trusted_packet_sequence_id = _SEQUENCE
            fill(packet.track_event)

    def _firing(self, time: int, lane: Lane, letter: str, step: Step) -> None:
        track = self._track(lane.node, "firings")
        took = round(step.details.get("duration", 0) * 1e9) if letter == "f" else 0
        name = {"f": lane.label, "e": f"{lane.label} fails", "z": f"{lane.label} aside"}.get(
            letter, lane.label
        )
        if not took:
            self._instant(time, track, name, step)
            return
        # Firings with handlers may overlap: each such transition has a track of its own.
        own = self._track(lane.node, lane.label)
        self._slice(own, name, time - took, time, step=step)

    def _call(self, call: Call, number: int) -> None:
        first = call.request if call.request is not None else call.serve
        if first is None:
            return
        begin = self.times[first]
        end = self.end if call.over is None else self.times[call.over]
        lane = call.lane
        number_ = f" ({call.level + 1})" if call.level else ""
        client = self._track(lane.node, f"{lane.label} client {lane.id}{number_}")
        ended = " (given up)" if call.given_up is not None else " (never answered)"
        open_ = "" if call.response is not None else ended
        if call.end is not None:
            open_ = f" ({ENDS[call.end]})"
        self._slice(client, f"{lane.label} C {lane.id}{open_}", begin, end, flow=number)
        if call.serve is None:
            return
        node = self.builder.steps[call.serve].node
        server = self._track(node, f"{lane.label} {'slot' if call.is_goal else 'instance'} {call.instance}")
        done = self.end if call.reply is None else self.times[call.reply]
        self._slice(
            server, f"{lane.label} I {call.instance} C {lane.id}", self.times[call.serve], done, flow=number
        )

    def _slice(
        self,
        track: int,
        name: str,
        begin: int,
        end: int,
        *,
        flow: int | None = None,
        step: Step | None = None,
    ) -> None:
        def opening(event: Any) -> None:
            event.type, event.track_uuid, event.name = _BEGIN, track, name
            if flow is not None:
                event.flow_ids.append(flow)
            if step is not None:
                _annotate(event, step)

        def closing(event: Any) -> None:
            event.type, event.track_uuid = _END, track

        self._at(begin, opening)
        self._at(max(end, begin), closing)

    def _instant(self, time: int, track: int, name: str, step: Step) -> None:
        def fill(event: Any) -> None:
            event.type, event.track_uuid, event.name = _INSTANT, track, name
            _annotate(event, step)

        self._at(time, fill)

    def _count(self, time: int, lane: Lane, value: int) -> None:
        name = f"{lane.label} {lane.note}".strip()
        track = self._track(lane.node, name, counter=True)

        def fill(event: Any) -> None:
            event.type, event.track_uuid, event.counter_value = _COUNTER, track, value

        self._at(time, fill)

    def _at(self, time: int, fill: Any) -> None:
        self._events.append((max(time, 0), len(self._events), fill))

    def _track(self, node: str | None, name: str, *, counter: bool = False) -> int:
        process = node or "channels"
        parent = self._tracks.get((process,))
        if parent is None:
            parent = self._tracks[(process,)] = len(self._tracks) + 1
            packet = self.proto.add_packet()
            packet.track_descriptor.uuid = parent
            packet.track_descriptor.process.pid = parent
            packet.track_descriptor.process.process_name = process
        key = (process, name, "counter" if counter else "events")
        if key not in self._tracks:
            self._tracks[key] = len(self._tracks) + 1
            descriptor = self.proto.add_packet().track_descriptor
            descriptor.uuid, descriptor.parent_uuid, descriptor.name = self._tracks[key], parent, name
            if counter:
                descriptor.counter.SetInParent()
        return self._tracks[key]


def _client_track(lane: Lane) -> str:
    return f"{lane.label} client {lane.id}"


def _annotate(event: Any, step: Step) -> None:
    values = {"text": step.text, "transition": step.transition, **step.details}
    for name, value in values.items():
        if value is not None:
            event.debug_annotations.add(name=name, string_value=str(value))
    for place, tokens in step.change.items():
        event.debug_annotations.add(name=place, int_value=tokens)
