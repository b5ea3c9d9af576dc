"""Directed search: forward from the initial marking, guided by the state equation.

Best-first search by the number of firings so far plus a multiple of a lower bound of the firings still
needed: in an unbounded net, it does not follow unbounded growth, which brings it no nearer to the target. It
finds a firing sequence, not necessarily a shortest one. If it ends without one, all markings were visited,
and the target is unreachable.

References
----------
M. Blondin, C. Haase, P. Offtermatt, *Directed reachability for infinite-state systems*, TACAS 2021, LNCS
12652.
"""

from __future__ import annotations

from heapq import heappop, heappush
from math import inf

from dineros.analysis.answers.budget import Budget, Progress
from dineros.analysis.covering.distance import CoveringPrograms, Distance
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import way_to

MOST_MARKINGS = 100_000
"""Maximum number of markings stored for one target."""

PULL = 3
"""Number of firings that is worth one firing less in the distance to the target."""

REPORTED = 2_000
"""Number of markings between progress reports."""

MARKING_BYTES = 300
"""Approximate bytes of a stored marking besides its tokens."""


class Directed:
    """Searches in a net, one for each target; they share the linear programs."""

    def __init__(self, net: CompiledNet) -> None:
        self._net = net
        self._programs = CoveringPrograms(net)
        count = range(len(net.transitions))
        self._needs = [net.pre.row(t) for t in count]
        self._inhibitors = [net.inhibitor.row(t) for t in count]
        self._changes = [list(change.items()) for change in net.delta]

    def way_to(
        self, transition: int, budget: Budget, most: int = MOST_MARKINGS
    ) -> tuple[tuple[int, ...] | None, bool]:
        """Search for a marking that enables a transition, with at most this number of stored markings.

        Parameters and result are those of `dineros.analysis.covering.backward.Backward.way_to`, except memory
        and states of the budget.
        """
        distance = Distance(self._programs, dict(self._needs[transition]))
        start = tuple(self._net.initial.tolist())
        seen, markings, parents, depths = {start}, [start], [(-1, -1)], [0]
        bounds = [distance.of(start)]
        queue, told = [(0.0, 0, False)], 0
        while queue:
            if budget.is_over:
                return None, False
            if budget.progress is not None and len(markings) > told + REPORTED:
                told = len(markings)
                budget.progress(Progress("markings", told, told * (MARKING_BYTES + 8 * len(start))))
            _, node, is_best = heappop(queue)
            marking, depth = markings[node], depths[node]
            if self._enables(transition, marking):
                return (*way_to(parents, node), transition), True
            if not is_best:
                # Only few markings are expanded, so the program is solved only for these.
                ahead = distance.best(marking)
                if ahead == inf:
                    continue
                if ahead > bounds[node]:
                    bounds[node] = ahead
                    heappush(queue, (depth + PULL * ahead, node, True))
                    continue
            for t in range(len(self._needs)):
                if not self._enables(t, marking):
                    continue
                changed = list(marking)
                for place, tokens in self._changes[t]:
                    changed[place] += tokens
                after = tuple(changed)
                if after in seen:
                    continue
                seen.add(after)
                ahead = max(distance.of(after), bounds[node] - 1)
                if ahead < inf:
                    markings.append(after)
                    parents.append((node, t))
                    depths.append(depth + 1)
                    bounds.append(ahead)
                    heappush(queue, (depth + 1 + PULL * ahead, len(markings) - 1, False))
            if len(seen) > most:
                return None, False
        return None, True

    def _enables(self, transition: int, marking: tuple[int, ...]) -> bool:
        for place, weight in self._needs[transition]:
            if marking[place] < weight:
                return False
        return all(marking[place] < weight for place, weight in self._inhibitors[transition])
