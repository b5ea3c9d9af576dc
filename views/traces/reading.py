"""Traces from files: a witness, one node's run, or all nodes' runs of an application merged."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path

from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.records import Header, Record, node_traces, parts_of, read_records, read_trace
from dineros.views.traces.building import Queue, TraceBuilder
from dineros.views.traces.facts import facts_of
from dineros.views.traces.merging import merge


class NoTraceError(DinerosError):
    """The input is not a trace, or the traces do not belong together."""


def header_of(paths: Sequence[Path]) -> Header:
    """Return the first header of files and folders.

    Raises
    ------
    DinerosError
        There is no header.
    """
    path = next(chain.from_iterable(files_of(paths).values()))
    first = next(iter(read_records(path)), None)
    if not isinstance(first, Header):
        raise NoTraceError(
            "is not a trace: it does not begin with a header",
            location=Location(path),
            hint="traces are written by 'dineros find -o', 'dineros verify -o' and 'dineros run --trace'",
        )
    return first


def files_of(paths: Sequence[Path]) -> dict[str, list[Path]]:
    """Return the files of each trace, the oldest part first, of files and folders.

    Raises
    ------
    NoTraceError
        A folder holds no trace.
    """
    found: dict[str, list[Path]] = {}
    for path in paths:
        if path.is_dir():
            traces = node_traces(path)
            if not traces:
                raise NoTraceError("holds no trace (*.jsonl)", location=Location(path))
            found |= traces
            continue
        node = path.name.removesuffix(".jsonl")
        parts = parts_of(path.parent, node) if path.name.endswith(".jsonl") else []
        found[node if node not in found else str(path)] = parts if path in parts else [path]
    return found


def model_path(header: Header, paths: Sequence[Path]) -> Path | None:
    """Return the path of the model of a trace: the file in its header, from here or from the trace."""
    if not header.source:
        return None
    named = Path(header.source)
    folder = paths[0] if paths[0].is_dir() else paths[0].parent
    return next((path for path in (named, folder / named, folder / named.name) if path.is_file()), None)


def build(
    paths: Sequence[Path], model: pn.Net | None = None, loads: Mapping[str, Queue] | None = None
) -> TraceBuilder:
    """Read a trace.

    Parameters
    ----------
    paths : sequence of Path
        A witness; or files and folders of one run, whose nodes are merged in the order of their messages.
    model : pn.Net, optional
        The model: it has clauses, capacities and node nets.
    loads : mapping, optional
        Of a witness: the queue of each load place of the flattened net.

    Raises
    ------
    DinerosError
        A file is not a trace, or the files do not go together.
    """
    traces: dict[str, Iterable[Record]] = {}
    kinds: list[tuple[Path, Header]] = []
    for name, parts in files_of(paths).items():
        header = header_of(parts[:1])
        kinds.append((parts[0], header))
        traces[name] = read_trace(parts)
    first = kinds[0][1]
    for path, header in kinds[1:]:
        if "witness" in (header.kind, first.kind):
            raise NoTraceError(
                "a witness cannot be combined with other traces",
                location=Location(path),
                hint="--compare shows two traces side by side",
            )
        if header.model != first.model:
            raise NoTraceError(
                f"is of the model {header.model!r}, {kinds[0][0].name} of {first.model!r}",
                location=Location(path),
            )
    return build_from(merge(traces), model, loads)


def build_from(
    records: Iterable[tuple[str, Record]],
    model: pn.Net | None = None,
    loads: Mapping[str, Queue] | None = None,
) -> TraceBuilder:
    """Build the picture of merged records, each with the name of its trace."""
    builder = TraceBuilder(facts_of(model), loads)
    for _, record in records:
        builder.add(record)
    return builder
