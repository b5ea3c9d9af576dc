"""What is analysed with time: a model compiled to a time Petri net."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

from dineros.analysis.model.subject import FiringTime, Subject, flattened_without_signals
from dineros.analysis.model.times import UsedTimes
from dineros.analysis.nets.bounds import flows_and_bounds
from dineros.analysis.timed.nets import Interval, TimedNet, compile_timed_net
from dineros.analysis.timed.schedules import schedule
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.elements import pages, transitions
from dineros.metamodel.errors import GuardError
from dineros.metamodel.times.given import duration_of, says_times
from dineros.transformations.flattening.bounding import bounded
from dineros.transformations.flattening.coloured import RULE

if TYPE_CHECKING:
    from dineros.transformations.flattening.flatten import Flattened
    from dineros.transformations.rules.phases import OverflowVariant, SignalVariant


@dataclass(frozen=True)
class ScheduledSubject(Subject):
    """A net that is asked as one without times, although it has some: its runs are shown with a schedule.

    See `unforced_subject`.
    """

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

    @property
    def used_times(self) -> UsedTimes:
        """The intervals, as reports name them; an example has a latest bound if any has one."""
        named = list(zip(self.timed.untimed.transitions, self.timed.intervals, strict=True))
        timed = [pair for pair in named if not pair[1].is_free]
        bounded = [pair for pair in timed if pair[1].latest is not None]
        name, interval = (bounded or timed or named)[0]
        return UsedTimes(len(timed), f"{name} {interval}", str(self.timed.unit))


@dataclass(frozen=True)
class TimedSubject(ScheduledSubject):
    """A time Petri net under analysis; `net` is the same net without its times."""

    @property
    def is_timed(self) -> bool:
        """Runs need one."""
        return True


def unforced_subject(subject: TimedSubject) -> ScheduledSubject | None:
    """Return what is asked instead of a net in which nothing ever has to fire; None for other nets.

    Such a net can do with its times what it can do without; see `TimedNet.is_unforced`. Signals are left out:
    they may change at any time, so no clause disables anything permanently.
    """
    if not subject.timed.is_unforced:
        return None
    model, timed, flattened, blocked = subject.model, subject.timed, subject.flattened, subject.blocked
    if isinstance(model, sym.SystemModel) and signals_matter(model):
        flattened, blocked = flattened_without_signals(model, times=says_times(model))
        timed = replace(compile_timed_net(flattened.net), time_passes=True)
        if not timed.is_unforced:
            return None
    return ScheduledSubject(model, timed.untimed, flattened, blocked, timed=timed)


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
        An interval is empty or negative; see `compile_timed_net`. Guards and times do not go together; see
        `require_one_clock`.
    """
    flattened = None
    if isinstance(model, sym.SystemModel):
        from dineros.transformations.flattening.flatten import flatten

        flattened = flatten(model, signals, overflow, times=says_times(model))
    timed = compile_timed_net(bounded(model) if flattened is None else flattened.net)
    if flattened is not None:
        timed = replace(timed, time_passes=True)
        require_one_clock(timed, flattened)
    return TimedSubject(model, timed.untimed, flattened, timed=timed)


def timed_base_subject(model: pn.Net, overflow: OverflowVariant = "weighted") -> TimedSubject:
    """Compile what a check asks about: the net without signals where these change nothing in time.

    A signal may change at any time. So a transition with a clause and without an interval or a priority fires
    at the same moments without signals. If another transition has a clause, its clock starts and stops
    with the signals: then they are part of the net, and may change at any time (``fully-enabled``).

    Raises
    ------
    DinerosError
        An interval is empty or negative; see `compile_timed_net`. Guards and times do not go together; see
        `require_one_clock`.
    """
    if not isinstance(model, sym.SystemModel):
        return timed_subject_of(model)
    if signals_matter(model):
        return timed_subject_of(model, "fully-enabled", overflow)
    has_times = says_times(model)
    try:
        flattened, blocked = flattened_without_signals(model, overflow, has_times)
    except GuardError:
        if has_times:
            _require_unguarded_beginnings(model)
        raise
    timed = replace(compile_timed_net(flattened.net), time_passes=True)
    require_one_clock(timed, flattened)
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


def require_one_clock(timed: TimedNet, flattened: Flattened) -> None:
    """Refuse a net where variants of a transition, which guards make, would have clocks that differ.

    Each variant has a clock of its own. These are the clock of the transition where no variant stays enabled
    while another one fires, and none becomes enabled after another one. Both hold where all tokens that
    guards distinguish there are single, and a single token is consumed.

    Raises
    ------
    GuardError
        A transition has an interval, and guards distinguish tokens of which it may find several.
    """
    links = {link.target.id: link for link in flattened.trace}
    net = timed.untimed
    places = {id: number for number, id in enumerate(net.places)}
    whole = {
        places[term.place.id]: places[invariant.terms[0].place.id]
        for invariant in flattened.net.certificate
        for term in list(invariant.terms)[1:]
        if links[term.place.id].rule == RULE and links[invariant.terms[0].place.id].rule != RULE
    }
    variants = [
        number
        for number, (id, interval) in enumerate(zip(net.transitions, timed.intervals, strict=True))
        if links[id].values and not interval.is_free and interval.latest != 0
    ]
    if not variants:
        return
    _, bounds = net.once(flows_and_bounds)
    single = {place for place, bound in enumerate(bounds) if bound is not None and bound.value <= 1}
    for number in variants:
        needed = dict(net.pre.row(number))
        told_apart = {whole[place] for place in needed if place in whole}
        kept = {place for place, _ in net.post.row(number)}
        if told_apart <= single and any(place in single and place not in kept for place in needed):
            continue
        source = links[net.transitions[number]].sources
        id = getattr(source[0], "id", net.transitions[number]) if source else net.transitions[number]
        raise GuardError(
            f"transition {id} has an interval, and guards distinguish tokens of which it may find several",
            element=str(id),
            hint="give the places that it takes tokens from a capacity of 1",
        )


def _require_unguarded_beginnings(model: pn.Net) -> None:
    """Refuse a guard on what begins the callback of a timer that has a duration.

    Such a callback takes its tokens before the transition fires, so that a guard would ask about none.
    """
    for page in pages(model):
        if not isinstance(page, sym.CallbackPage) or page.kind != sym.CallbackKind.timer:
            continue
        if duration_of(page) is None:
            continue
        for start in Body(page).beginnings():
            if isinstance(start, sym.Transition) and start.guard is not None:
                raise GuardError(
                    f"transition {start.id} begins the callback of timer {page.id}, which has a duration, "
                    "and has a guard, which questions with time do not support",
                    element=start.id,
                    hint="put the guard on a later transition of the callback",
                )
