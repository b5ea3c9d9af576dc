"""An observer that follows one instance through a timed net, with a clock that measures how long it takes.

The observer is part of the net: places say where the instance is, and transitions are split by that. So
any explorer of time Petri nets can measure. The observer chooses any instance: a strike of a timer, or a
message or request that arrives.

Tokens of a history are alike, but messages have an order. So the observer counts the messages before the one
that it follows: in a reader's history, and between a publisher and that history, where messages arrive in the
order in which they were sent. A full history forgets its oldest message.

To measure how old data is, the observer continues until the next output replaces that of the instance. To
measure how fast a chain reacts, it starts the clock at a release and follows the next one: what happens just
after a release is in that one. There, a message that is displaced leaves its place to the next one, if what
displaces it is always newer data of the chain.

References
----------
M. Günzel et al., *On the equivalence of maximum reaction time and maximum data age for cause-effect chains*,
ECRTS 2023.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet, Firing
from dineros.analysis.latencies.following.engines import FollowedEngine, require_plain
from dineros.analysis.latencies.following.messages import FollowedMessages, StartOfInstance
from dineros.analysis.latencies.following.requests import follow_requests
from dineros.analysis.latencies.following.runs import FollowedRuns
from dineros.analysis.latencies.markers import (
    ARMED,
    DONE,
    GO,
    IDLE,
    LOST,
    NOW,
    OVER,
    SHOWN,
    WATCHING,
    Asks,
    exactly,
    only,
    some,
)
from dineros.analysis.latencies.parts import Parts, Run
from dineros.analysis.latencies.paths import Hop, Path, Way, has_only_newer
from dineros.analysis.latencies.sampling import NotFollowedError, displaced, place_of_value, require_steady
from dineros.analysis.latencies.stores import Stored
from dineros.analysis.timed.exploring import Explored
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import runs_callbacks
from dineros.metamodel.elements import label, node_net_of, resolve
from dineros.metamodel.times.runs import most_put

WATCH = "observer watch"


class Observer:
    """Adds an observer of a path to a net.

    Parameters
    ----------
    explored : Explored
        Its markings: how many messages there can be.
    path : Path
        What is followed.
    asks : {"latency", "age", "reaction"}
        What is measured.

    Raises
    ------
    NotFollowedError
        The path goes through something that is not followed.
    """

    def __init__(self, parts: Parts, explored: Explored, path: Path, asks: Asks = "latency") -> None:
        self._parts, self._path, self._explored, self._asks = parts, path, explored, asks
        self._net = EditedNet(parts.subject.timed)
        for place in (ARMED, WATCHING, SHOWN, DONE, LOST, OVER):
            self._net.place(place)
        self._net.place(IDLE, 1)
        self._net.place(GO, 1)
        self._is_exact = True
        self._start = StartOfInstance({IDLE: 1}, {WATCHING: 1})
        if asks == "reaction":
            arms = [Case(take={IDLE: 1}, put={WATCHING: 1, ARMED: 1})]
            self._start = StartOfInstance({ARMED: 1}, {}, Case(inhibit={ARMED: 1}), arms)
        self._runs = FollowedRuns(self._net, parts, explored)
        self._messages = FollowedMessages(self._net, parts, explored, self._start)
        self._arrives: dict[str, Any] = {"take": {GO: 1}, "put": {DONE: 1}}
        if asks == "age":
            self._arrives = {"take": {}, "put": {SHOWN: 1}}
        for number, page in enumerate(path.callbacks):
            self._follow(number, page)
        if asks == "age":
            for name in self._outputs():
                replaced = Case(take={SHOWN: 1, GO: 1}, put={DONE: 1})
                self._net.split(name, [Case(inhibit={SHOWN: 1}), replaced])

    @property
    def is_exact(self) -> bool:
        """Whether what it measures can happen, and nothing else."""
        return self._is_exact and self._messages.is_exact

    def original(self, name: str) -> str | None:
        """Return the transition of the net without the observer that a transition stands for, if any."""
        name = self._net.originals().get(name, name)
        return name if name in self._parts.subject.timed.untimed.transitions else None

    def net(self, limit: Fraction, *, is_whole: bool = False) -> TimedNet:
        """Return the net, with a clock that ends after so long.

        Parameters
        ----------
        limit
            In seconds.
        is_whole
            Whether it has the parts, too, that have no influence on what is followed.
        """
        self._net.cases.pop(WATCH, None)
        self._net.add(
            Firing(WATCH, {WATCHING: 1}, {OVER: 1}, {}, {}, Interval(limit, limit)),
        )
        return self._net.compiled((DONE, LOST, OVER, WATCHING), GO, (WATCH,), is_whole=is_whole)

    def _outputs(self) -> list[str]:
        """Return the transitions by which the path ends, whatever their data is."""
        if self._path.last is not None:
            return list(self._parts.published[self._path.last])
        return [
            name for run in self._parts.runs_of(self._path.callbacks[-1]) for name in self._runs.endings(run)
        ]

    def _follow(self, number: int, page: sym.CallbackPage) -> None:
        path = self._path
        is_first = number == 0
        comes, goes = path.before(number), path.after(number)
        sends = path.last if goes is None else goes.writer if isinstance(goes, Hop) else goes
        if not runs_callbacks(node_net_of(page)):
            self._engine(number, page, comes, sends)
            return
        runs = self._parts.runs_of(page)
        if not runs:
            raise NotFollowedError
        mine = {id(run): self._net.place(f"observer {number} runs {at}") for at, run in enumerate(runs)}
        unsent = self._net.place(f"observer {number} unsent")
        begun = {id(run): {mine[id(run)]: 1, **({unsent: 1} if sends is not None else {})} for run in runs}
        if isinstance(comes, Stored):
            self._sample(number, comes, runs)
        elif page.kind == sym.CallbackKind.timer:
            self._tick(number, page, runs[0], begun[id(runs[0])])
        elif page.kind == sym.CallbackKind.server:
            self._serve(number, page, begun)
        else:
            self._take(number, page, runs[0], begun[id(runs[0])], is_first)
        for run in runs:
            self._run(number, run, mine[id(run)], unsent, sends, comes)
        if sends is not None:
            self._net.add(
                Firing(
                    f"observer {number} nothing sent",
                    {unsent: 1, GO: 1, WATCHING: 1},
                    {},
                    {},
                    dict.fromkeys(mine.values(), 1),
                    NOW,
                )
            )
        if isinstance(sends, sym.PublisherPort):
            assert not isinstance(goes, Stored)
            self._send(number, sends, goes)

    def _engine(
        self, number: int, page: sym.CallbackPage, comes: Way | None, sends: sym.PublisherPort | Stored | None
    ) -> None:
        """Follow a tick or a message through a node of the execution `net`."""
        if self._asks != "latency" or isinstance(comes, Stored) or isinstance(sends, Stored):
            raise NotFollowedError(f"the node of callback {label(page)} has the execution net")
        require_plain(page)
        target, goes = "", self._path.after(number)
        if sends is not None:
            target = only([s for each in self._parts.published[sends] for s in self._messages.sources(each)])
        engine = FollowedEngine(self._net, self._parts, self._explored, number, page, target, self._arrives)
        if page.kind == sym.CallbackKind.timer:
            engine.start(*self._strike(number, page))
        else:
            self._take(number, page, engine, {}, number == 0)
        if sends is not None:
            assert not isinstance(goes, Stored)
            self._send(number, sends, goes)

    def _strike(self, number: int, page: sym.CallbackPage) -> tuple[str, str]:
        """Begin at a strike of a timer; return the place where its tick is due, and the marker of that."""
        if page not in self._parts.ticks:
            raise NotFollowedError
        tick, due = self._parts.ticks[page]
        waits = self._net.place(f"observer {number} due")
        follows = Case(take=self._start.begins, put={**self._start.measures, waits: 1})
        self._net.split(tick, [self._start.plain, *self._start.arms, follows])
        return due, waits

    def _tick(self, number: int, page: sym.CallbackPage, run: Run, begun: dict[str, int]) -> None:
        """Follow a timer from a strike to the beginning of its callback."""
        due, waits = self._strike(number, page)
        beginnings = self._runs.beginnings(run)
        for name in self._net.consumers(due):
            follows = Case(take={waits: 1, WATCHING: 1, GO: 1}, put={LOST: 1})  # its node leaves
            if name in beginnings:
                follows = self._runs.case(run, take={waits: 1}, put=begun)
            self._net.split(name, [Case(inhibit={waits: 1}), follows])
        if any(due not in self._net.original(begin).take for begin in beginnings):
            raise NotFollowedError

    def _serve(self, number: int, page: sym.CallbackPage, begun: dict[int, dict[str, int]]) -> None:
        """Follow a request from its arrival to the beginning of the callback that serves it."""
        service = only([each for each in self._parts.requests if each.server.page is page])
        if tired := next((each for each in service.clients if each.timeout), None):
            raise NotFollowedError(
                f"client {tired.client} of service {service.service} can give up while its request waits"
            )
        places = self._parts.requests[service]
        self._is_exact &= len(places) == 1 and self._asks != "reaction"
        runs = [(run, begun[id(run)]) for run in self._parts.runs_of(page)]
        for place in places:
            follow_requests(self._net, self._runs, runs, place, self._most(place))

    def _take(
        self,
        number: int,
        page: sym.CallbackPage,
        run: Run | FollowedEngine,
        begun: dict[str, int],
        is_first: bool,
    ) -> None:
        """Follow a message from its arrival, or its publication, to the beginning of its callback."""
        path, net = self._path, self._net
        is_released_here = is_first and not path.begins_with_message
        hop = None if is_released_here else path.before(number)
        assert not isinstance(hop, Stored)
        reader = path.reader if hop is None else hop.reader
        if reader is None or reader not in self._parts.histories:
            raise NotFollowedError
        queue = self._parts.histories[reader]
        ahead, waits = net.place(f"observer {number} ahead"), net.place(f"observer {number} waits")
        arrived = net.place(f"observer {number} arrived")
        received = self._parts.received[reader]
        if hop is not None:
            self._messages.pipe(number, hop, received, arrived, is_first)
        comes = self._start.begins if hop is None else {arrived: 1}
        stays: dict[str, int] = {waits: 1, **(self._start.measures if hop is None else {})}
        first = self._start.plain if hop is None else Case(inhibit={arrived: 1})
        others = self._start.arms if hop is None else [Case(read={arrived: 1, received: 1})]
        lost = Case(take={waits: 1, WATCHING: 1, GO: 1}, put={LOST: 1}, inhibit={ahead: 1})
        if self._next_is_newer(number):
            lost = Case(read={waits: 1}, inhibit={ahead: 1})
        most = self._most(queue.load)
        entrance = only(queue.entrances)
        net.split(
            entrance.enter,
            [
                first,
                *others,
                *(
                    Case(take=comes, put=some(stays, ahead, k), **exactly(queue.load, k))
                    for k in range(most + 1)
                ),
            ],
        )
        net.split(
            entrance.drop,
            [
                Case(inhibit={waits: 1, **(first.inhibit if hop is None else {arrived: 1})}),
                *others,
                Case(take=comes, put=some(stays, ahead, reader.limit - 1)),
                Case(read={waits: 1}, take={ahead: 1}),
                lost,
            ],
        )
        if isinstance(run, FollowedEngine):
            assert queue.leave is not None, "its messages are taken"
            (sink,) = (place for place in net.original(queue.leave).put if place in self._sinks(reader))
            run.take(queue.leave, sink, waits, ahead, (entrance.enter, entrance.drop))
            return
        begin = only([each for each in self._runs.beginnings(run) if each == queue.leave])
        for name in net.consumers(queue.load):
            follows = Case(take={waits: 1, WATCHING: 1, GO: 1}, put={LOST: 1}, inhibit={ahead: 1})
            if name == begin:
                follows = self._runs.case(run, take={waits: 1}, put=begun, inhibit={ahead: 1})
            net.split(name, [Case(inhibit={waits: 1}), Case(read={waits: 1}, take={ahead: 1}), follows])

    def _sinks(self, reader: sym.SubscriberPort) -> list[str]:
        place = resolve(reader.place)
        return self._parts.places[place] if isinstance(place, pn.Place) else []

    def _send(self, number: int, writer: sym.PublisherPort, hop: Hop | None) -> None:
        """Make the observer follow publications that a run has put on the place of a publisher."""
        for publish in self._parts.published[writer]:
            source = only(self._messages.sources(publish))
            followed = f"observer {number} sends {source}"
            if followed not in self._net.places:
                continue
            if hop is None:
                ends = Case(rename={source: followed}, **self._arrives)
                self._net.split(publish, [PLAIN, ends])
            else:
                self._messages.publish(hop, number + 1, [({}, {}, {source: followed})], publish)

    def _sample(self, number: int, comes: Stored, runs: Sequence[Run]) -> None:
        """Follow a value from where it is stored to the first run that reads it; `_run` lets it be read."""
        place, marker = self._value(number, comes)
        lost = Case(take={marker: 1, WATCHING: 1, GO: 1}, put={LOST: 1})
        self._is_exact &= displaced(
            self._net, self._parts, comes, place, marker, lost, self._next_is_newer(number)
        )
        told_apart = {name for run in runs for name in (*run.moves, *self._runs.endings(run))}
        for run in runs:
            require_steady(self._net, self._explored, run, place, sorted(told_apart & self._net.cases.keys()))

    def _next_is_newer(self, number: int) -> bool:
        """Return whether a reaction shows in what displaces the data that comes to a callback, too."""
        return self._asks == "reaction" and has_only_newer(self._path, number)

    def _value(self, number: int, stored: Stored) -> tuple[str, str]:
        """Return the place of a value that callback `number` reads, and the marker of that one."""
        marker = f"observer {number} stored"
        if marker not in self._net.places:
            self._net.place(marker)
        return place_of_value(self._parts, self._explored, stored), marker

    def _run(
        self,
        number: int,
        run: Run,
        mine: str,
        unsent: str,
        sends: sym.PublisherPort | Stored | None,
        comes: Way | None,
    ) -> None:
        """Follow a run from its beginning, or from what it reads, to its end, or to what it leaves.

        Each transition gets cases for a run that is followed, and one for others.
        """
        net = self._net
        sources: dict[str, str] = {}
        """Where the run leaves what is followed, by the place where it leaves what is not."""
        if isinstance(sends, Stored):
            sources = dict([self._value(number + 1, sends)])
        elif sends is not None:
            found = {s for publish in self._parts.published[sends] for s in self._messages.sources(publish)}
            sources = {source: f"observer {number} sends {source}" for source in found}
        value, stored = self._value(number, comes) if isinstance(comes, Stored) else ("", "")
        ends = set(self._runs.endings(run))
        once = sends is None or most_put(run.page, sends.place) == 1
        own = self._runs.own(run)
        touching = set(self._runs.clock_moves(run)) if run.is_colored else set()
        for name in list(net.cases):
            if name.startswith("observer "):
                continue
            firing = net.original(name)
            tells = [place for place in firing.put if place in sources] if name in run.moves else []
            is_end = name in ends
            needs = {*firing.take, *firing.read, *firing.inhibit}
            is_inside = name not in touching and bool(own & needs)
            samples = value in {*firing.take, *firing.read} and name in run.moves | run.starts
            if not (tells or is_end or is_inside or samples):
                continue
            stops = is_end and sends is None and run.page is self._path.callbacks[-1]
            arrives = self._arrives if stops else {"take": {}, "put": {}}
            leaves = self._leaves(tells, sources, isinstance(sends, Stored))
            # A run that is followed already.
            held = {} if run.is_colored else {mine: 1}
            take = {mine: 1, **arrives["take"]} if is_end else {}
            read = {} if is_end else held
            cases = [PLAIN if run.is_colored else Case(inhibit=held)]
            if leaves is None:
                cases.append(self._runs.case(run, read=read, take=take, put=arrives["put"]))
            else:
                first = {"take": {**take, unsent: 1}, "put": leaves.put, "instead": leaves.instead}
                cases.append(self._runs.case(run, read=read, **first))
                cases.append(self._runs.case(run, read=read, take=take, inhibit={unsent: 1} if once else {}))
            if samples:
                # A run that is followed from here on. Any run may be the last one that reads the value.
                if self._asks != "age":
                    cases[0] = Case(inhibit={**held, stored: 1})
                take = {stored: 1, **(arrives["take"] if is_end else {})}
                put = dict(arrives["put"]) if is_end else {mine: 1}
                if leaves is None:
                    leaves = Case(put={unsent: 1} if sends is not None else {})
                cases.append(Case(take=take, put={**put, **leaves.put}, instead=leaves.instead))
            net.split(name, cases)
        if run.is_colored and run.busy:
            self._runs.color_clock(run)

    def _leaves(self, tells: Sequence[str], sources: dict[str, str], is_stored: bool) -> Case | None:
        """Return the effect of a transition that publishes or stores the followed data; None for others."""
        if not tells:
            return None
        told = only(tells)
        followed = sources[told]
        if followed not in self._net.places:
            self._net.place(followed)
        return Case(put={followed: 1}) if is_stored else Case(instead={told: followed})

    def _most(self, place: str) -> int:
        at = self._explored.net.untimed.places.index(place)
        return int(self._explored.markings[:, at].max())
