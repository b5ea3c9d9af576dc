"""Delays with their own clocks: several delays of one kind can run at the same time."""

from __future__ import annotations

from collections.abc import Mapping

from dineros.metamodel import pn
from dineros.metamodel.base import EObject
from dineros.transformations.language import Expression, Fragment, Meaning, New
from dineros.transformations.rules.notation import arcs_at, place, transition


class Clock(Fragment):
    """One of several clocks for tokens under way between two places.

    Tokens are indistinguishable, so it makes no difference which clock ends first: the first arrival counts
    as the token that was sent first, and its latest arrival time is before that of the others.

    Parameters
    ----------
    id : str
        Prefix of the ids of its elements; may have placeholders.
    source, target : Expression
        The places.
    within : Expression
        The delay, as an interval.
    begins, runs, ends : str
        Descriptions of its parts.
    """

    roles: Mapping[str, type[EObject]] = {
        "free": pn.Place,
        "busy": pn.Place,
        "begin": pn.Transition,
        "end": pn.Transition,
        "source": pn.Place,
        "target": pn.Place,
    }
    free: New
    busy: New
    begin: New
    end: New

    def __init__(
        self, id: str, *, source: Expression, target: Expression, within: Expression, begins: str, runs: str,
        ends: str,
    ) -> None:  # fmt: skip
        super().__init__(source=source, target=target)
        self.free = place(
            f"{id}.free", tokens=1, means=Meaning(f"not: {runs}", part="idle clock", rests=True)
        )
        self.busy = place(f"{id}.busy", means=Meaning(runs, part="clock"), carries=True)
        self.begin = transition(f"{id}.begin", Meaning(begins), at_once=True)
        self.end = transition(f"{id}.end", Meaning(ends), within=within)
        self.arcs = [
            *arcs_at(self.begin, [source, self.free], [self.busy]),
            *arcs_at(self.end, [self.busy], [self.free, target]),
        ]
