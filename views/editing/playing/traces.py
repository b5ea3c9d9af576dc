"""Converts traces to games and back: witnesses step by step, runs by conformance with a model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from dineros.analysis.conformance.conform import conform
from dineros.analysis.conformance.net import ConformanceNet
from dineros.analysis.model.subject import Subject, subject_for
from dineros.analysis.witnesses.first_cause import Cause
from dineros.analysis.witnesses.records import witness_records
from dineros.analysis.witnesses.witness import witness_of
from dineros.metamodel import pn, sym
from dineros.metamodel.editing import CommandError
from dineros.metamodel.records import Header, Record, RecordDecoder, encode_record
from dineros.views.editing.playing.game import Game


def game_of(model: pn.Net, texts: Mapping[str, str]) -> Game:
    """Return the steps of traces for a game.

    Parameters
    ----------
    model : pn.Net
        The current model.
    texts : mapping of str
        The traces by their name: a witness, or the traces of the nodes of a run.

    Raises
    ------
    DinerosError
        They are not traces, of another model, or cannot be fired on this one.
    """
    traces = {name: _records(name, text) for name, text in texts.items()}
    headers = {name: found[0] for name, found in traces.items()}
    for name, header in headers.items():
        if header.model != model.id:
            raise CommandError(f"{name} is a trace of the model {header.model!r}, this one is {model.id!r}")
    name, header = next(iter(headers.items()))
    if header.kind != "witness":
        return _of_run(model, traces, headers)
    if len(texts) != 1:
        raise CommandError("a witness is played alone")
    return _of_witness(model, name, header, traces[name])


def text_of(game: Game, source: str) -> str:
    """Return the steps up to the present one as a trace, which ``dineros trace`` opens."""
    witness = witness_of(game.subject, game.steps[: game.at])
    # A game leads to no outcome that has a cause.
    header, *steps = witness_records(witness, source=source, cause=Cause(0, (), {}))
    header = replace(header, cause=None)  # type: ignore[call-arg]  # it is a header
    return "".join(f"{encode_record(each)}\n" for each in (header, *steps))


def _of_witness(model: pn.Net, name: str, header: Header, records: list[Any]) -> Game:
    subject = subject_for(model, header.signals or "fully-enabled", header.overflow or "weighted")
    steps = []
    for record in records[1:]:
        index = subject.transition_index.get(getattr(record, "transition", None) or "")
        if index is None:
            said = f"{name} fires {getattr(record, 'transition', None)!r}, which this model does not have"
            raise CommandError(said, hint="it may belong to an earlier version of the model")
        steps.append(index)
    initial = {place: tokens for place, tokens in _initial(subject).items() if tokens}
    if initial != header.marking:
        raise CommandError(
            f"{name} starts with tokens that differ from those of this model",
            hint="the model was changed, or must be",
        )
    # The header is record 0, so record i is step i - 1.
    loop = None if header.loop is None else header.loop - 1
    if loop is not None and not 0 <= loop < len(steps):
        raise CommandError(f"{name} has a loop that starts at a missing step")
    return Game(subject, steps, loop, header.property or name)


def _initial(subject: Subject) -> dict[str, int]:
    return dict(zip(subject.net.places, subject.net.initial.tolist(), strict=True))


def _of_run(model: pn.Net, traces: Mapping[str, list[Any]], headers: Mapping[str, Header]) -> Game:
    if not isinstance(model, sym.SystemModel):
        raise CommandError("only system models can be run")
    by_node: dict[str, list[Record]] = {}
    for name, records in traces.items():
        node = headers[name].node or name.removesuffix(".jsonl")
        if headers[name].kind != "run" or node in by_node:
            raise CommandError(f"{name} belongs to another run than the other traces")
        by_node[node] = records
    verdict = conform(
        model, {node: records.__iter__ for node, records in by_node.items()}, attempts=10, firings=True
    )
    subject = ConformanceNet(model).subject
    steps = [subject.transition_index[name] for name in verdict.sequence]
    problem = next(iter([*verdict.violations, *verdict.unknown]), None)
    ends = "" if problem is None else f", up to where it is not allowed: {problem}"
    return Game(subject, steps, None, f"run of {', '.join(by_node)}{ends}")


def _records(name: str, text: str) -> list[Any]:
    decoder = RecordDecoder(name)
    records = list(decoder.feed(text.encode()))
    last = decoder.close()
    if last is not None:
        records.append(last)
    if not records or not isinstance(records[0], Header):
        raise CommandError(f"{name} is not a trace: it does not begin with a header")
    return records
