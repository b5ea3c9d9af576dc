"""An observer that follows one instance through a timed net, with a clock that measures how long it takes.

The observer is part of the net: places say where the instance is, and transitions are split by that. So
whatever explores time Petri nets can measure. The observer chooses any instance: a strike of a timer, or a
message or request that arrives.

Tokens of a history are alike, but messages have an order. So the observer counts the messages before the one
that it follows: in a reader's history, and between a publisher and that history, where messages arrive in the
order in which they were sent. A full history forgets its oldest message.

To measure how old data is, the observer continues until the next output replaces that of the instance. To
measure how fast a chain reacts, it starts the clock at a release and follows the next one: what happens just
after a release is in that one. There, a message that is displaced leaves its place to the next one, which
is newer.

References
----------
M. Günzel et al., *On the equivalence of maximum reaction time and maximum data age for cause-effect chains*,
ECRTS 2023.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any, Literal, TypeVar

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet, Firing
from dineros.analysis.latencies.parts import Parts, Run
from dineros.analysis.latencies.paths import Hop, Path, Way
from dineros.analysis.latencies.sampling import NotFollowedError, displaced, place_of_value, require_steady
from dineros.analysis.latencies.stores import Stored
from dineros.analysis.timed.exploring import Explored
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.metamodel import sym
from dineros.metamodel.times.runs import most_put

IDLE, ARMED, WATCHING, SHOWN, DONE, LOST, OVER, GO = (
    f"observer {word}" for word in ("idle", "armed", "watching", "shown", "done", "lost", "over", "go")
)
T = TypeVar("T")
Asks = Literal["latency", "age", "reaction"]
WATCH = "observer watch"
NOW = Interval(latest=Fraction(0))


def _only(found: Sequence[T]) -> T:
    if len(found) != 1:
        raise NotFollowedError
    return found[0]


class Observer:
    """Adds an observer of a path to a net.

    Parameters
    ----------
    parts : Parts
        The net.
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
        self.is_exact = True
        self._begins: dict[str, int] = {IDLE: 1}
        self._measures: dict[str, int] = {WATCHING: 1}
        self._plain, self._arms = PLAIN, list[Case]()
        if asks == "reaction":
            self._begins, self._measures = {ARMED: 1}, {}
            self._plain = Case(inhibit={ARMED: 1})
            self._arms = [Case(take={IDLE: 1}, put={WATCHING: 1, ARMED: 1})]
        self._arrives: dict[str, Any] = {"take": {GO: 1}, "put": {DONE: 1}}
        if asks == "age":
            self._arrives = {"take": {}, "put": {SHOWN: 1}}
        for number, page in enumerate(path.callbacks):
            self._follow(number, page)
        if asks == "age":
            for name in self._outputs():
                replaced = Case(take={SHOWN: 1, GO: 1}, put={DONE: 1})
                self._net.split(name, [Case(inhibit={SHOWN: 1}), replaced])

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
        return [name for run in self._parts.runs_of(self._path.callbacks[-1]) for name in self._endings(run)]

    def _follow(self, number: int, page: sym.CallbackPage) -> None:
        path = self._path
        is_first = number == 0
        comes, goes = path.before(number), path.after(number)
        sends = path.last if goes is None else goes.writer if isinstance(goes, Hop) else goes
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

    def _tick(self, number: int, page: sym.CallbackPage, run: Run, begun: dict[str, int]) -> None:
        """Follow a timer from a strike to the beginning of its callback."""
        if page not in self._parts.ticks:
            raise NotFollowedError
        tick, due = self._parts.ticks[page]
        waits = self._net.place(f"observer {number} due")
        follows = Case(take=self._begins, put={**self._measures, waits: 1})
        self._net.split(tick, [self._plain, *self._arms, follows])
        for begin in self._beginnings(run):
            if due not in self._net.original(begin).take:
                raise NotFollowedError
            follows = self._case(run, take={waits: 1}, put=begun)
            self._net.split(begin, [Case(inhibit={waits: 1}), follows])

    def _serve(self, number: int, page: sym.CallbackPage, begun: dict[int, dict[str, int]]) -> None:
        """Follow a request from its arrival to the beginning of the callback that serves it."""
        service = _only([each for each in self._parts.requests if each.server.page is page])
        places = self._parts.requests[service]
        self.is_exact &= len(places) == 1 and self._asks != "reaction"
        for at, place in enumerate(places):
            waits = self._net.place(f"observer {number} request {at}")
            for producer in self._net.producers(place):
                self._net.split(producer, [PLAIN, Case(take={IDLE: 1}, put={WATCHING: 1, waits: 1})])
            for run in self._parts.runs_of(page):
                for begin in self._beginnings(run):
                    if place in self._net.original(begin).take:
                        follows = Case(take={waits: 1}, put=begun[id(run)])
                        self._net.split(begin, [Case(inhibit={waits: 1}), follows])

    def _take(
        self, number: int, page: sym.CallbackPage, run: Run, begun: dict[str, int], is_first: bool
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
            self._pipe(number, hop, received, arrived, is_first)
        comes = self._begins if hop is None else {arrived: 1}
        stays: dict[str, int] = {waits: 1, **(self._measures if hop is None else {})}
        first = self._plain if hop is None else Case(inhibit={arrived: 1})
        others = self._arms if hop is None else [Case(read={arrived: 1, received: 1})]
        lost = Case(take={waits: 1, WATCHING: 1, GO: 1}, put={LOST: 1}, inhibit={ahead: 1})
        if self._asks == "reaction":
            lost = Case(read={waits: 1}, inhibit={ahead: 1})
        most = self._most(queue.load)
        entrance = _only(queue.entrances)
        net.split(
            entrance.enter,
            [
                first,
                *others,
                *(
                    Case(take=comes, put=_some(stays, ahead, k), **_exactly(queue.load, k))
                    for k in range(most + 1)
                ),
            ],
        )
        net.split(
            entrance.drop,
            [
                Case(inhibit={waits: 1, **(first.inhibit if hop is None else {arrived: 1})}),
                *others,
                Case(take=comes, put=_some(stays, ahead, reader.limit - 1)),
                Case(read={waits: 1}, take={ahead: 1}),
                lost,
            ],
        )
        begin = _only([each for each in self._beginnings(run) if each == queue.leave])
        net.split(
            begin,
            [
                Case(inhibit={waits: 1}),
                Case(read={waits: 1}, take={ahead: 1}),
                self._case(run, take={waits: 1}, put=begun, inhibit={ahead: 1}),
            ],
        )

    def _pipe(self, number: int, hop: Hop, received: str, arrived: str, is_first: bool) -> None:
        """Follow a message on its way to a history; `_send` puts it on the way."""
        if (hop.writer, hop.reader) not in self._parts.pipes:
            raise NotFollowedError
        net, pipe = self._net, self._parts.pipes[hop.writer, hop.reader]
        sent, ahead = net.place(f"observer {number} on the way"), net.place(f"observer {number} sooner")
        inside, landed = net.place(f"observer {number} sent"), net.place(f"observer {number} landed")
        if is_first:
            self._publish(hop, number, [(self._begins, self._measures, {})], is_first=True)
        for producer in net.producers(pipe.written):
            net.extend(producer, put={inside: 1})
        for exit_ in pipe.exits:
            net.redirect(exit_, received, landed)
        arrives = Firing(
            f"observer {number} arrives", {landed: 1, inside: 1}, {received: 1}, {}, {received: 1}, NOW
        )
        net.add(arrives)
        net.split(
            arrives.name,
            [
                Case(inhibit={sent: 1}),
                Case(read={sent: 1}, take={ahead: 1}),
                Case(take={sent: 1}, put={arrived: 1}, inhibit={ahead: 1}),
            ],
        )
        loses = [
            Case(inhibit={sent: 1}),
            Case(read={sent: 1}, take={ahead: 1}),
            Case(take={sent: 1, WATCHING: 1, GO: 1}, put={LOST: 1}, inhibit={ahead: 1}),
        ]
        if pipe.is_on_the_way:
            # Which message it is depends on how many are on their way; any of these is possible then.
            loses += [
                Case(read={sent: 1}),
                Case(take={sent: 1, WATCHING: 1, GO: 1}, put={LOST: 1}, read={ahead: 1}),
            ]
            names = self._explored.net.untimed.transitions
            self.is_exact &= names.index(pipe.drop) not in self._explored.ways
        net.split(pipe.drop, loses)
        net.extend(pipe.drop, take={inside: 1})

    def _send(self, number: int, writer: sym.PublisherPort, hop: Hop | None) -> None:
        """Make the observer follow publications that a run has put on the place of a publisher."""
        for publish in self._parts.published[writer]:
            source = _only(self._sources(publish))
            followed = f"observer {number} sends {source}"
            if followed not in self._net.places:
                continue
            if hop is None:
                ends = Case(rename={source: followed}, **self._arrives)
                self._net.split(publish, [PLAIN, ends])
            else:
                self._publish(hop, number + 1, [({}, {}, {source: followed})], publish)

    def _publish(
        self,
        hop: Hop,
        number: int,
        ways: Sequence[tuple[dict[str, int], dict[str, int], dict[str, str]]],
        only: str | None = None,
        is_first: bool = False,
    ) -> None:
        """Put a message on its way to callback `number`, behind those that are on it."""
        pipe = self._parts.pipes[hop.writer, hop.reader]
        index = self._explored.net.untimed.places
        inside = [index.index(place) for place in pipe.inside]
        most = int(self._explored.markings[:, inside].sum(axis=1).max())
        sent, ahead = f"observer {number} on the way", f"observer {number} sooner"
        counted = f"observer {number} sent"
        for publish in self._parts.published[hop.writer]:
            if only in (None, publish):
                cases = [
                    Case(
                        take=take,
                        put=_some({**put, sent: 1}, ahead, k),
                        rename=rename,
                        **_exactly(counted, k),
                    )
                    for take, put, rename in ways
                    for k in range(most + 1)
                ]
                others = [self._plain, *self._arms] if is_first else [PLAIN]
                self._net.split(publish, [*others, *cases])

    def _sources(self, publish: str) -> list[str]:
        """Return the places from which a publication takes its message."""
        return [each for each in self._net.original(publish).take if each not in self._parts.rooms]

    def _sample(self, number: int, comes: Stored, runs: Sequence[Run]) -> None:
        """Follow a value from where it is stored to the first run that reads it; `_run` lets it be read."""
        place, marker = self._value(number, comes)
        lost = Case(take={marker: 1, WATCHING: 1, GO: 1}, put={LOST: 1})
        self.is_exact &= displaced(
            self._net, self._parts, comes, place, marker, lost, self._asks == "reaction"
        )
        told_apart = {name for run in runs for name in (*run.moves, *self._endings(run))}
        for run in runs:
            require_steady(self._net, self._explored, run, place, sorted(told_apart & self._net.cases.keys()))

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
            found = {s for publish in self._parts.published[sends] for s in self._sources(publish)}
            sources = {source: f"observer {number} sends {source}" for source in found}
        value, stored = self._value(number, comes) if isinstance(comes, Stored) else ("", "")
        ends = set(self._endings(run))
        once = sends is None or most_put(run.page, sends.place) == 1
        own = self._own(run)
        touching = set(self._clock_moves(run)) if run.is_colored else set()
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
                cases.append(self._case(run, read=read, take=take, put=arrives["put"]))
            else:
                first = {"take": {**take, unsent: 1}, "put": leaves.put, "instead": leaves.instead}
                cases.append(self._case(run, read=read, **first))
                cases.append(self._case(run, read=read, take=take, inhibit={unsent: 1} if once else {}))
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
            self._color_clock(run)

    def _leaves(self, tells: Sequence[str], sources: dict[str, str], is_stored: bool) -> Case | None:
        """Return the effect of a transition that publishes or stores the followed data; None for others."""
        if not tells:
            return None
        told = _only(tells)
        followed = sources[told]
        if followed not in self._net.places:
            self._net.place(followed)
        return Case(put={followed: 1}) if is_stored else Case(instead={told: followed})

    def _color_clock(self, run: Run) -> None:
        """Give the run that is followed a clock of its own."""
        for name in (run.clock_begin, run.clock_end):
            free = frozenset({run.clock_free})
            self._net.split(name, [PLAIN, self._case(run, drop=free)])

    def _clock_moves(self, run: Run) -> set[str]:
        return {run.clock_begin, run.clock_end, *run.other_clocks}

    def _case(self, run: Run, **more: object) -> Case:
        """Return a case of a transition of the run that is followed."""
        names: dict[str, str] = {}
        if run.is_colored:
            for place in sorted(self._own(run)):
                names[place] = f"observer of {place}"
                if names[place] not in self._net.places:
                    self._net.place(names[place])
        return Case(rename=names, **more)  # type: ignore[arg-type]

    def _own(self, run: Run) -> set[str]:
        """Return the places that hold nothing but tokens of runs: they are empty if there is none."""
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

    def _beginnings(self, run: Run) -> list[str]:
        return [name for name in self._net.cases if self._begun(name, run) > 0]

    def _endings(self, run: Run) -> list[str]:
        return [name for name in self._net.cases if self._begun(name, run) < 0]

    def _begun(self, name: str, run: Run) -> int:
        firing = self._net.original(name)
        return sum(firing.put.get(place, 0) - firing.take.get(place, 0) for place in run.places)

    def _most(self, place: str) -> int:
        at = self._explored.net.untimed.places.index(place)
        return int(self._explored.markings[:, at].max())


def _some(put: dict[str, int], place: str, number: int) -> dict[str, int]:
    return {**put, place: number} if number else put


def _exactly(place: str, number: int) -> dict[str, Any]:
    """Return conditions that a place holds exactly so many tokens."""
    return {"inhibit": {place: number + 1}, **({"read": {place: number}} if number else {})}
