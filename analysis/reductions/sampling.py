"""A few reachable markings, to see at once that many proofs cannot succeed.

Linear programs cost milliseconds each. A transition that has been seen to fire is not excluded, and a place
or an inhibitor arc that has been seen to disable a transition alone is not implied.
"""

from __future__ import annotations

import random

from dineros.analysis.reductions.net import MutableNet

#: Markings that a walk visits.
STEPS = 200


class Sample:
    """What a random walk saw. It has a fixed seed, so that reductions can be repeated.

    Attributes
    ----------
    enabled : set of str
        Transitions that were enabled.
    deciding_places : set of str
        Places that alone disabled a transition.
    deciding_inhibitors : set of (str, str)
        Inhibitor arcs, as place and transition, that alone disabled the transition.
    """

    def __init__(self, net: MutableNet) -> None:
        self.enabled: set[str] = set()
        self.deciding_places: set[str] = set()
        self.deciding_inhibitors: set[tuple[str, str]] = set()
        chance = random.Random(0)
        marking = dict(net.places)
        for _ in range(STEPS):
            ready = self._look(net, marking)
            if ready:
                net.fire(chance.choice(ready), marking)
            elif marking == net.places:
                break
            else:
                marking = dict(net.places)

    def _look(self, net: MutableNet, marking: dict[str, int]) -> list[str]:
        ready = []
        for t, arcs in net.transitions.items():
            missing = [p for p, weight in arcs.inputs.items() if marking[p] < weight]
            if len(missing) > 1:
                continue
            blocking = [p for p, weight in arcs.inhibitors.items() if marking[p] >= weight]
            if not missing and not blocking:
                ready.append(t)
            elif not blocking:
                self.deciding_places.add(missing[0])
            elif not missing and len(blocking) == 1:
                self.deciding_inhibitors.add((blocking[0], t))
        self.enabled.update(ready)
        return ready
