"""Certificate files: their format, and whether they belong to a net and are unchanged.

This module proves nothing; `dineros.analysis.evidence.checker` does.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any, get_args

from dineros.analysis.model.subject import Subject, base_subject, subject_of
from dineros.analysis.nets.compiled import ArcTable
from dineros.analysis.timed.timed_subject import TimedSubject, timed_base_subject, timed_subject_of
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError, Location
from dineros.metamodel.files.atomic import write_atomically
from dineros.metamodel.files.reading import read_bytes
from dineros.metamodel.json_text import decode_json
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant

BASE = "base"
"""Value for the variant of signals: the net without signals, which `dineros check` uses."""

FORMAT, TIMED_FORMAT = "dineros certificate 2", "dineros certificate with times 1"
SIZE_LIMIT = 64 << 20
"""Maximum size of a file, in bytes."""

MOST_STEPS = 100
"""Maximum number of steps of an induction."""

_ROW = {"sum": {"": int}, "least": int}
_OF_ALL: dict[str, Any] = {
    **dict.fromkeys(("model", "net", "answer", "digest"), str),
    "settings": [str],
    "signals": frozenset([BASE, *get_args(SignalVariant)]),
    "overflow": frozenset(get_args(OverflowVariant)),
    "question": {"kind": str, "text": str},
}
_SHAPE: dict[str, Any] = {
    **_OF_ALL,
    "format": frozenset([FORMAT]),
    "never": [{"rows": [_ROW], "factors": [int], "weights": {"": int}}],
    "clauses": [[_ROW]],
    "steps": frozenset(range(MOST_STEPS + 1)),
}
_DIFFERENCE = {"first": str, "second": str, "most": str, "strict": bool}
_TIMED_SHAPE: dict[str, Any] = {
    **_OF_ALL,
    "format": frozenset([TIMED_FORMAT]),
    "classes": [{"marking": {"": int}, "times": {"": str}, "differences": [_DIFFERENCE]}],
    "schedule": [{"fires": str, "at": str}],
}
"""Formats: types, lists, objects with given or any names, and optional values."""


class CertificateFileError(DinerosError):
    """A file is not a certificate."""


def read_certificate(path: Path) -> dict[str, Any]:
    """Read a certificate.

    Raises
    ------
    CertificateFileError
        It is not a certificate.
    ModelFileError
        The file cannot be read, or is too large.
    """
    found = decode_json(read_bytes(path, SIZE_LIMIT), location=Location(path), keys_once=True)
    if not _fits(found, _SHAPE) and not _fits(found, _TIMED_SHAPE):
        hint = "'dineros find', 'verify' and 'check' write some with --certificate"
        raise CertificateFileError("holds no certificate", location=Location(path), hint=hint)
    return dict(found)


def write_certificate(certificate: Mapping[str, Any], path: Path) -> None:
    """Write a certificate completely or not at all."""
    write_atomically(path, json.dumps(certificate, indent=1, ensure_ascii=False).encode() + b"\n")


def sealed(certificate: Mapping[str, Any]) -> dict[str, Any]:
    """Return a certificate with the digest of its content."""
    says = {name: value for name, value in certificate.items() if name != "digest"}
    return {**says, "digest": _digest(says)}


def subject_as(model: pn.Net, signals: str, overflow: str, is_timed: bool = False) -> Subject:
    """Return the net of a model to which a certificate refers."""
    if is_timed:
        if signals == BASE:
            return timed_base_subject(model, overflow)  # type: ignore[arg-type]
        return timed_subject_of(model, signals, overflow)  # type: ignore[arg-type]
    if signals == BASE:
        return base_subject(model, overflow)  # type: ignore[arg-type]
    return subject_of(model, signals, overflow)  # type: ignore[arg-type]


def net_digest(subject: Subject) -> str:
    """Return a digest of places, tokens, transitions and arcs; also of intervals and priorities, if any."""
    net = subject.net
    tables: tuple[ArcTable, ...] = (net.pre, net.post, net.inhibitor)
    more: list[object] = []
    if isinstance(subject, TimedSubject):
        timed = subject.timed
        tables = (timed.take, timed.put, net.pre, net.inhibitor)
        more = [list(map(str, timed.intervals)), timed.above]
    arcs = [[table.row(t) for t in range(len(net.transitions))] for table in tables]
    return _digest([net.places, net.initial.tolist(), net.transitions, arcs, *more])


def difference(certificate: Mapping[str, Any], subject: Subject) -> str:
    """Return how a certificate differs from one for this net; empty if it is for this net and unchanged."""
    if certificate["digest"] != sealed(certificate)["digest"]:
        return "it was changed after it was written"
    return "" if certificate["net"] == net_digest(subject) else "it belongs to another net"


def _digest(value: object) -> str:
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def _fits(found: Any, shape: Any) -> bool:
    match shape:
        case [one]:
            return isinstance(found, list) and all(_fits(part, one) for part in found)
        case {"": one}:
            return isinstance(found, dict) and all(_fits(part, one) for part in found.values())
        case dict():
            has_names = isinstance(found, dict) and found.keys() == shape.keys()
            return has_names and all(_fits(found[name], shape[name]) for name in shape)
        case frozenset():
            return type(found) in (str, int) and found in shape
    return type(found) is shape
