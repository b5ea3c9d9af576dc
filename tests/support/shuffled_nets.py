"""The same net with its elements in another order and with other names."""

from __future__ import annotations

import random

from dineros.analysis.nets.compiled import ArcTable, CompiledNet, Transition


def shuffled(net: CompiledNet, seed: int) -> CompiledNet:
    """Return a net with places and transitions in random order, all with random names."""
    dice = random.Random(seed)
    places, transitions = list(range(len(net.places))), list(range(len(net.transitions)))
    names = [f"n{number}" for number in range(len(places) + len(transitions))]
    for items in (places, transitions, names):
        dice.shuffle(items)
    name, others = names[: len(places)], names[len(places) :]

    def arcs(table: ArcTable, transition: int) -> dict[str, int]:
        return {name[place]: weight for place, weight in table.row(transition)}

    return CompiledNet.build(
        {name[place]: int(net.initial[place]) for place in places},
        [
            Transition(others[t], *(arcs(table, t) for table in (net.pre, net.post, net.inhibitor)))
            for t in transitions
        ],
    )
