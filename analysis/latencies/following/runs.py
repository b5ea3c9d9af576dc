"""The runs on executors that an observer may follow: where they begin and end, and their places."""

from __future__ import annotations

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet
from dineros.analysis.latencies.parts import Parts, Run
from dineros.analysis.timed.exploring import Explored


class FollowedRuns:
    """Distinguishes a run that is followed from others in a net.

    `net`: the net; it gets the places of the run that is followed.
    """

    def __init__(self, net: EditedNet, parts: Parts, explored: Explored) -> None:
        self._net, self._parts, self._explored = net, parts, explored

    def beginnings(self, run: Run) -> list[str]:
        """Return the transitions that begin a run."""
        return [name for name in self._net.cases if self._begun(name, run) > 0]

    def endings(self, run: Run) -> list[str]:
        """Return the transitions that end a run."""
        return [name for name in self._net.cases if self._begun(name, run) < 0]

    def _begun(self, name: str, run: Run) -> int:
        firing = self._net.original(name)
        return sum(firing.put.get(place, 0) - firing.take.get(place, 0) for place in run.places)

    def color_clock(self, run: Run) -> None:
        """Give the run that is followed a clock of its own."""
        for name in (run.clock_begin, run.clock_end):
            free = frozenset({run.clock_free})
            self._net.split(name, [PLAIN, self.case(run, drop=free)])

    def clock_moves(self, run: Run) -> set[str]:
        """Return the transitions that start and stop clocks of such runs."""
        return {run.clock_begin, run.clock_end, *run.other_clocks}

    def case(self, run: Run, **more: object) -> Case:
        """Return a case of a transition of the run that is followed."""
        names: dict[str, str] = {}
        if run.is_colored:
            for place in sorted(self.own(run)):
                names[place] = f"observer of {place}"
                if names[place] not in self._net.places:
                    self._net.place(names[place])
        return Case(rename=names, **more)  # type: ignore[arg-type]

    def own(self, run: Run) -> set[str]:
        """Return the places that hold nothing but tokens of runs: they are empty where there is none."""
        if not run.is_colored:
            return set()
        if run.known_own is None:
            index = {name: at for at, name in enumerate(self._explored.net.untimed.places)}
            markings = self._explored.markings
            none = markings[markings[:, [index[place] for place in run.places]].sum(axis=1) == 0]
            ports = {
                source
                for names in self._parts.published.values()
                for publish in names
                for source in self._net.original(publish).take
            }
            run.known_own = {
                place for place in run.own if place not in ports and not none[:, index[place]].any()
            }
        return run.known_own
