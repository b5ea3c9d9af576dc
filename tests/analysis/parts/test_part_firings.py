"""What parts of a net prove about firings and deadlocks is what all its markings say."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.covering.firings import Firings
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.structure import never_possible
from dineros.analysis.nets.witness import replay
from dineros.analysis.parts.firings import decide_by_parts
from tests.analysis.covering.plain import plain_search
from tests.analysis.strategies import nets

MOST = 5_000


@st.composite
def nets_of_machines(draw: st.DrawFn) -> CompiledNet:
    """A net of state machines that exchange tokens by buffers, as nodes exchange messages.

    A buffer has room for a few tokens, or its tokens are lost where it is full; some machines test others.
    """
    places: dict[str, int] = {}
    rows: list[Transition] = []
    buffers = [f"buffer{n}" for n in range(draw(st.integers(1, 3)))]
    for name in buffers:
        size = draw(st.integers(1, 2))
        start = draw(st.integers(0, size))
        places |= {name: start, f"room of {name}": size - start}
    for machine in range(draw(st.integers(2, 4))):
        steps = [f"m{machine}.{n}" for n in range(draw(st.integers(2, 3)))]
        places |= {step: int(step == steps[0]) for step in steps}
        for number in range(draw(st.integers(2, 5))):
            source, target = (draw(st.sampled_from(steps)) for _ in range(2))
            inputs, outputs = {source: 1}, {target: 1}
            inhibitors: dict[str, int] = {}
            reads: dict[str, int] = {}
            kind = draw(st.sampled_from(["own", "puts", "takes", "drops", "tests", "forbids"]))
            buffer = draw(st.sampled_from(buffers))
            if kind == "puts":
                inputs[f"room of {buffer}"] = outputs[buffer] = 1
            elif kind == "takes":
                inputs[buffer] = outputs[f"room of {buffer}"] = 1
            elif kind == "drops":
                inhibitors[f"room of {buffer}"] = 1
            elif kind in ("tests", "forbids"):
                other = draw(st.sampled_from(sorted(places)))
                if other not in steps:
                    (reads if kind == "tests" else inhibitors)[other] = 1
            rows.append(Transition(f"t{machine}.{number}", inputs, outputs, inhibitors, reads))
    return CompiledNet.build(places, rows)


def compared(net: CompiledNet) -> Counter[str]:
    """Compare what parts tell with a plain search of the whole net; return how much is decided."""
    found = Firings(net=net)
    decide_by_parts(net, found, Budget(seconds=30))
    seen = plain_search(net, MOST)
    assert found.dead.isdisjoint(seen.enabled)
    assert found.dead.isdisjoint(found.traces)
    assert never_possible(net).isdisjoint(seen.enabled)
    assert not (found.has_no_deadlock and seen.has_deadlock)
    for t, trace in found.traces.items():
        assert trace[-1] == t and replay(net, trace)
    if found.deadlock is not None:
        last = replay(net, found.deadlock)[-1]
        assert not any(net.is_enabled(t, last) for t in range(len(net.transitions)))
    answers = Counter({"dead": len(found.dead), "fires": len(found.traces)})
    answers["open"] = len(net.transitions) - len(found.dead) - len(found.traces)
    answers["deadlock"] = found.deadlock is not None
    answers["no deadlock"] = found.has_no_deadlock
    answers["open deadlock"] = found.deadlock is None and not found.has_no_deadlock
    if seen.is_complete and answers["open"] == 0:
        assert set(found.traces) == seen.enabled
    return answers


def check_many(examples: int, strategy: st.SearchStrategy[CompiledNet]) -> Counter[str]:
    """Compare so many nets; return what was decided of all of them."""
    answers: Counter[str] = Counter()

    @settings(max_examples=examples, deadline=None)
    @given(strategy)
    def compare(net: CompiledNet) -> None:
        answers.update(compared(net))

    compare()
    return answers


def test_machines_with_buffers() -> None:
    answers = check_many(12, nets_of_machines())
    assert answers["open"] == answers["open deadlock"] == 0, answers


@pytest.mark.long
def test_more_machines_with_buffers() -> None:
    """All are decided, and none of the answers is trivial for all of them."""
    answers = check_many(60, nets_of_machines())
    assert answers["open"] == answers["open deadlock"] == 0, answers
    assert min(answers[kind] for kind in ("dead", "fires", "deadlock", "no deadlock")) > 5, answers


@pytest.mark.long
def test_nets_of_all_kinds() -> None:
    """Weights, and places without bounds, of which parts know nothing."""
    answers = check_many(60, nets())
    assert answers["dead"] + answers["fires"] > answers["open"], answers
