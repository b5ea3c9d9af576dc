"""Contracted local states: the expanded diagram is that of the given encoding."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic import saturation
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.levels import Encoding, encode
from dineros.analysis.symbolic.saturation import Diagram, DiagramMemoryError
from dineros.analysis.symbolic.stages.contraction import contracted
from dineros.analysis.symbolic.vector_sets import VectorSets
from tests.analysis import classic_nets as classic

MEMORY = 1 << 24

Transition = tuple[str, dict[str, int], dict[str, int]]


def machines(seed: int) -> CompiledNet:
    """State machines with steps alone, steps that look at another machine, and steps of two together."""
    dice = random.Random(seed)
    sizes = [dice.randint(2, 6) for _ in range(dice.randint(2, 3))]
    places = {f"m{m}s{s}": int(s == 0) for m, size in enumerate(sizes) for s in range(size)}
    transitions: list[Transition] = []

    def step(machine: int) -> tuple[str, str]:
        before, after = (dice.randrange(sizes[machine]) for _ in range(2))
        if dice.random() < 0.7:
            after = min(before + 1, sizes[machine] - 1)
        return f"m{machine}s{before}", f"m{machine}s{after}"

    for number in range(sum(sizes) + dice.randint(0, 6)):
        machine, other = dice.sample(range(len(sizes)), 2)
        before, after = step(machine)
        pre, post = {before: 1}, {after: 1}
        if dice.random() < 0.4:
            before, after = step(other)
            pre |= {before: 1}
            post |= {before if dice.random() < 0.5 else after: 1}
        transitions.append((f"t{number}", pre, post))
    return CompiledNet.build(places, transitions)


def saturated(encoding: Encoding) -> Diagram:
    diagram = Diagram(encoding, range(len(encoding.levels)), MEMORY)
    assert diagram.run()
    return diagram


def test_expanded_diagrams_hold_what_saturation_of_the_given_encoding_reaches() -> None:
    smaller = 0
    for seed in range(80):
        net = machines(seed)
        encoding = encode(net)
        contraction = contracted(encoding)
        if contraction is None:
            continue
        smaller += 1
        small = saturated(contraction.encoding)
        diagram = contraction.expanded(small)
        expected = saturated(encoding)
        counts = DiagramCounts(diagram)
        assert counts.vectors() == DiagramCounts(expected).vectors() == explore(net).markings, seed
        assert counts.vectors() == DiagramCounts(small).weighted(contraction.weights()), seed
        assert counts.seen() == DiagramCounts(expected).seen(), seed
        first = VectorSets(diagram).single([level.initial for level in encoding.levels])
        assert VectorSets(diagram).closure(first, diagram.root, False), seed
    assert smaller > 40


@pytest.mark.parametrize(
    ("transitions", "together"),
    [
        ([("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"c": 1})], True),
        ([("t", {"a": 1}, {"b": 1}), ("u", {"a": 1, "x": 1}, {"b": 1, "x": 1})], True),
        ([("t", {"a": 1}, {"b": 1}), ("u", {"a": 1, "x": 1}, {"a": 1, "y": 1})], True),
        # The other machine moves while the machine is in b.
        ([("t", {"a": 1}, {"b": 1}), ("u", {"b": 1, "x": 1}, {"b": 1, "y": 1})], False),
        # b is also reached from c.
        ([("t", {"a": 1}, {"b": 1}), ("u", {"c": 1}, {"b": 1})], False),
        # The step to b may also move the other machine, or needs it.
        ([("t", {"a": 1}, {"b": 1}), ("u", {"a": 1, "x": 1}, {"b": 1, "y": 1})], False),
        ([("t", {"a": 1, "x": 1}, {"b": 1, "x": 1})], False),
        # The machine is left together with the other one, in two ways.
        (
            [
                ("t", {"a": 1}, {"b": 1}),
                ("u", {"a": 1, "x": 1}, {"c": 1, "y": 1}),
                ("v", {"b": 1, "y": 1}, {"c": 1, "x": 1}),
            ],
            True,
        ),
    ],
)
def test_only_states_with_the_same_states_of_the_others_are_contracted(
    transitions: list[Transition], together: bool
) -> None:
    """a, b and c are one machine, x and y another."""
    places = {"a": 1, "b": 0, "c": 0, "x": 1, "y": 0}
    back = [("w", {"c": 1, "y": 1}, {"a": 1, "y": 1}), ("z", {"x": 1, "c": 1}, {"y": 1, "c": 1})]
    net = CompiledNet.build(places, [*transitions, *back])
    encoding = encode(net, keep=range(len(places)))
    contraction = contracted(encoding)
    number, level = next((k, level) for k, level in enumerate(encoding.levels) if 0 in level.places)
    a, b = (level.states.index(tuple(int(p == place) for p in level.places)) for place in range(2))
    if contraction is None:
        assert not together
        return
    states = contraction.of_state[number]
    assert (states[a] == states[b]) == together
    found = DiagramCounts(contraction.expanded(saturated(contraction.encoding))).vectors()
    assert found == explore(net).markings


def test_nets_without_steps_alone_stay_as_they_are() -> None:
    assert contracted(encode(classic.philosophers(3))) is None


def test_too_little_memory_for_the_expanded_diagram_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    places = {f"m{m}s{s}": int(s == 0) for m in range(3) for s in range(40)}
    steps: list[Transition] = [
        (f"t{m} {s}", {f"m{m}s{s}": 1}, {f"m{m}s{(s + 1) % 40}": 1}) for m in range(3) for s in range(40)
    ]
    contraction = contracted(encode(CompiledNet.build(places, steps)))
    assert contraction is not None
    small = saturated(contraction.encoding)
    assert DiagramCounts(contraction.expanded(small)).vectors() == 40**3
    monkeypatch.setattr(saturation, "SMALLEST_STORE", 64)
    small.memory = 1
    with pytest.raises(DiagramMemoryError):
        contraction.expanded(small)
