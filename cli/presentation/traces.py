"""Common parts of commands that draw traces: the model of a trace, and the queues of its places."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from dineros.cli.console import note, warn

if TYPE_CHECKING:
    from dineros.analysis.witnesses.witness import Witness
    from dineros.metamodel import pn
    from dineros.metamodel.records import Header
    from dineros.transformations.flattening.traces import Trace
    from dineros.views.traces.building import Queue, TraceBuilder


def model_of(
    header: Header, paths: Sequence[Path], given: Path | None, settings: Sequence[str]
) -> pn.Net | None:
    """Read the model of a trace with the changes of the trace; None, with a warning, if it is missing.

    Parameters
    ----------
    header : Header
        It names the file.
    paths : sequence of Path
        Files of the trace: the model may be next to them.
    given : Path or None
        The model that the user names instead.
    """
    from dineros.cli.models import load
    from dineros.views.traces.reading import model_path

    path = given or model_path(header, paths)
    if path is None:
        named = f"the model {header.source!r} does not exist" if header.source else "the trace names no model"
        warn(f"{paths[0]}: {named}: net, clauses and capacities are not shown (give it with --model)")
        return None
    model = load(path, [*header.settings, *settings])
    if model.id != header.model:
        warn(f"{path}: holds model {model.id!r}, but the trace is of {header.model!r}")
    note(f"the model is {path}")
    return model


def loads_of(model: pn.Net | None, header: Header) -> dict[str, Queue]:
    """Return the queue of each load place of a witness's net, by trace links."""
    from dineros.metamodel import sym
    from dineros.transformations.flattening.flatten import flatten

    if header.kind != "witness" or header.signals is None or not isinstance(model, sym.SystemModel):
        return {}
    return load_places(flatten(model, header.signals, header.overflow or "weighted").trace)  # type: ignore[arg-type]


def load_places(trace: Trace) -> dict[str, Queue]:
    """Return the queue of each load place that the rules made."""
    from dineros.analysis.model.queues import queues_of

    found: dict[str, Queue] = {}
    for queue in queues_of(trace):
        channel, end = queue.elements
        found[queue.load] = (channel, queue.kind, end)
    return found


def witness_picture(witness: Witness, source: str, name: str) -> dict[str, Any]:
    """Return the picture of a witness for a page."""
    from dineros.views.traces.coding import TraceCoder

    return TraceCoder(witness_builder(witness, source), name).snapshot()


def witness_builder(witness: Witness, source: str, verdict: str | None = None) -> TraceBuilder:
    """Return the picture of a witness that was just found."""
    from dineros.analysis.witnesses.records import witness_records
    from dineros.views.traces.building import TraceBuilder
    from dineros.views.traces.facts import facts_of

    subject = witness.subject
    assert subject is not None, "witness_of() made it"
    loads = load_places(subject.flattened.trace) if subject.flattened is not None else {}
    builder = TraceBuilder(facts_of(subject.model), loads)
    for record in witness_records(witness, source=source, verdict=verdict):
        builder.add(record)
    return builder
