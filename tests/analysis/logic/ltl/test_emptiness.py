"""The search for an accepting run: what it decides in compiled code."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.analysis.logic.ltl.fairness import InnerGraph
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet


def stairs(steps: int) -> CompiledNet:
    """Return a net that goes up some steps; at each one, a switch goes on and off, and `go` needs it on."""
    return CompiledNet.build(
        {"left": steps, "on": 0, "off": 1},
        [
            ("press", {"off": 1}, {"on": 1}),
            ("release", {"on": 1}, {"off": 1}),
            ("go", {"left": 1, "on": 1}, {"on": 1}),
        ],
    )


def test_small_components_without_a_fair_run_are_rejected_in_compiled_code(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[int] = []
    of = InnerGraph.of

    def counted(*given: Any) -> InnerGraph:
        asked.append(1)
        return of(*given)

    monkeypatch.setattr(InnerGraph, "of", counted)
    verdict = verify_ltl(stairs(500), "F left == 0", strong=["go"])
    assert (verdict.status, len(asked)) == ("holds", 0)


def test_a_component_with_a_fair_run_is_found_among_those_without() -> None:
    """At the last step, the switch can stay off while something else goes on."""
    net = CompiledNet.build(
        {"left": 20, "on": 0, "off": 1},
        [
            ("press", {"off": 1}, {"on": 1}),
            ("release", {"on": 1}, {"off": 1}),
            ("go", {"left": 1, "on": 1}, {"on": 1}),
            ("rest", {"off": 1}, {"off": 1}, {"left": 2}),
        ],
    )
    verdict = verify_ltl(net, "F left == 0", strong=["go"])
    assert verdict.status == "violated"
    assert [net.transitions[t] for t in verdict.loop] == ["rest"]
    assert [net.transitions[t] for t in verdict.stem].count("go") == 19
    assert verify_ltl(net, "F left == 0", strong=["go", "press"]).status == "holds"
