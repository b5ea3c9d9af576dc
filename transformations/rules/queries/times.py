"""Queries about the times of callbacks, transitions and nodes: intervals, numbers of clocks, waits."""

from __future__ import annotations

from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import callback_page_of, runs_callbacks
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.times.given import (
    default_times,
    duration_of,
    period_of,
    reaction_of,
    runs_at_once,
    waits,
)
from dineros.metamodel.times.handlers import handled_until, is_kept_back
from dineros.metamodel.times.intervals import copied_interval, exactly
from dineros.metamodel.times.orders import keeps_order
from dineros.metamodel.times.overlaps import runs_overlapping
from dineros.metamodel.times.rates import publishes_without_end
from dineros.metamodel.times.shared import holds_for_all_runs, latest_holds_for_all_runs
from dineros.transformations.language import REAL, TRUTH, WHOLE, Query


class RunsCallbacks(Query):
    """Whether a page belongs to a node that runs callbacks."""

    datatype = TRUTH
    _words = "node of {} runs callbacks"

    @staticmethod
    def _answer(element: EObject) -> bool:
        return runs_callbacks(node_net_of(element))


class PublishesWithoutEnd(Query):
    """Whether a port may publish any number of messages in zero time."""

    datatype = TRUTH
    _words = "nothing bounds how many messages {0} publishes for {1} in no time"
    _answer = staticmethod(publishes_without_end)


class HasPeriod(Query):
    """Whether the period of a timer is given in the model, and not only assumed."""

    datatype = TRUTH
    _words = "the period of {} is given"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> bool:
        return period_of(page) is not None


class Period(Query):
    """The period of a timer, as an interval."""

    eclass = pn.TimeInterval
    _words = "[period of {0}, period of {0}]"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> pn.TimeInterval:
        return exactly(page.timer)


class Offset(Query):
    """Time of the first tick of a timer, as an interval."""

    eclass = pn.TimeInterval
    _words = "offset of {}, or [0, its period]"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> pn.TimeInterval | None:
        return copied_interval(page.offset) or pn.TimeInterval(earliest=0.0, latest=page.timer)


class Jitter(Query):
    """Maximum delay of a tick of a timer, as an interval from 0."""

    eclass = pn.TimeInterval
    _words = "[0, jitter of {}]"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> pn.TimeInterval:
        return pn.TimeInterval(earliest=0.0, latest=page.jitter)


class GivenDuration(Query):
    """Duration of one run of a callback; absent if it is not given."""

    eclass = pn.TimeInterval
    _words = "duration of {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> pn.TimeInterval | None:
        return copied_interval(duration_of(page))


class GoalDuration(Query):
    """Duration of the work on a goal, from 0 on if it may be canceled; absent if it is not given."""

    eclass = pn.TimeInterval
    _words = "duration of {0}; from 0 on if goals of {1} may be canceled"

    @staticmethod
    def _answer(page: sym.CallbackPage, action: sym.ActionChannel) -> pn.TimeInterval | None:
        found = copied_interval(duration_of(page))
        if found is not None and action.server.cancel is not None:
            found.earliest = 0.0
        return found


class WorksOnGoals(Query):
    """Whether a callback works on the goals of an action."""

    datatype = TRUTH
    _words = "{} works on goals"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> bool:
        return bool(page.kind == sym.CallbackKind.goal)


class HasDuration(Query):
    """Whether a callback has a duration, and does not wait."""

    datatype = TRUTH
    _words = "{} has a duration and never waits"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> bool:
        return duration_of(page) is not None and not waits(page)


class HasInterval(Query):
    """Whether a transition has a firing interval."""

    datatype = TRUTH
    _words = "{} has an interval"

    @staticmethod
    def _answer(transition: pn.Transition) -> bool:
        return transition.interval is not None


class Stretch(Query):
    """Maximum time that a waiting callback works between two waits; absent if it is not given."""

    datatype = REAL
    _words = "latest duration of {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> float | None:
        found = duration_of(page)
        return None if found is None else found.latest


class Waits(Query):
    """Whether a callback with a duration waits for a response before it ends."""

    datatype = TRUTH
    _words = "{} has a duration and waits"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> bool:
        return duration_of(page) is not None and waits(page)


class Moves(Query):
    """The transitions of a callback."""

    eclass = pn.Transition
    many = True
    _words = "transitions of {}"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> list[pn.Transition]:
        return Body(page).transitions


class RunsAtOnce(Query):
    """Maximum number of simultaneous runs of a callback."""

    datatype = WHOLE
    _words = "runs of {} at once; 1 of a slot of an action"

    @staticmethod
    def _answer(page: sym.CallbackPage) -> int:
        # Each slot has a copy of the page.
        return 1 if page.kind == sym.CallbackKind.goal else runs_overlapping(page)


class HoldsForAllRuns(Query):
    """Whether the interval of a transition holds, although several runs share its clock."""

    datatype = TRUTH
    _words = "the interval of {} holds for several runs with one clock"
    _answer = staticmethod(holds_for_all_runs)


class LatestHoldsForAllRuns(Query):
    """Whether the latest bound of an interval holds, although several runs share the clock."""

    datatype = TRUTH
    _words = "the latest bound of {} holds for several runs with one clock"
    _answer = staticmethod(latest_holds_for_all_runs)


class RunsOn(Query):
    """Maximum number of simultaneous runs of the callback around a place; 1 outside of callbacks."""

    datatype = WHOLE
    _words = "runs of the callback around {} at once"

    @staticmethod
    def _answer(place: pn.Place) -> int:
        page = callback_page_of(place)
        return 1 if page is None or page.kind == sym.CallbackKind.goal else runs_at_once(page)


class ReactsFrom(Query):
    """Minimum time that the engine of a node takes to fire."""

    datatype = REAL
    _words = "earliest reaction of {}"

    @staticmethod
    def _answer(node: sym.NodeNet) -> float:
        found = reaction_of(node)
        return 0.0 if found is None else found.earliest


class ReactsUntil(Query):
    """Maximum time that the engine of a node takes to fire; absent if it is not given."""

    datatype = REAL
    _words = "latest reaction of {}"

    @staticmethod
    def _answer(node: sym.NodeNet) -> float | None:
        found = reaction_of(node)
        return None if found is None else found.latest


class Reacts(Query):
    """Whether a transition fires within the reaction time of its node.

    It has no interval or duration, and no handler in flight can hold the tokens that it needs.
    """

    datatype = TRUTH
    _words = "{1} fires within the reaction of {0}"

    @staticmethod
    def _answer(node: sym.NodeNet, transition: pn.Node) -> bool:
        assert isinstance(transition, pn.Transition)
        if runs_callbacks(node) or reaction_of(node) is None or transition.interval is not None:
            return False
        if is_kept_back(transition):
            return False
        if not isinstance(transition, sym.Transition):
            return True
        return transition.duration is None and default_times(node).duration is None


class IsHandled(Query):
    """Whether a transition with a handler that takes time fires within a time."""

    datatype = TRUTH
    _words = "{1} of {0} fires within its reaction and duration"

    @staticmethod
    def _answer(node: sym.NodeNet, transition: pn.Node) -> bool:
        assert isinstance(transition, pn.Transition)
        return handled_until(node, transition) is not None


class HandledUntil(Query):
    """Maximum time from the moment that enables a transition until its handler has ended."""

    datatype = REAL
    _words = "latest reaction of {0} and latest duration of {1}"

    @staticmethod
    def _answer(node: sym.NodeNet, transition: pn.Node) -> float | None:
        assert isinstance(transition, pn.Transition)
        return handled_until(node, transition)


class Seconds(Query):
    """A number of seconds; 0 if there is none."""

    datatype = REAL
    _words = "{} or 0"

    @staticmethod
    def _answer(value: float | None) -> float:
        return 0.0 if value is None else float(value)


class KeepsOrder(Query):
    """Whether the executor of a node takes callbacks in a given order."""

    datatype = TRUTH
    _words = "{} takes callbacks in its order"
    _answer = staticmethod(keeps_order)
