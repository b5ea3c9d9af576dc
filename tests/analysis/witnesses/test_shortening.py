"""Ways to growth without what they do not need: replayed, and each firing of them is needed."""

from __future__ import annotations

import random
from itertools import count

import pytest

from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.witness import replay
from dineros.analysis.witnesses import shortening
from dineros.analysis.witnesses.findings import pumping_witness
from dineros.analysis.witnesses.shortening import shortened
from dineros.metamodel import pn


def random_walk(seed: int) -> tuple[CompiledNet, list[int]]:
    """Return a net with inhibitor arcs, and a run of it."""
    rng = random.Random(seed)
    places = [f"p{number}" for number in range(6)]
    transitions = [
        Transition(
            f"t{number}",
            dict.fromkeys(rng.sample(places, rng.randint(1, 2)), 1),
            dict.fromkeys(rng.sample(places, rng.randint(1, 2)), rng.randint(1, 2)),
            dict.fromkeys(rng.sample(places, rng.randint(0, 1)), rng.randint(1, 4)),
        )
        for number in range(7)
    ]
    net = CompiledNet.build(dict.fromkeys(places, 1), transitions)
    marking, run = net.initial.tolist(), list[int]()
    while len(run) < 60 and (able := [t for t in range(7) if net.is_enabled(t, marking)]):
        run.append(rng.choice(able))
        marking = net.fire(run[-1], marking)
    return net, run


def is_part(part: list[int], whole: list[int]) -> bool:
    rest = iter(whole)
    return all(t in rest for t in part)


@pytest.mark.parametrize("seed", range(60))
def test_the_rest_can_fire_and_needs_each_firing(seed: int) -> None:
    net, run = random_walk(seed)
    way, then = run[: len(run) * 2 // 3], run[len(run) * 2 // 3 :]
    short = list(shortened(net, way, then))
    replay(net, [*short, *then])
    assert is_part(short, way)
    for left_out in range(len(short)):
        with pytest.raises(Exception, match="not enabled"):
            replay(net, [*short[:left_out], *short[left_out + 1 :], *then])


def test_most_ways_are_shorter() -> None:
    lengths = [(len(run) * 2 // 3, run, net) for net, run in map(random_walk, range(60)) if len(run) == 60]
    shorter = [len(shortened(net, run[:cut], run[cut:])) < cut for cut, run, net in lengths]
    assert len(shorter) > 10
    assert sum(shorter) > len(shorter) / 2


def test_a_way_to_growth_has_no_detour() -> None:
    """What fires before, and what else goes on, is left out."""
    net = CompiledNet.build(
        {"start": 1, "ready": 0, "other": 1, "grows": 0},
        [
            Transition("begin", {"start": 1}, {"ready": 1}),
            Transition("turn", {"other": 1}, {"other": 1}),
            Transition("grow", {"ready": 1}, {"ready": 1, "grows": 1}),
        ],
    )
    pumping = Pumping((1, 1, 0, 1, 2, 1), (2,), (3,))
    witness = pumping_witness(Subject(pn.Net(id="net"), net), pumping)
    assert [step.transition for step in witness.steps] == ["begin", "grow"]
    assert witness.loop == 1


def test_long_ways_take_a_limited_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(shortening, "MOST_FIRINGS", 500)
    for seed in count():
        net, run = random_walk(seed)
        if len(run) == 60:
            break
    short = shortened(net, run[:50], run[50:])
    replay(net, [*short, *run[50:]])
