"""What is analysed with time: a model compiled to a time Petri net."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from dineros.analysis.model.subject import FiringTime, Subject
from dineros.analysis.timed.nets import TimedNet, compile_timed_net
from dineros.analysis.timed.schedules import schedule
from dineros.metamodel import pn, sym
from dineros.transformations.flattening.bounding import bounded
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant


@dataclass(frozen=True)
class TimedSubject(Subject):
    """A time Petri net under analysis; `net` is the same net without its times."""

    timed: TimedNet = field(kw_only=True)

    def times_of(self, trace: Sequence[int]) -> Sequence[FiringTime | None]:
        """Return by firing of a sequence when it happens; each as early as it can.

        Raises
        ------
        WitnessError
            The sequence has no schedule.
        """
        return [
            FiringTime(float(one.at), float(one.earliest), None if one.latest is None else float(one.latest))
            for one in schedule(self.timed, trace)
        ]


def timed_subject_of(
    model: pn.Net,
    signals: SignalVariant = "input-enabled",
    overflow: OverflowVariant = "weighted",
) -> TimedSubject:
    """Flatten a system model, and compile it with its times; compile any other net.

    Raises
    ------
    DinerosError
        An interval is empty or negative; see `compile_timed_net`.
    """
    flattened = flatten(model, signals, overflow) if isinstance(model, sym.SystemModel) else None
    timed = compile_timed_net(bounded(model) if flattened is None else flattened.net)
    return TimedSubject(model, timed.untimed, flattened, timed=timed)
