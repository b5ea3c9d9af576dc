"""Converts the records of a trace to steps of a script: one, several, or none."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from dineros.generators.application.application import Application, NodePackage, Transition
from dineros.generators.workspace.developers import instance_of
from dineros.metamodel import records
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.lifecycles.states import STATE_AFTER
from dineros.metamodel.records.goals import GoalStep
from dineros.metamodel.records.schema import ServiceStep

ScriptStep = tuple[Any, ...]


class ScriptError(DinerosError):
    """A trace cannot be executed with the nodes of this model."""


def model_name(id: str) -> str:
    """Return the model's name for a place or transition, without the server instance."""
    instance = instance_of(id)
    return instance.transition if instance else id


class Model:
    """Lookups in an application."""

    def __init__(self, app: Application) -> None:
        self.app = app
        self.transitions: dict[str, tuple[NodePackage, Transition]] = {
            transition.id: (node, transition) for node in app.nodes for transition in node.transitions
        }
        self.places: dict[str, NodePackage] = {place.id: node for node in app.nodes for place in node.places}
        self.signals = {signal.id: (node, signal) for node in app.nodes for signal in node.signals}
        self.ticks = {f"{timer.callback}.tick" for node in app.nodes for timer in node.timers}
        """Ticks of timers in a flattened net (rule C1); nodes do not have these transitions."""
        self._readers: dict[str, list[str]] = {}
        for node in app.nodes:
            for port in node.ports:
                if port.kind == "subscriber":
                    self._readers.setdefault(port.channel, []).append(port.place)

    def initial(self) -> dict[str, int]:
        """Return the initial tokens of each place, summed over all server instances."""
        return {place.id: place.tokens * place.instances for node in self.app.nodes for place in node.places}

    def reader_of(self, drop: records.Drop) -> str:
        """Return the subscriber's place for which the history of a publisher loses a message.

        Under the rules of ``ros2``, each subscriber has its own history (rule R2); otherwise the result is
        empty.
        """
        begin = f"{drop.channel}.writer.{drop.place}."
        made = drop.transition or ""
        found = [
            place for place in self._readers.get(drop.channel, ()) if made.startswith(f"{begin}{place}.")
        ]
        return max(found, key=len, default="")

    def require_start(self, path: Path, header: records.Header, found: Iterable[records.Record]) -> None:
        """Refuse a trace that starts from another marking than the model."""
        counts: Counter[str] = Counter()
        wanted = self.initial()
        if header.kind == "witness":
            for place, tokens in header.marking.items():
                counts[model_name(place)] += tokens
        else:
            starts = [record for record in found if isinstance(record, records.Start)]
            first = {start.node: start for start in reversed(starts)}
            for start in first.values():
                for place, stored in start.marking.items():
                    counts[model_name(place)] += len(stored)
            nodes = set(first)
            wanted = {place: count for place, count in wanted.items() if self.places[place].id in nodes}
        for place, count in wanted.items():
            if counts[place] != count:
                raise ScriptError(
                    f"starts with {counts[place]} tokens on {place}, the model with {count}",
                    location=Location(path),
                    hint="generate with the settings (--set) of the trace",
                )


class StepWriter:
    """Writes the steps of records.

    `satisfies_clauses`: whether the trace has no signals, so that the script sets them as the clause of a
    transition needs.
    """

    def __init__(self, model: Model, *, satisfies_clauses: bool) -> None:
        self._model = model
        self._satisfies_clauses = satisfies_clauses
        self._waiting: dict[str, list[records.Request]] = {}  # by channel
        self._serving: dict[tuple[str, int | None], str] = {}  # channel, instance -> client
        self._goals: dict[tuple[str, str], str] = {}  # channel, goal -> client
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
            case records.Record(declared=declared) if declared.needs_time:
                raise ScriptError(
                    f"{declared.needs_time.format(**vars(record))}, and a test script has no time",
                    location=record.location,
                    hint=f"use a trace in which {declared.without_it}",
                )
            case records.Transfer(stage="goal.enter") | records.Drop(queue="goal"):
                raise ScriptError(
                    f"sends goals of {record.channel} without waiting for their end; nodes of a test wait",
                    location=record.location,
                    hint="set the feature outstanding of the action's clients, and compute the witness again",
                )
            case records.Drop(queue="request"):
                if lost := self._lost(record):
                    yield ("drop", record.node or "", record.channel, record.queue, lost)
            case records.Drop(queue="publisher") if reader := self._model.reader_of(record):
                yield ("drop", self._node(reader, record), record.channel, "subscriber", reader)
            case records.Drop():
                node_id = record.node or (self._node(record.place, record) if record.place else "")
                for _ in range(record.count):
                    yield ("drop", node_id, record.channel, record.queue, record.place or "")
            case ServiceStep():
                node_id = self._node(record.place, record)
                yield (record.event, node_id, record.channel, self._client(record), record.instance or 0)
            case records.Cancel(message=None, instance=None):
                yield ("cancel", record.node or "", record.channel, record.client or "", 0, "gone")
            case GoalStep():
                client, outcome = self._sender(record), getattr(record, "outcome", "")
                about = record.channel, client, record.instance or 0, outcome
                yield (record.event, record.node or "", *about)
            case records.Lifecycle() if record.state == STATE_AFTER[record.label]:
                yield ("lifecycle", record.node or "", record.label)

    def _sender(self, record: GoalStep) -> str:
        """Return the client of a goal; a server knows only the id of the goal, if it has one."""
        goal = (record.channel, record.message or "")
        if isinstance(record, records.Goal):
            self._goals[goal] = record.client or ""
        return record.client or self._goals.get(goal, "")

    def _lost(self, record: records.Drop) -> str:
        """Return the client whose request is lost; empty: it was served, and its response is lost."""
        waiting = self._waiting.setdefault(record.channel, [])
        if record.message is None:  # a witness has the place
            same = [each for each in waiting if each.place == record.place]
        else:
            same = [each for each in waiting if each.message == record.message]
        lost = next(iter(same), None)
        if lost is None and record.message is None:
            return ""
        if lost is None:
            raise ScriptError(f"no client asked {record.channel} for this", location=record.location)
        waiting.remove(lost)
        return lost.client or ""

    def _client(self, record: ServiceStep) -> str:
        """Return the client of a call; a server knows only the id of the message, if it has one."""
        waiting = self._waiting.setdefault(record.channel, [])
        serving = (record.channel, record.instance)
        client = record.client
        if isinstance(record, records.Request):
            waiting.append(record)
        elif isinstance(record, records.Serve):
            same = [
                each
                for each in waiting
                if record.message in (each.message, None, "") and client in (each.client, None)
            ]
            if not same and client is None:
                raise ScriptError(f"no client asked {record.channel} for this", location=record.location)
            if same:
                waiting.remove(same[0])
            client = same[0].client or "" if client is None else client
            self._serving[serving] = client
        elif isinstance(record, records.Reply):
            client = client or self._serving.get(serving, "")
        return client or ""

    def _fire(self, record: records.Fire) -> Iterator[ScriptStep]:
        name = model_name(record.transition)
        if name in self._model.ticks and name not in self._model.transitions:
            return  # in a test, a timer ticks when its callback is to begin
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
        node = self._model.places.get(model_name(place))
        if node is None:
            raise ScriptError(f"the model has no place {place!r}", location=record.location)
        return node.id
