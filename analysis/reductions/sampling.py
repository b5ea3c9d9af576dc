"""A sample of reachable markings, which shows at once that many proofs cannot succeed.

Linear programs take milliseconds each. A transition that was seen to fire is not excluded, and a place or an
inhibitor arc that was seen to disable a transition alone is not implied.
"""

from __future__ import annotations

import random
from collections.abc import Iterable
from weakref import WeakKeyDictionary

from dineros.analysis.reductions.net import MutableNet

#: Markings that a walk visits.
STEPS = 200

_SAMPLES: WeakKeyDictionary[MutableNet, tuple[int, Sample]] = WeakKeyDictionary()


def sampled(net: MutableNet) -> Sample:
    """Return the sample of the current net, cached until the net changes."""
    changes, sample = _SAMPLES.get(net, (-1, None))
    if sample is None or changes != net.changes:
        sample = Sample(net)
        _SAMPLES[net] = net.changes, sample
    return sample


class Sample:
    """The results of a random walk with a fixed seed, so that reductions are reproducible.

    Attributes
    ----------
    deciding_places : set of str
        Places that alone disabled a transition.
    deciding_inhibitors : set of (str, str)
        Inhibitor arcs, as place and transition, that alone disabled the transition.
    """

    def __init__(self, net: MutableNet) -> None:
        self.enabled: set[str] = set()
        self.deciding_places: set[str] = set()
        self.deciding_inhibitors: set[tuple[str, str]] = set()
        self._transitions = list(net.transitions.items())
        number = {t: n for n, (t, _) in enumerate(self._transitions)}
        arcs = net.transitions.values()
        most = len(arcs), sum(map(bool, net.consumers.values())), sum(len(each.inhibitors) for each in arcs)
        concerned = {p: [number[t] for t in (*net.consumers[p], *net.inhibited[p])] for p in net.places}
        gains: dict[int, dict[str, int]] = {}
        chance = random.Random(0)
        marking, ready = dict(net.places), set[int]()
        self._look(range(len(number)), marking, ready)
        at_first = set(ready)
        for _ in range(STEPS - 1):
            if (len(self.enabled), len(self.deciding_places), len(self.deciding_inhibitors)) == most:
                break
            if ready:
                fired = chance.choice(sorted(ready))
                if fired not in gains:
                    gains[fired] = self._transitions[fired][1].delta
                for place, tokens in gains[fired].items():
                    marking[place] += tokens
                self._look({n for place in gains[fired] for n in concerned[place]}, marking, ready)
            elif marking == net.places:
                break
            else:
                marking, ready = dict(net.places), set(at_first)

    def _look(self, numbers: Iterable[int], marking: dict[str, int], ready: set[int]) -> None:
        """Update the enabling of some transitions, and the results."""
        for number in numbers:
            name, arcs = self._transitions[number]
            missing = [p for p, weight in arcs.inputs.items() if marking[p] < weight]
            blocking = [p for p, weight in arcs.inhibitors.items() if marking[p] >= weight]
            if not missing and not blocking:
                ready.add(number)
                self.enabled.add(name)
                continue
            ready.discard(number)
            if len(missing) == 1 and not blocking:
                self.deciding_places.add(missing[0])
            elif not missing and len(blocking) == 1:
                self.deciding_inhibitors.add((blocking[0], name))
