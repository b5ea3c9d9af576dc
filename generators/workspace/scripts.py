"""Scripts from traces: a witness or a recorded run, as the steps that take nodes through it.

A step is a tuple: its kind, its node, and what it is about. What happens silently inside of channels is
left out, but for lost messages.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from dineros.generators.application.application import Application, NodePackage, Transition
from dineros.generators.templates.filters import Name
from dineros.generators.workspace.developers import instance_of
from dineros.metamodel import records
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.json_text import decode_json
from dineros.metamodel.records.schema import ServiceStep, Step
from dineros.metamodel.ros_names import snake_case

ScriptStep = tuple[Any, ...]


class ScriptError(DinerosError):
    """A trace cannot take the nodes of this model anywhere."""


@dataclass(frozen=True)
class Script:
    """What takes nodes through a trace.

    Attributes
    ----------
    name : str
        Name of the test.
    about : str
        What the trace shows.
    steps : tuple of ScriptStep
        The steps.
    marking : dict of str to int
        Tokens of each place of the model at the end, all server instances together.
    """

    name: Name
    about: str
    steps: tuple[ScriptStep, ...]
    marking: dict[str, int]

    def to_json(self) -> bytes:
        """Return the script as a file of the workspace: one step per line."""
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
            The file is no script.
        """
        location = Location(path)
        if (
            not f"test_{path.stem}".isidentifier() or not path.stem.isascii()
        ):  # names the function of the test
            raise ScriptError("is no name of a script", location=location)
        values = decode_json(content, location=location)
        match values:
            case {"about": str() as about, "steps": list() as steps, "marking": dict() as marking}:
                if all(map(_is_step, steps)) and all(type(count) is int for count in marking.values()):
                    return Script(Name(path.stem), about, tuple(map(tuple, steps)), marking)
        raise ScriptError("is no script of steps", location=location)


def _is_step(step: object) -> bool:
    return isinstance(step, list) and all(
        part is None or isinstance(part, (str, int, float)) for part in step
    )


def read_script(path: Path, app: Application) -> Script:
    """Return the script of a trace.

    Parameters
    ----------
    path : Path
        A witness, the trace of a node's run, or a folder with those of several nodes.
    app : Application
        The application.

    Raises
    ------
    DinerosError
        The trace cannot be read, is of another model, or starts from another marking.
    """
    found = _records(path)
    headers = [record for record in found if isinstance(record, records.Header)]
    if not headers:
        raise ScriptError("has no header", location=Location(path), hint="is it a trace of DiNeROS?")
    header = headers[0]
    if header.model != app.id:
        raise ScriptError(f"is a trace of {header.model!r}, not of {app.id!r}", location=Location(path))
    model = _Model(app)
    marking = model.initial()
    model.require_start(path, header, found)
    steps: list[ScriptStep] = []
    writer = _StepWriter(
        model, satisfies_clauses=header.kind == "witness" and header.signals in (None, "none")
    )
    for record in found:
        steps.extend(writer.steps_of(record))
        if isinstance(record, Step):
            for place, change in record.change.items():
                own = _model_name(place)
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


def _merged(traces: dict[str, list[records.Record]]) -> Iterator[records.Record]:
    """Yield the records of several nodes: by time, but none before the message that it receives."""
    positions = dict.fromkeys(traces, 0)
    sent: set[tuple[str, str | None]] = set()
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
        if isinstance(record, (records.Publish, records.Request, records.Reply)):
            sent.add((record.event, record.message))
            counts[record.event, record.channel] += 1
        elif isinstance(record, (records.Take, records.Serve, records.Response)):
            counts[_receiver(record)] += 1
        yield record


_SENDING = {"take": "publish", "serve": "request", "response": "reply"}


def _can_happen(
    record: records.Record, sent: set[tuple[str, str | None]], counts: Counter[tuple[str, ...]]
) -> bool:
    """Tell whether what a record receives was sent; where messages have no ids, as many must have been."""
    if not isinstance(record, (records.Take, records.Serve, records.Response)):
        return True
    sending = _SENDING[record.event]
    if record.message and (sending, record.message) in sent:
        return True
    return not record.message and counts[sending, record.channel] > counts[_receiver(record)]


def _receiver(record: records.Take | records.Serve | records.Response) -> tuple[str, ...]:
    # Any instance of a server may serve; a message of a topic reaches every subscriber.
    return (record.event, record.channel, record.place if isinstance(record, records.Take) else "")


def _model_name(id: str) -> str:
    instance = instance_of(id)
    return instance.transition if instance else id


class _Model:
    """Look-ups in an application."""

    def __init__(self, app: Application) -> None:
        self.app = app
        self.transitions: dict[str, tuple[NodePackage, Transition]] = {
            transition.id: (node, transition) for node in app.nodes for transition in node.transitions
        }
        self.places: dict[str, NodePackage] = {place.id: node for node in app.nodes for place in node.places}
        self.signals = {signal.id: (node, signal) for node in app.nodes for signal in node.signals}

    def initial(self) -> dict[str, int]:
        """Return the initial tokens of each place, all server instances together."""
        return {place.id: place.tokens * place.instances for node in self.app.nodes for place in node.places}

    def require_start(self, path: Path, header: records.Header, found: Iterable[records.Record]) -> None:
        """Refuse a trace that starts from another marking than the model."""
        counts: Counter[str] = Counter()
        wanted = self.initial()
        if header.kind == "witness":
            for place, tokens in header.marking.items():
                counts[_model_name(place)] += tokens
        else:
            starts = [record for record in found if isinstance(record, records.Start)]
            first = {start.node: start for start in reversed(starts)}
            for start in first.values():
                for place, stored in start.marking.items():
                    counts[_model_name(place)] += len(stored)
            nodes = set(first)
            wanted = {place: count for place, count in wanted.items() if self.places[place].id in nodes}
        for place, count in wanted.items():
            if counts[place] != count:
                raise ScriptError(
                    f"starts with {counts[place]} tokens on {place}, the model with {count}",
                    location=Location(path),
                    hint="generate with the settings (--set) of the trace",
                )


class _StepWriter:
    """Writes the steps of records.

    Parameters
    ----------
    model : _Model
        The model.
    satisfies_clauses : bool
        Whether the trace knows no signals, so that they are set to what a transition's clause needs.
    """

    def __init__(self, model: _Model, *, satisfies_clauses: bool) -> None:
        self._model = model
        self._satisfies_clauses = satisfies_clauses
        self._waiting: dict[str, list[tuple[str, str | None]]] = {}  # channel -> clients and their requests
        self._serving: dict[tuple[str, int | None], str] = {}  # channel, instance -> client
        self._signals = {id: signal.initial for id, (_, signal) in model.signals.items()}

    def steps_of(self, record: records.Record) -> Iterator[ScriptStep]:
        """Yield the steps of a record; most have one."""
        match record:
            case records.Fire():
                yield from self._fire(record)
            case records.Signal():
                node, _ = self._model.signals.get(record.signal, (None, None))
                if node is None:
                    raise ScriptError(f"the model has no signal {record.signal!r}", location=record.location)
                yield ("signal", node.id, record.signal, record.value)
            case records.Publish() | records.Take():
                yield (record.event, self._node(record.place, record), record.channel, record.place)
            case records.GiveUp():
                raise ScriptError(
                    f"client {record.client} gives up a request, and a script knows no time",
                    location=record.location,
                    hint="take a trace in which no client gives up",
                )
            case records.Drop(queue="request"):
                yield ("drop", record.node or "", record.channel, record.queue, self._lost(record))
            case records.Drop():
                node_id = record.node or (self._node(record.place, record) if record.place else "")
                for _ in range(record.count):
                    yield ("drop", node_id, record.channel, record.queue, record.place or "")
            case ServiceStep():
                node_id = self._node(record.place, record)
                yield (record.event, node_id, record.channel, self._client(record), record.instance or 0)

    def _lost(self, record: records.Drop) -> str:
        """Return the client whose request a full history loses."""
        waiting = self._waiting.setdefault(record.channel, [])
        lost = next((each for each in waiting if record.message in (each[1], None)), None)
        if lost is None:
            raise ScriptError(f"nobody asked {record.channel} for this", location=record.location)
        waiting.remove(lost)
        return lost[0]

    def _client(self, record: ServiceStep) -> str:
        """Return the client of a call; servers know only the id of the message, if it has one."""
        waiting = self._waiting.setdefault(record.channel, [])
        serving = (record.channel, record.instance)
        client = record.client
        if isinstance(record, records.Request):
            waiting.append((record.client or "", record.message))
        elif isinstance(record, records.Serve):
            same = [
                each
                for each in waiting
                if record.message in (each[1], None, "") and client in (each[0], None)
            ]
            if not same and client is None:
                raise ScriptError(f"nobody asked {record.channel} for this", location=record.location)
            if same:
                waiting.remove(same[0])
            client = same[0][0] if client is None else client
            self._serving[serving] = client
        elif isinstance(record, records.Reply):
            client = client or self._serving.get(serving, "")
        return client or ""

    def _fire(self, record: records.Fire) -> Iterator[ScriptStep]:
        name = _model_name(record.transition)
        if name not in self._model.transitions:
            raise ScriptError(f"the model has no transition {name!r}", location=record.location)
        node, transition = self._model.transitions[name]
        if self._satisfies_clauses and transition.clause:
            for signal in node.signals:
                value = transition.case.signals.get(signal.id, signal.initial)
                if self._signals[signal.id] != value:
                    self._signals[signal.id] = value
                    yield ("signal", node.id, signal.id, value)
        yield ("fire", node.id, record.transition)

    def _node(self, place: str, record: records.Record) -> str:
        node = self._model.places.get(_model_name(place))
        if node is None:
            raise ScriptError(f"the model has no place {place!r}", location=record.location)
        return node.id
