"""A trace as MCAP (https://mcap.dev), for Foxglove, Lichtblick and tools of ROS: JSON messages with schemas.

| topic | its messages |
|---|---|
| ``/dineros/steps`` | every step |
| ``/dineros/log`` | the same as ``foxglove.Log``, for panels that show logs |
| ``/dineros/signals/NAME`` | ``{"value": true}`` |
| ``/dineros/topics/CHANNEL/QUEUE/PLACE`` | ``{"level", "capacity"}`` and what happened |
| ``/dineros/services/CHANNEL/CLIENT`` | ``{"state": "waiting", "instance": 1}`` |
| ``/dineros/actions/CHANNEL/CLIENT`` | the same of goals: ``{"state": "succeeded"}`` and so on |
| ``/dineros/marking`` | tokens of the places that the step changed, after it |
"""

from __future__ import annotations

import io
import json
from typing import Any

from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import EVENTS
from dineros.metamodel.records.schema import Timeout
from dineros.views.exports.timing import times_of
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.goals import ENDS
from dineros.views.traces.lanes import Lane
from dineros.views.traces.steps import Step

_TIME = {
    "type": "object",
    "title": "time",
    "properties": {"sec": {"type": "integer"}, "nsec": {"type": "integer"}},
}
_SCHEMAS: dict[str, dict[str, Any]] = {
    "dineros.Step": {
        "step": {"type": "integer"},
        "event": {"type": "string"},
        "node": {"type": "string"},
        "text": {"type": "string"},
        "transition": {"type": "string"},
        "change": {"type": "object", "additionalProperties": {"type": "integer"}},
        "details": {"type": "object"},
    },
    "dineros.Signal": {"value": {"type": "boolean"}},
    "dineros.SignalValue": {"value": {"type": "string"}},
    "dineros.Queue": {
        "level": {"type": "integer"},
        "capacity": {"type": "integer"},
        "event": {"type": "string"},
        "lost": {"type": "integer"},
    },
    "dineros.Call": {
        "call": {"type": "integer"},
        "state": {"type": "string"},
        "instance": {"type": "integer"},
    },
    "dineros.Marking": {"places": {"type": "object", "additionalProperties": {"type": "integer"}}},
    "foxglove.Log": {
        "timestamp": _TIME,
        "level": {"type": "integer"},
        "message": {"type": "string"},
        "name": {"type": "string"},
        "file": {"type": "string"},
        "line": {"type": "integer"},
    },
}
_INFO, _ERROR = 2, 4  # levels of foxglove.Log
_EVENTS = {"p": "publish", "k": "take", "d": "drop", "n": "level"}
_STATES = {
    (group, kind.declared.mark): kind.declared.state
    for kind in EVENTS.values()
    for group, is_about in (("services", kind.declared.call), ("actions", kind.declared.goal))
    if kind.declared.state and (is_about or kind is Timeout)
}
"""State of a call or goal after a mark, by the group of its lane."""


def export(builder: TraceBuilder) -> bytes:
    """Return a trace as MCAP.

    Raises
    ------
    DinerosError
        The package mcap is not installed.
    """
    try:
        from mcap.writer import Writer
    except ImportError:
        raise DinerosError("MCAP needs the package mcap", hint="pip install 'dineros[view]'") from None
    content = io.BytesIO()
    writer = Writer(content)
    writer.start(profile="", library="dineros")
    _File(writer, builder).write()
    writer.finish()
    return content.getvalue()


class _File:
    """The channels of a file, created on first use."""

    def __init__(self, writer: Any, builder: TraceBuilder) -> None:
        self.writer, self.builder = writer, builder
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}
        self._time = 0
        self._number = 0

    def write(self) -> None:
        header = self.builder.header
        if header is not None:
            about = {"model": header.model, "kind": header.kind, "property": header.property or ""}
            self.writer.add_metadata("dineros", {**about, "verdict": header.verdict or ""})
        times = times_of(self.builder)
        self._time = times[0] if times else 0
        for lane in self.builder.lanes.all:
            if lane.kind == "signal":
                self._signal(lane, lane.initial)
        marking = dict(self.builder.initial)
        self._message("/dineros/marking", "dineros.Marking", {"places": marking})
        for number, (time, step) in enumerate(zip(times, self.builder.steps, strict=True)):
            self._time, self._number = time, number
            self._step(step)
            for place, tokens in step.change.items():
                marking[place] = marking.get(place, 0) + tokens
            if step.change:
                after = {place: marking[place] for place in step.change}
                self._message("/dineros/marking", "dineros.Marking", {"places": after})
            for lane, letter, *values in step.marks:
                self._mark(self.builder.lanes.all[lane], letter, values)

    def _step(self, step: Step) -> None:
        said = {"step": self._number + 1, "event": step.event, "node": step.node or "", "text": step.text}
        more = {"transition": step.transition or "", "change": step.change, "details": step.details}
        self._message("/dineros/steps", "dineros.Step", {**said, **more})
        level = _ERROR if step.event in ("error", "drop") else _INFO
        stamp = {"sec": self._time // 10**9, "nsec": self._time % 10**9}
        log = {"timestamp": stamp, "level": level, "message": step.text, "name": step.node or ""}
        self._message("/dineros/log", "foxglove.Log", {**log, "file": "", "line": self._number + 1})

    def _signal(self, lane: Lane, level: int) -> None:
        schema = "dineros.Signal" if lane.values is None else "dineros.SignalValue"
        self._message(f"/dineros/signals/{lane.id}", schema, {"value": lane.setting(level)})

    def _mark(self, lane: Lane, letter: str, values: list[int]) -> None:
        if lane.kind == "signal":
            self._signal(lane, values[0])
        elif lane.kind == "queue":
            said = {"level": values[0], "event": _EVENTS[letter], "lost": values[1] if letter == "d" else 0}
            if lane.capacity is not None:
                said["capacity"] = lane.capacity
            self._message(f"/dineros/topics/{lane.channel}/{lane.queue}/{lane.id}", "dineros.Queue", said)
        elif lane.kind == "client":
            state = _STATES.get((lane.group, letter)) or ENDS[values[1]]
            call: dict[str, Any] = {"call": values[0], "state": state}
            if letter == "s" and values[1] is not None:
                call["instance"] = values[1]
            topic = f"/dineros/{lane.group}/{lane.channel}/{lane.id}"
            self._message(topic, "dineros.Call", call)

    def _message(self, topic: str, schema: str, content: dict[str, Any]) -> None:
        if topic not in self._channels:
            if schema not in self._schemas:
                shape = {"type": "object", "title": schema, "properties": _SCHEMAS[schema]}
                self._schemas[schema] = self.writer.register_schema(
                    name=schema, encoding="jsonschema", data=json.dumps(shape).encode()
                )
            self._channels[topic] = self.writer.register_channel(
                topic=topic, message_encoding="json", schema_id=self._schemas[schema]
            )
        self.writer.add_message(
            self._channels[topic],
            log_time=self._time,
            publish_time=self._time,
            data=json.dumps(content, ensure_ascii=False).encode(),
            sequence=self._number,
        )
