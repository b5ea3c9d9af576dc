"""Finds the divergence of two traces."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any

from dineros.views.traces.building import TraceBuilder
from dineros.views.traces.steps import Step


@dataclass(frozen=True)
class Divergence:
    """The first steps that differ.

    Attributes
    ----------
    a, b : int
        Their indices in both traces; the length of a trace that ends there.
    node : str or None
        Of runs: the node whose steps differ.
    """

    a: int
    b: int
    node: str | None = None

    def to_json(self) -> dict[str, Any]:
        """Return it for the page."""
        return dict(vars(self))


def first_divergence(a: TraceBuilder, b: TraceBuilder) -> Divergence | None:
    """Return the divergence of two traces; None if there is none.

    Witnesses are compared step by step. The nodes of a run are not synchronised, so each node is compared
    with itself in the other run, and the earliest difference is returned.
    """
    runs = [builder.header is not None and builder.header.kind == "run" for builder in (a, b)]
    if not all(runs):
        return _parting(list(enumerate(a.steps)), list(enumerate(b.steps)), len(a.steps), len(b.steps), None)
    found = []
    for node in dict.fromkeys([*a.nodes, *b.nodes]):
        mine, theirs = _of_node(a, node), _of_node(b, node)
        parting = _parting(mine, theirs, len(a.steps), len(b.steps), node)
        if parting is not None:
            found.append(parting)
    return min(found, key=lambda one: (one.a, one.b), default=None)


def _of_node(builder: TraceBuilder, node: str) -> list[tuple[int, Step]]:
    """Return a node's steps; its start is a step only if another node had started before."""
    return [
        (index, step)
        for index, step in enumerate(builder.steps)
        if step.node == node and (step.event not in ("start", "checkpoint") or step.details.get("resumed"))
    ]


def _parting(
    a: list[tuple[int, Step]], b: list[tuple[int, Step]], end_a: int, end_b: int, node: str | None
) -> Divergence | None:
    for (index, mine), (other, theirs) in zip(a, b, strict=False):
        if _what(mine) != _what(theirs):
            return Divergence(index, other, node)
    if len(a) == len(b):
        return None
    common = min(len(a), len(b))
    return Divergence(
        a[common][0] if common < len(a) else end_a, b[common][0] if common < len(b) else end_b, node
    )


def _what(step: Step) -> Hashable:
    """Return the effect of a step, without times and ids of tokens."""
    return step.event, step.node, step.transition, step.text, tuple(sorted(step.change.items()))
