"""Engines that are wrong, so that others can find them out: each misses what one transition does."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from dineros.analysis import explicit
from dineros.analysis.logic.graphs import stored
from dineros.analysis.nets.compiled import ArcTable, CompiledNet
from dineros.analysis.symbolic.levels import encode


def without_last_transition(net: CompiledNet) -> CompiledNet:
    """Return a net whose last transition by name never fires: it takes what is not there."""
    rows = [dict(net.pre.row(t)) for t in range(len(net.transitions))]
    last = net.transitions.index(max(net.transitions))
    rows[last] = {p: k + 1_000 for p, k in rows[last].items()}
    return replace(net, pre=ArcTable.from_rows(rows))


def break_diagrams(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let diagrams be those of a net in which one transition never fires."""

    def wrong(net: CompiledNet, *rest: Any) -> Any:
        return encode(without_last_transition(net), *rest)

    monkeypatch.setattr("dineros.analysis.symbolic.engine.encode", wrong)


def break_search(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let explicit search be that of a net in which one transition never fires."""
    explore, graph = explicit.explore, stored.StateGraph

    def less(net: CompiledNet, *rest: Any, **more: Any) -> Any:
        return explore(without_last_transition(net), *rest, **more)

    def smaller(net: CompiledNet, *rest: Any) -> Any:
        return graph(without_last_transition(net), *rest)

    monkeypatch.setattr(explicit, "explore", less)
    monkeypatch.setattr(stored, "StateGraph", smaller)
