"""Response times and latencies of a system model, exact, and what they rest on.

The response time of a callback goes from its release (a strike of its timer, or the arrival of a message or
request) to its end. The latency of a chain goes from the release of its first callback, or the publication of
its first topic, to the end of its last callback, or the publication of its last topic.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.histories import histories_of
from dineros.analysis.latencies.instances import Instance, longest_instance
from dineros.analysis.latencies.markers import Asks
from dineros.analysis.latencies.measuring import Bound, Measured, measured
from dineros.analysis.latencies.observer import Observer
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.latencies.paths import (
    Path,
    callback_pages,
    callbacks_in_no_time,
    missing_on,
    paths_between,
    responses_of,
    shares_clocks,
)
from dineros.analysis.latencies.results import Everything, Latency
from dineros.analysis.latencies.sampling import NotFollowedError
from dineros.analysis.latencies.starvation import Starvation
from dineros.analysis.timed.exploring import Explored, explore_timed
from dineros.analysis.timed.timed_subject import TimedSubject, timed_base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import channels, label, node_net_of, node_nets, resolve
from dineros.metamodel.errors import DinerosError, near_matches
from dineros.metamodel.guards.using import require_no_guards
from dineros.metamodel.matching import is_best_effort
from dineros.metamodel.times.given import duration_of, require_known, says_times, waits
from dineros.metamodel.times.orders import is_ignored
from dineros.metamodel.times.overlaps import runs_overlapping
from dineros.metamodel.times.runs import ports_at

End = sym.CallbackPage | sym.TopicChannel

_OF_CHAINS: tuple[Asks, ...] = ("reaction", "age")
RELEASED = {sym.CallbackKind.timer, sym.CallbackKind.subscriber, sym.CallbackKind.server}
"""Callbacks that are released by messages from other nodes."""
OF_ENGINES = {sym.CallbackKind.timer, sym.CallbackKind.subscriber}
"""Those of them whose response times are known in nodes of the execution `net`."""


def require_times(model: sym.SystemModel, *, with_guards: bool = False) -> None:
    """Refuse a model whose times cannot be asked for.

    `with_guards`: whether it may have guards: bounds follow them, and exact times do not.

    Raises
    ------
    DinerosError
        It has another middleware, no times, or guards.
    """
    if not with_guards:
        require_no_guards(model, "an analysis of exact latencies")
    if model.middleware != sym.Middleware.ros2:
        hint = "set middleware to ros2"
        raise DinerosError("latencies are defined for ROS 2 only", hint=hint, element=model.id)
    require_known(model)
    if not says_times(model):
        hint = "give durations to callbacks, and latencies to topics and services"
        raise DinerosError("the model has no times", hint=hint, element=model.id)


class Latencies:
    """Answers how long data takes through a system model.

    Parameters
    ----------
    model : sym.SystemModel
        A model of the middleware ``ros2``.
    budget : Budget
        Limits of all searches together.
    subject : TimedSubject, optional
        The net with its times, if it is there already.

    Attributes
    ----------
    explored : Explored
        The markings and firings of the net.

    Raises
    ------
    DinerosError
        The model runs on another middleware, does not say how long anything takes, or says something of time
        that no rule obeys.
    """

    def __init__(self, model: sym.SystemModel, budget: Budget, subject: TimedSubject | None = None) -> None:
        require_times(model)
        self.model = model
        self._budget = budget.begun()
        self.subject: TimedSubject = subject or timed_base_subject(model)
        self.explored: Explored = explore_timed(self.subject.timed, self._budget)
        self._parts = Parts(self.subject)
        self._starvation = Starvation(self._parts, self.explored, self._budget)
        self._is_exact = not any(_is_widened(page) for page in callback_pages(model)) and all(
            len(service.clients) <= 1 for service in channels(model, sym.ServiceChannel)
        )
        # Latencies of actions begin again when a thread is not free (rule D11).
        self._is_exact &= not channels(model, sym.ActionChannel)
        # Other orders than those of an executor may take longer.
        self._is_exact &= not any(is_ignored(node) for node in node_nets(model))
        self._is_exact &= not callbacks_in_no_time(model)

    @property
    def reason(self) -> str:
        """Why the markings are not all known, without which nothing is measured; empty if they are."""
        return self.explored.reason

    def between(self, first: End, last: End, *, with_ages: bool = True) -> Latency:
        """Return how long data takes from a callback or topic to another one, on any way.

        Parameters
        ----------
        first, last
            Where it begins, and where it ends.
        with_ages
            Whether the reaction time and the data age are measured, too.
        """
        paths = paths_between(self.model, first, last)
        if not paths:
            raise DinerosError(
                f"no data flows from {named(first)} to {named(last)}",
                hint="data flows from a callback through a topic to the callbacks that take its messages, "
                "and through a place of a node to the callbacks that read the place; "
                "requests, responses, goals, results and feedback are not followed",
            )
        found = self._measured(paths)
        if found.reason or not with_ages:
            return found
        if len(paths) > 1:
            several = f"data takes {len(paths)} ways"
            return replace(found, reasons=dict.fromkeys(_OF_CHAINS, several))
        if not all(runs_callbacks(node_net_of(page)) for page in paths[0].callbacks):
            engine = "a node on the way has the execution net, through which only latencies are followed"
            return replace(found, reasons=dict.fromkeys(_OF_CHAINS, engine))
        if unsure := next((hop for hop in paths[0].topics if is_best_effort(hop.writer, hop.reader)), None):
            assert unsure.writer.channel is not None
            lost = f"topic {unsure.writer.channel.topic} is best effort, so all of its messages may be lost"
            return replace(found, reasons=dict.fromkeys(_OF_CHAINS, lost))
        if starving := next((page for page in paths[0].callbacks if self.starves(page)), None):
            # Then no further output comes, so nothing bounds either.
            return replace(found, reasons=dict.fromkeys(_OF_CHAINS, _starved(starving)))
        longest = {asks: self._longest(paths[0], asks) for asks in _OF_CHAINS}
        reasons = {str(asks): reason for asks, (_, reason) in longest.items() if reason}
        return replace(found, reaction=longest["reaction"][0], age=longest["age"][0], reasons=reasons)

    def _longest(self, path: Path, asks: Asks) -> tuple[Bound | None, str]:
        """Return the longest reaction time or data age of a path, or None and why it is not known."""
        observer = Observer(self._parts, self.explored, path, asks)
        found = measured(observer, self.subject.timed, self._budget)
        reason = found.reason
        if found.is_gone:
            reason = reason or "a callback on the way need not publish"
        elif not observer.is_exact:
            reason = reason or "not all data on the way can be distinguished"
        elif asks == "reaction" and found.is_lost:
            # A reaction follows a newer message, but not one that a publisher loses.
            reason = reason or "data on the way can be displaced by other data than that of the chain"
        elif found.greatest is None:
            reason = reason or ("no output is replaced" if asks == "age" else "no output follows")
        return None if reason else found.greatest, reason

    def starves(self, page: sym.CallbackPage) -> bool | None:
        """Return whether a callback can be ready forever without starting; None: unknown."""
        missing = any(True for path in responses_of(page) for _ in missing_on(path))
        return None if self.reason or missing else self._starvation.of(page)

    def response(self, page: sym.CallbackPage) -> Latency:
        """Return the response time of a callback."""
        return self._measured(responses_of(page))

    def longest_instance(self, first: End, last: End | None, found: Latency) -> Instance | None:
        """Return a run with the instance that takes longest; None if it is not found within the budget.

        Parameters
        ----------
        first, last
            As for `between`; without `last`, the callback `first` alone.
        found
            The answer, with a greatest time.
        """
        if found.greatest is None:
            return None
        if last is not None:
            paths = paths_between(self.model, first, last)
        else:
            assert isinstance(first, sym.CallbackPage)
            paths = responses_of(first)
        observers = (Observer(self._parts, self.explored, path) for path in paths)
        shown = (
            longest_instance(each, self.subject.timed, found.greatest, self._budget) for each in observers
        )
        return next((each for each in shown if each is not None), None)

    def everything(self) -> Everything:
        """Return all response times, and what can be lost."""
        found = Everything(is_exact=self._is_exact)
        if self.reason:
            return found
        for page in callback_pages(self.model):
            node = node_net_of(page)
            if runs_callbacks(node) and page.kind in RELEASED:
                found.callbacks[page.id] = self.response(page)
                found.starved[page.id] = self.starves(page)
            elif not runs_callbacks(node) and page.kind in OF_ENGINES:
                found.callbacks[page.id] = self.response(page)
        names = self.subject.timed.untimed.transitions
        fired = {names[t] for t in self.explored.ways}
        for name, history in histories_of(self.subject.links()).items():
            found.readers[name] = history.longest(self.explored), bool(fired & history.drops)
        for page, loses in self._parts.lost_ticks.items():
            found.timers[page.id] = loses in fired
        return found

    def _starving(self, path: Path) -> Iterator[str]:
        """Yield the timers of a path that can wait without end; messages that wait are displaced in time."""
        for page in path.callbacks:
            is_run = runs_callbacks(node_net_of(page))
            if is_run and page.kind == sym.CallbackKind.timer and self.starves(page):
                yield _starved(page)

    def _measured(self, paths: list[Path]) -> Latency:
        if self.reason:
            missing = next((each for path in paths for each in missing_on(path)), "")
            return Latency(None, None, None, False, missing or self.reason)
        found: list[tuple[Measured, bool]] = []
        for path in paths:
            if mixed := next(filter(_is_mixed, path.callbacks), None):
                reason = f"runs of callback {label(mixed)} overlap and wait, so they cannot be distinguished"
                return Latency(None, None, None, False, reason)
            try:
                observer = Observer(self._parts, self.explored, path)
            except NotFollowedError as error:
                reason = str(error) or "the analysis does not support a part of the chain"
                return Latency(None, None, None, False, reason)
            missing = next(missing_on(path), "") or next(self._starving(path), "")
            answer = measured(observer, self.subject.timed, self._budget, missing)
            found.append((answer, observer.is_exact))
        least = [each.least for each, _ in found if each.least is not None]
        greatest = [each.greatest for each, _ in found if each.greatest is not None]
        is_bounded = all(each.is_complete and not each.reason for each, _ in found)
        reason = next((each.reason for each, _ in found if each.reason), "")
        return Latency(
            min(least, key=lambda b: (b.value, not b.is_reached), default=None),
            max(greatest, key=lambda b: (b.value, b.is_reached), default=None) if is_bounded else None,
            # A run that takes longer than the clock is not followed to its end.
            True if any(each.is_lost for each, _ in found) else False if is_bounded else None,
            self._is_exact and all(is_exact for _, is_exact in found) and is_bounded,
            reason,
            sum(each.states for each, _ in found),
        )


def _starved(page: sym.CallbackPage) -> str:
    node = node_net_of(page)
    if node is not None and node.lifecycle is not None and node.lifecycle.pauses:
        return f"callback {label(page)} can wait without end, as its node may stay inactive"
    return f"callback {label(page)} can starve, because others run first"


def _is_mixed(page: sym.CallbackPage) -> bool:
    """Return whether runs of a callback are at the same places of the net while they wait."""
    return page.kind != sym.CallbackKind.server and runs_overlapping(page) > 1 and waits(page)


def _is_widened(page: sym.CallbackPage) -> bool:
    """Return whether the net lets a callback take times that the model does not allow.

    Each stretch between two waits takes any time up to the whole duration. Overlapping runs share clocks. The
    last steps of a server with parallel branches come at any moment of its work (rule D3), so what it
    publishes may come too early.
    The net does not keep the order of requests of several clients either, so the bounds are safe then, too.
    """
    has_stretches = (
        waits(page)
        and duration_of(page) is not None
        and any(each.interval is None for each in Body(page).transitions)
    )
    return has_stretches or shares_clocks(page) or _tells_at_the_end(page)


def _tells_at_the_end(page: sym.CallbackPage) -> bool:
    """Return whether last steps of a server with parallel branches publish, or send requests."""
    body = Body(page)
    if page.kind != sym.CallbackKind.server or duration_of(page) is None or body.is_sequential:
        return False
    return any(
        not isinstance(port, sym.ServerPort)
        for end in body.ends()
        if end.interval is None
        for place in (resolve(arc.target) for arc in end.outgoing)
        if isinstance(place, pn.Place)
        for port in ports_at(place)
    )


def named(end: End) -> str:
    """Return how messages call an end of a chain."""
    return f"topic {end.topic}" if isinstance(end, sym.TopicChannel) else f"callback {label(end)}"


def end_of(model: sym.SystemModel, name: str) -> End:
    """Return the callback or topic of a name: an id, the name of a callback, or a topic.

    Raises
    ------
    DinerosError
        There is none, or there are several.
    """
    found: list[End] = [page for page in callback_pages(model) if name in (page.id, page.name)]
    topics = channels(model, sym.TopicChannel)
    found += [topic for topic in topics if name in (topic.id, topic.topic, f"/{topic.topic}")]
    exact = [each for each in found if each.id == name]
    if len(exact) == 1:
        return exact[0]
    if len(found) == 1:
        return found[0]
    known = [each.id for each in callback_pages(model)] + [t.topic for t in topics]
    if not found:
        raise DinerosError(f"no callback or topic is called {name}", hint=near_matches(name, known))
    raise DinerosError(
        f"{name} names {len(found)} callbacks or topics",
        hint="their ids are " + ", ".join(str(each.id) for each in found),
    )
