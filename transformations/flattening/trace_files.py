"""Saves a trace next to its net: an XMI file with links to elements in the files of both models."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.metamodel.files import save
from dineros.transformations.flattening.traces import Link, Trace


def trace_path(net: Path) -> Path:
    """Return the path of a net's trace: ``sorting.trace.xmi`` for ``sorting.pnm``."""
    return net.with_suffix(".trace.xmi")


def save_trace(trace: Trace, source: Path, target: Path, *, changed: bool = False) -> Path:
    """Write a trace next to the net and return its file.

    Links refer to elements by id, in all formats of the two models. In TINA's format arcs have no ids, so the
    trace of a ``.net`` omits arcs.

    Parameters
    ----------
    trace : Trace
        The links; both models must have been read from their files or written to them.
    source, target : Path
        The files of the two models.
    changed : bool
        Whether the source model was changed after it was read. New elements are in no file, so links refer to
        the nearest enclosing element instead.

    Raises
    ------
    ModelFileError
        The file cannot be written.
    """
    path = trace_path(target)
    links = [link for link in trace if target.suffix.lower() != ".net" or not isinstance(link.target, pn.Arc)]
    model = Trace(_with_sources(link, _in_file if changed else _itself) for link in links)
    save(model.to_model(source.name, target.name), path)
    return path


def _with_sources(link: Link, named: Callable[[EObject], EObject]) -> Link:
    sources = tuple(dict.fromkeys(named(source) for source in link.sources))
    return replace(link, sources=sources)


def _itself(element: EObject) -> EObject:
    return element


def _in_file(element: EObject) -> EObject:
    """Return the nearest enclosing element, or this element itself, that was read from the file."""
    inner: EObject | None = element
    while inner is not None and "_location" not in inner.__dict__:
        inner = inner.eContainer()
    return element if inner is None else inner
