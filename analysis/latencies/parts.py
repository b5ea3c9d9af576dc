"""The parts of a timed net that an observer follows: runs of callbacks, histories, messages on their way."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from functools import cached_property

from dineros.analysis.model.queues import Queue, queues
from dineros.analysis.model.wording import source_of
from dineros.analysis.timed.timed_subject import TimedSubject
from dineros.metamodel import pn, sym
from dineros.metamodel.callbacks.groups import callback_page_of
from dineros.metamodel.times.overlaps import runs_overlapping
from dineros.transformations.flattening.traces import Link
from dineros.transformations.rules.executors import E3, E7
from dineros.transformations.rules.histories import R1, R2, R3, R4, R1Instance, R2RoomOpen
from dineros.transformations.rules.services import S1
from dineros.transformations.rules.starts import D2Start
from dineros.transformations.rules.timers import C1
from dineros.transformations.rules.times.latencies import D5, D5Clock
from dineros.transformations.rules.times.strikes import D1
from dineros.transformations.rules.times.work import D2, D3, D2Clock

Pair = tuple[sym.PublisherPort, sym.SubscriberPort]


@dataclass
class Run:
    """A callback of a node, or a server instance's copy of it; ids in the net."""

    page: sym.CallbackPage
    places: list[str] = field(default_factory=list)
    """One token for each run that has begun and not ended."""
    own: set[str] = field(default_factory=set)
    """Places on its page, and those of its beginning and its work."""
    moves: set[str] = field(default_factory=set)
    """Transitions on its page."""
    starts: set[str] = field(default_factory=set)
    """Transitions by which the callback of a timer begins; they take, and read, what its first one needs."""
    works: str = ""
    worked: str = ""
    busy: str = ""
    """`works`, `worked`, `busy`: where its work begins and ends, and the place of its first clock; empty if
    it has no duration.
    """
    clock_begin: str = ""
    clock_end: str = ""
    clock_free: str = ""
    """`clock_begin`, `clock_end`, `clock_free`: transitions and idle place of that clock."""
    other_clocks: set[str] = field(default_factory=set)
    known_own: set[str] | None = None

    @property
    def is_colored(self) -> bool:
        """Whether the followed run needs places of its own, because several runs overlap."""
        return self.page.kind != sym.CallbackKind.server and runs_overlapping(self.page) > 1


@dataclass
class Pipe:
    """The elements between a publisher and the history of a reader."""

    written: str
    """Place where messages enter it."""
    inside: list[str]
    """Places of messages in it."""
    exits: list[str]
    """Transitions by which messages arrive."""
    drop: str
    """Transition by which the writer loses one."""
    is_on_the_way: bool = False
    """Whether clocks say how long messages are on their way."""
    load: str = ""
    """Place of the messages that have not left the writer."""
    loses: str = ""
    """Transition by which a best-effort message is lost; empty if none is."""


class Parts:
    """The parts of a net.

    `subject`: a system model of the middleware ``ros2``, flattened with its times.
    """

    def __init__(self, subject: TimedSubject) -> None:
        self.subject = subject
        self.runs: dict[tuple[sym.CallbackPage, int | None], Run] = {}
        self.ticks: dict[sym.CallbackPage, tuple[str, str]] = {}
        self.lost_ticks: dict[sym.CallbackPage, str] = {}
        """By callback of a timer, the transition by which it loses a tick."""
        self.received: dict[sym.SubscriberPort, str] = {}
        self.pipes: dict[Pair, Pipe] = {}
        self.rooms: set[str] = set()
        """Places of the room for a published message."""
        self.requests: dict[sym.ServiceChannel, list[str]] = defaultdict(list)
        """By service the places of requests that wait, one for each client."""
        self.published: dict[sym.PublisherPort, list[str]] = defaultdict(list)
        self.places: dict[pn.Place, list[str]] = defaultdict(list)
        """The copies of a place of the model: one, or one for each instance of a server."""
        links = [each for each in subject.links() if isinstance(each.target, pn.Node)]
        self._read_runs(links)
        self._read_topics(links)
        self._read_services(links)

    @cached_property
    def histories(self) -> dict[sym.SubscriberPort, Queue]:
        """The reader history of each subscriber."""
        return {
            source_of(queue.link, sym.SubscriberPort): queue
            for queue in queues(self.subject)
            if queue.kind == "subscriber" and queue.link.maker is R3
        }

    def runs_of(self, page: sym.CallbackPage) -> list[Run]:
        """Return the callback of a page, or its copies of each server instance."""
        return [run for (of, _), run in self.runs.items() if of is page]

    def _read_runs(self, links: Iterable[Link]) -> None:
        for link in links:
            name = link.target.id
            if link.maker is None and isinstance(link.target, pn.Place):
                for source in link.sources[:1]:
                    if isinstance(source, pn.Place):
                        self.places[source].append(name)
            if link.maker is E3 or (link.maker is E7 and link.role == "awaiting"):
                self._run(link).places.append(name)
                self._run(link).own.add(name)
            elif link.maker is C1 and link.role in ("tick", "due"):
                page = source_of(link, sym.CallbackPage)
                tick, due = self.ticks.get(page, ("", ""))
                self.ticks[page] = (name, due) if link.role == "tick" else (tick, name)
            elif link.maker is D1 and link.role == "miss":
                self.lost_ticks[source_of(link, sym.CallbackPage)] = name
            elif link.maker is D2Start and link.role == "begun":
                self._run(link).own.add(name)
            elif link.maker is D2Start and link.role == "begin":
                self._run(link).starts.add(name)
            elif link.maker is D2:
                run = self._run(link)
                run.own.add(name)
                if link.role == "begun":
                    run.works = name
                else:
                    run.worked = name
            elif link.maker is D2Clock:
                self._read_clock(link, name)
            elif link.maker is D3 and link.role == "late":
                self._run(link).moves.add(name)
            elif link.maker is None and (around := callback_page_of(link.sources[0])) is not None:
                run = self._run_of(around, link.index)
                (run.own if isinstance(link.target, pn.Place) else run.moves).add(name)

    def _read_clock(self, link: Link, name: str) -> None:
        run = self._run(link)
        part = link.role.removeprefix("clock.")
        attribute = {"begin": "clock_begin", "end": "clock_end", "free": "clock_free", "busy": "busy"}[part]
        if not getattr(run, attribute):
            setattr(run, attribute, name)
            if part == "busy":
                run.own.add(name)
        elif part in ("begin", "end"):
            run.other_clocks.add(name)

    def _run(self, link: Link) -> Run:
        return self._run_of(source_of(link, sym.CallbackPage), link.index)

    def _run_of(self, page: sym.CallbackPage, index: int | None) -> Run:
        if page.kind != sym.CallbackKind.server:
            index = None
        return self.runs.setdefault((page, index), Run(page))

    def _read_topics(self, links: Iterable[Link]) -> None:
        places: dict[Pair, dict[str, str]] = defaultdict(dict)
        for link in links:
            name = link.target.id
            if link.maker is R3 and link.role == "received":
                self.received[source_of(link, sym.SubscriberPort)] = name
            elif link.maker in (R1, R1Instance) and link.role == "publication.publish":
                self.published[source_of(link, sym.PublisherPort)].append(name)
            elif link.maker in (R2, R4):
                places[_pair(link)][link.role] = name
            elif link.maker is R2RoomOpen:
                self.rooms.add(name)
            elif link.maker is D5 and link.role == "sent":
                places[_pair(link)]["sent"] = name
            elif link.maker is D5Clock and link.role in ("clock.busy", "clock.end"):
                places[_pair(link)][f"{link.role} {len(places[_pair(link)])}"] = name
        for pair, roles in places.items():
            is_timed = "sent" in roles
            busy = [name for role, name in roles.items() if role.startswith("clock.busy")]
            ends = [name for role, name in roles.items() if role.startswith("clock.end")]
            inside = [roles["written"], roles["queue.load"], *([roles["sent"]] if is_timed else []), *busy]
            exits = ends if is_timed else [roles["queue.leave"]]
            self.pipes[pair] = Pipe(
                roles["written"],
                inside,
                exits,
                roles["queue.drop"],
                is_timed,
                roles["queue.load"],
                roles.get("lose", ""),
            )

    def _read_services(self, links: Iterable[Link]) -> None:
        for link in links:
            if link.maker is S1 and link.role == "requests":
                self.requests[source_of(link, sym.ServiceChannel)].append(link.target.id)


def _pair(link: Link) -> Pair:
    return source_of(link, sym.PublisherPort), source_of(link, sym.SubscriberPort)
