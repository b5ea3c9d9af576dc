"""Encodes a trace as JSON for the page: growing tables of names, and steps that refer to them by number."""

from __future__ import annotations

from typing import Any

from dineros.metamodel.records import EVENTS, Fire, Header, Signal
from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.facts import Clause
from dineros.views.traces.steps import Step

BREAKPOINTS = [
    event
    for event, kind in EVENTS.items()
    if not (kind.declared.goal or issubclass(kind, (Header, Fire, Signal)))
]
"""Kinds of records that a breakpoint can name. Firings and signals have conditions of their own."""

TABLES = ("nodes", "places", "transitions", "texts")


class TraceCoder:
    """Encodes the content of a builder: first everything, then additions."""

    def __init__(self, builder: TraceBuilder, title: str) -> None:
        self.builder = builder
        self.title = title
        self._tables: dict[str, dict[str, int]] = {name: {} for name in TABLES}
        self._initial: list[list[int]] | None = None
        self._steps: list[dict[str, Any]] = []
        self._told = dict.fromkeys((*TABLES, "lanes"), 0)

    def snapshot(self) -> dict[str, Any]:
        """Return the complete current state; `changes` continues from here."""
        self._encode()
        header, facts = self.builder.header, self.builder.facts
        clauses = {name: _clause(clause) for name, clause in facts.clauses.items()}
        view = {
            "format": 1,
            "title": self.title,
            "kind": header.kind if header else "run",
            "model": header.model if header else "",
            "property": header.property if header else None,
            "verdict": header.verdict if header else None,
            "signalsOff": header is not None and header.signals == "none",
            "variant": " ".join(filter(None, (header.signals, header.overflow))) if header else "",
            "loop": self.builder.loop,
            "cause": _cause(header),
            "initial": self._initial,
            "clauses": clauses,
            "known": facts.transitions,
            "modelPlaces": facts.places,
            "events": BREAKPOINTS,
            "lanes": [lane.to_json() for lane in self.builder.lanes.all],
            "steps": self._steps[:],
            **{name: list(table) for name, table in self._tables.items()},
        }
        self._remember_told()
        return view

    def changes(self) -> dict[str, Any] | None:
        """Return the additions since the last call, or since the snapshot; None if there are none."""
        first = len(self._steps)
        lanes = len(self.builder.lanes.all)
        if first == len(self.builder.steps) and lanes == self._told["lanes"]:
            return None
        self._encode()
        new = {name: list(table)[self._told[name] :] for name, table in self._tables.items()}
        new["lanes"] = [lane.to_json() for lane in self.builder.lanes.all[self._told["lanes"] :]]  # type: ignore[misc]
        self._remember_told()
        return {"first": first, "steps": self._steps[first:], **{k: v for k, v in new.items() if v}}

    def _remember_told(self) -> None:
        self._told = {name: len(table) for name, table in self._tables.items()}
        self._told["lanes"] = len(self.builder.lanes.all)

    def _encode(self) -> None:
        for node in self.builder.nodes:
            self._number("nodes", node)
        if self._initial is None or not self._steps:
            initial = self.builder.initial.items()
            self._initial = [[self._number("places", place), tokens] for place, tokens in initial if tokens]
        for step in self.builder.steps[len(self._steps) :]:
            self._steps.append(self._step(step))

    def _number(self, table: str, name: str) -> int:
        known = self._tables[table]
        return known.setdefault(name, len(known))

    def _step(self, step: Step) -> dict[str, Any]:
        coded: dict[str, Any] = {"e": step.event, "x": self._number("texts", step.text)}
        if step.node is not None:
            coded["n"] = self._number("nodes", step.node)
        if step.transition is not None:
            coded["t"] = self._number("transitions", step.transition)
        if step.change:
            coded["c"] = [
                number
                for place, tokens in step.change.items()
                for number in (self._number("places", place), tokens)
            ]
        if step.marks:
            coded["m"] = step.marks
        if step.time is not None:
            coded["w"] = step.time
        if step.details:
            coded["d"] = step.details
        return coded


def _clause(clause: Clause) -> dict[str, Any]:
    return {"text": clause.text, "cnf": clause.disjunctions}


def _cause(header: Header | None) -> dict[str, Any] | None:
    """Return the first cause of the outcome of a witness; its first step, record 1, is number 0 here."""
    if header is None or header.cause is None:
        return None
    decided = [[text, *(number - 1 for number in span)] for text, span in header.decided.items()]
    return {"first": header.cause - 1, "steps": [step - 1 for step in header.causes], "decided": decided}
