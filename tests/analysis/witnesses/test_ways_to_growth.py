"""Ways to growth leave out what they do not need; what repeats can still fire after them."""

from __future__ import annotations

import random

from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.coverability import Pumping
from dineros.analysis.nets.witness import replay
from dineros.analysis.witnesses.witness import pumping_witness
from dineros.metamodel import pn


def random_growth(seed: int) -> tuple[CompiledNet, Pumping] | None:
    """Return a net with inhibitor arcs, and a run of it in which tokens grow; None if the run shows none."""
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
    markings, run = [net.initial.tolist()], list[int]()
    while len(run) < 60 and (able := [t for t in range(7) if net.is_enabled(t, markings[-1])]):
        run.append(rng.choice(able))
        markings.append(net.fire(run[-1], markings[-1]))
    for end in range(len(run), 10, -1):
        for begin in range(end - 1, 4, -1):
            grown = tuple(p for p in range(6) if markings[end][p] > markings[begin][p])
            if grown and all(a >= b for a, b in zip(markings[end], markings[begin], strict=True)):
                return net, Pumping(tuple(run[:begin]), tuple(run[begin:end]), grown)
    return None


def test_what_repeats_still_fires_after_a_shorter_way() -> None:
    lengths = []
    for net, pumping in filter(None, map(random_growth, range(150))):
        witness = pumping_witness(Subject(pn.Net(id="net"), net), pumping)
        fired = [net.transitions.index(step.transition) for step in witness.steps]
        replay(net, fired)
        assert witness.loop is not None
        assert fired[witness.loop :] == list(pumping.suffix)
        lengths.append((witness.loop, len(pumping.prefix)))
    assert len(lengths) > 20
    assert all(new <= old for new, old in lengths)
    assert sum(new < old for new, old in lengths) > len(lengths) / 2


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
