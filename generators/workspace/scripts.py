"""Test scripts from traces: a witness or a recorded run, as steps that tests execute with nodes.

A step is a tuple: its kind, its node, and its details. Silent steps inside of channels are left out, except
lost messages.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from dineros.generators.application.application import Application
from dineros.generators.templates.filters import Name
from dineros.generators.workspace.steps import Model, ScriptError, ScriptStep, StepWriter, model_name
from dineros.metamodel import records
from dineros.metamodel.errors import Location
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.records.schema import Step
from dineros.metamodel.ros_names import snake_case


@dataclass(frozen=True)
class Script:
    """The steps by which a test runs nodes through a trace."""

    name: Name
    """Name of the test."""
    about: str
    """Description of the trace."""
    steps: tuple[ScriptStep, ...]
    marking: dict[str, int]
    """Tokens on each place of the model at the end, summed over all server instances."""

    def to_json(self) -> bytes:
        """Return the script as the content of a file: one step per line."""
        lines = ",\n    ".join(json.dumps(step, ensure_ascii=False) for step in self.steps)
        head = json.dumps(self.about, ensure_ascii=False)
        marking = json.dumps(self.marking, ensure_ascii=False)
        steps = f"\n    {lines}\n  " if lines else ""
        return f'{{\n  "about": {head},\n  "steps": [{steps}],\n  "marking": {marking}\n}}\n'.encode(
            errors="replace"
        )

    @staticmethod
    def from_json(path: Path, content: bytes) -> Script:
        """Read a script.

        Raises
        ------
        ScriptError
            The file is not a script.
        """
        location = Location(path)
        if (
            not f"test_{path.stem}".isidentifier() or not path.stem.isascii()
        ):  # it becomes the name of the test function
            raise ScriptError("is not a name of a script", location=location)
        values = decode_json(content, location=location)
        match values:
            case {"about": str() as about, "steps": list() as steps, "marking": dict() as marking}:
                if all(map(_is_step, steps)) and all(type(count) is int for count in marking.values()):
                    return Script(Name(path.stem), about, tuple(map(tuple, steps)), marking)
        raise ScriptError("is not a script of steps", location=location)


def _is_step(step: object) -> bool:
    return isinstance(step, list) and all(
        part is None or isinstance(part, (str, int, float)) for part in step
    )


def read_script(path: Path, app: Application) -> Script:
    """Return the script of a trace.

    `path`: a witness, the trace of a node's run, or a folder with traces of several nodes.

    Raises
    ------
    DinerosError
        The trace cannot be read, belongs to another model, or starts from another marking.
    """
    found = _records(path)
    headers = [record for record in found if isinstance(record, records.Header)]
    if not headers:
        raise ScriptError("has no header", location=Location(path), hint="is it a trace of DiNeROS?")
    header = headers[0]
    if header.model != app.id:
        raise ScriptError(f"is a trace of {header.model!r}, not of {app.id!r}", location=Location(path))
    if any(node.has_guards for node in app.nodes):
        raise ScriptError(
            "is a trace of a model with guards: a test generated from it would lack the data of tokens",
            location=Location(path),
            hint="write a test by hand that gives this data to its handlers",
        )
    model = Model(app)
    marking = model.initial()
    model.require_start(path, header, found)
    steps: list[ScriptStep] = []
    writer = StepWriter(
        model, satisfies_clauses=header.kind == "witness" and header.signals in (None, "none")
    )
    for record in found:
        steps.extend(writer.steps_of(record))
        if isinstance(record, Step):
            for place, change in record.change.items():
                own = model_name(place)
                if own in marking:
                    marking[own] += change
    about = f"the trace {path.name}"
    if header.property:
        about = f"{header.property}: {header.verdict}" if header.verdict else header.property
    return Script(Name(snake_case(path.name.removesuffix(".jsonl")) or "trace"), about, tuple(steps), marking)


def _records(path: Path) -> list[records.Record]:
    if path.is_dir():
        traces = {
            node: [record for part in parts for record in records.read_records(part)]
            for node, parts in records.node_traces(path).items()
        }
        if not traces:
            raise ScriptError("holds no traces", location=Location(path))
        return list(_merged(traces))
    return list(records.read_records(path))


_SENDING = {event: kind.declared.receives for event, kind in records.EVENTS.items() if kind.declared.receives}
"""Pairs of events: the event that sends, and the event that receives."""
_SENT = frozenset(_SENDING.values())
_Sent = set[tuple[str, str | None, int]]


def _merged(traces: dict[str, list[records.Record]]) -> Iterator[records.Record]:
    """Yield the records of several nodes by time, but each after the message that it receives was sent."""
    positions = dict.fromkeys(traces, 0)
    sent: _Sent = set()
    counts: Counter[tuple[str, ...]] = Counter()
    while True:
        waiting = [
            (traces[node][position].time or 0.0, node)
            for node, position in positions.items()
            if position < len(traces[node])
        ]
        if not waiting:
            return
        ready = [
            entry for entry in waiting if _can_happen(traces[entry[1]][positions[entry[1]]], sent, counts)
        ]
        _, node = min(ready or waiting)
        record = traces[node][positions[node]]
        positions[node] += 1
        if record.event in _SENT:
            sent.add((record.event, *_message(record)))
            counts[record.event, _channel(record)] += 1
        if record.event in _SENDING:
            counts[_receiver(record)] += 1
        yield record


def _can_happen(record: records.Record, sent: _Sent, counts: Counter[tuple[str, ...]]) -> bool:
    """Return whether the message of a record was sent; without ids, compare the numbers of messages."""
    sending = _SENDING.get(record.event)
    if sending is None:
        return True
    message, number = _message(record)
    if message and (sending, message, number) in sent:
        return True
    has_no_id = not message or (record.event == "hear" and not number)
    return has_no_id and counts[sending, _channel(record)] > counts[_receiver(record)]


def _message(record: records.Record) -> tuple[str | None, int]:
    """Return the id of the sent or received message, and the number of feedback."""
    return getattr(record, "message", None), getattr(record, "number", 0)


def _channel(record: records.Record) -> str:
    return str(getattr(record, "channel", ""))


def _receiver(record: records.Record) -> tuple[str, ...]:
    # Any instance of a server may serve a request; a message of a topic reaches every subscriber.
    return (record.event, _channel(record), record.place if isinstance(record, records.Take) else "")
