"""What is analysed with time: a model compiled to a time Petri net."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from dineros.analysis.model.subject import FiringTime, Subject, flattened_without_signals
from dineros.analysis.model.times import UsedTimes
from dineros.analysis.timed.nets import Interval, TimedNet, compile_timed_net
from dineros.analysis.timed.schedules import schedule
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import transitions
from dineros.metamodel.guards.using import require_no_guards
from dineros.metamodel.times.given import says_times
from dineros.transformations.flattening.bounding import bounded

if TYPE_CHECKING:
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant


@dataclass(frozen=True)
class TimedSubject(Subject):
    """A time Petri net under analysis; `net` is the same net without its times."""

    timed: TimedNet = field(kw_only=True)

    @property
    def is_timed(self) -> bool:
        """Runs need one."""
        return True

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

    @property
    def used_times(self) -> UsedTimes:
        """The intervals, as reports name them; an example has a latest bound if any has one."""
        named = list(zip(self.timed.untimed.transitions, self.timed.intervals, strict=True))
        timed = [pair for pair in named if not pair[1].is_free]
        bounded = [pair for pair in timed if pair[1].latest is not None]
        name, interval = (bounded or timed or named)[0]
        return UsedTimes(len(timed), f"{name} {interval}", str(self.timed.unit))


def timed_subject_of(
    model: pn.Net,
    signals: SignalVariant = "input-enabled",
    overflow: OverflowVariant = "weighted",
) -> TimedSubject:
    """Flatten a system model, and compile it with its times; compile any other net.

    The rules about times run if the model says how long anything takes.

    Raises
    ------
    DinerosError
        An interval is empty or negative; see `compile_timed_net`.
    """
    require_no_guards(model, "an analysis with times")
    flattened = None
    if isinstance(model, sym.SystemModel):
        from dineros.transformations.flattening.flatten import flatten

        flattened = flatten(model, signals, overflow, times=says_times(model))
    timed = compile_timed_net(bounded(model) if flattened is None else flattened.net)
    return TimedSubject(model, timed.untimed, flattened, timed=timed)


def timed_base_subject(
    model: pn.Net, overflow: OverflowVariant = "weighted", times: bool | None = None
) -> TimedSubject:
    """Compile what a check asks about: the net without signals where these change nothing in time.

    A signal may change at any time. So a transition with a clause and without an interval or a priority fires
    at the same moments without signals. Where another transition has a clause, its clock starts and stops
    with the signals: then they are part of the net, and may change at any time (``fully-enabled``).

    Parameters
    ----------
    model
        The model.
    overflow
        How a full queue drops.
    times
        Whether the rules about times run. If not given, they run where the model says how long anything
        takes.

    Raises
    ------
    DinerosError
        An interval is empty or negative; see `compile_timed_net`.
    """
    require_no_guards(model, "an analysis with times")
    if not isinstance(model, sym.SystemModel):
        return timed_subject_of(model)
    if signals_matter(model):
        return timed_subject_of(model, "fully-enabled", overflow)
    has_times = says_times(model) if times is None else times
    flattened, blocked = flattened_without_signals(model, overflow, has_times)
    timed = compile_timed_net(flattened.net)
    return TimedSubject(model, timed.untimed, flattened, blocked, timed=timed)


def signals_matter(model: sym.SystemModel) -> bool:
    """Whether a transition that has a clause also has an interval or a priority, or may get an interval."""
    gets_intervals = model.middleware == sym.Middleware.ros2 and says_times(model)
    return any(
        transition.clause is not None
        and (gets_intervals or not Interval.of(transition.interval).is_free or bool(transition.overrides))
        for transition in transitions(model)
        if isinstance(transition, sym.Transition)
    )
