"""Which data is where in a run: each message carries the releases that led to it, and when they were.

Histories and messages on their way keep their order, so that positions distinguish messages. A full history
forgets its oldest message.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Callable

from dineros.analysis.latencies.parts import Parts, Run
from dineros.metamodel import sym
from dineros.metamodel.times.given import runs_at_once

_FOLLOWED = (sym.CallbackKind.timer, sym.CallbackKind.subscriber)
Origins = dict[str, float]
"""When the data of a message or run was released, by callback."""
Seen = Callable[[str, str, float, float], None]
"""Receives an instance: its first and its last callback, its time, and when it ended."""


class Following:
    """Follows the data of one run.

    Parameters
    ----------
    seen : callable
        Called for each instance, as `Seen`; of a response, first and last callback are the same.
    lost : callable
        Called for each message that a history or writer loses, by place of the reader.
    """

    def __init__(self, parts: Parts, seen: Seen, lost: Callable[[str], None]) -> None:
        self._parts, self._seen, self._lost = parts, seen, lost
        self._net = parts.subject.timed
        self._names = self._net.untimed.transitions
        self._acts: dict[str, list[Callable[[float], None]]] = defaultdict(list)
        self._arrived: dict[sym.SubscriberPort, deque[Origins]] = defaultdict(deque)
        self._current: dict[str, Origins] = {}
        self._released: dict[str, float] = {}
        followed = [
            (page, run)
            for (page, _), run in parts.runs.items()
            if runs_at_once(page) == 1 and page.kind in _FOLLOWED
        ]
        # A transition may begin a run, publish, and end it: in this order.
        for page, run in followed:
            self._begins(page, run)
        self._histories()
        self._pipes()
        for page, run in followed:
            for name in self._moves(run, -1):
                self._on(name, self._ending(str(page.id)))
        self._by_number = [self._acts.get(name, []) for name in self._names]

    def fired(self, transition: int, time: float) -> None:
        """Take a firing."""
        for act in self._by_number[transition]:
            act(time)

    def _on(self, name: str, act: Callable[[float], None]) -> None:
        self._acts[name].append(act)

    def _moves(self, run: Run, sign: int) -> list[str]:
        """Return the transitions by which a run begins (1) or ends (-1)."""
        index = {name: number for number, name in enumerate(self._net.untimed.places)}
        places = {index[name] for name in run.places}
        found = []
        for number, name in enumerate(self._names):
            put = sum(weight for place, weight in self._net.put.row(number) if place in places)
            taken = sum(weight for place, weight in self._net.take.row(number) if place in places)
            if (put - taken) * sign > 0:
                found.append(name)
        return found

    def _puts(self, place: str) -> list[str]:
        at = self._net.untimed.places.index(place)
        return [
            name
            for number, name in enumerate(self._names)
            if any(each == at for each, _ in self._net.put.row(number))
        ]

    def _begins(self, page: sym.CallbackPage, run: Run) -> None:
        id = str(page.id)
        if page in self._parts.ticks:
            tick, _ = self._parts.ticks[page]
            self._on(tick, lambda time: self._released.__setitem__(id, time))

            def begins(time: float) -> None:
                self._current[id] = {id: self._released.pop(id, time)}

            for name in self._moves(run, 1):
                self._on(name, begins)

    def _ending(self, id: str) -> Callable[[float], None]:
        return lambda time: self._ends(id, time)

    def _ends(self, id: str, time: float) -> None:
        for origin, released in self._current.pop(id, {}).items():
            self._seen(origin, id, time - released, time)

    def _histories(self) -> None:
        for reader, queue in self._parts.histories.items():
            held: deque[tuple[Origins, float]] = deque()
            came = self._arrived[reader]
            place = str(reader.place.id)
            for entrance in queue.entrances:
                self._on(entrance.enter, self._entering(came, held, ""))
                self._on(entrance.drop, self._entering(came, held, place))
            runs = self._parts.runs.items()
            began = [page for (page, _), run in runs if queue.leave in self._moves(run, 1)]
            id = str(began[0].id) if began and runs_at_once(began[0]) == 1 else ""
            if queue.leave is not None:
                self._on(queue.leave, self._taking(held, id))

    def _pipes(self) -> None:
        for (writer, reader), pipe in self._parts.pipes.items():
            fresh: deque[Origins] = deque()
            inside: deque[Origins] = deque()
            puts = {name for place in self._parts.places[writer.place] for name in self._puts(place)}
            for (page, _), run in self._parts.runs.items():
                for name in sorted(run.moves & puts):
                    self._on(name, self._writing(str(page.id), fresh))
            for name in self._parts.published[writer]:
                self._on(name, self._passing(fresh, inside))
            for name in pipe.exits:
                self._on(name, self._passing(inside, self._arrived[reader]))
            self._on(pipe.drop, self._losing(inside, str(reader.place.id)))

    def _passing(self, first: deque[Origins], then: deque[Origins]) -> Callable[[float], None]:
        return lambda time: then.append(first.popleft() if first else {})

    def _writing(self, id: str, fresh: deque[Origins]) -> Callable[[float], None]:
        return lambda time: fresh.append(self._current.get(id, {}))

    def _losing(self, inside: deque[Origins], place: str) -> Callable[[float], None]:
        def act(time: float) -> None:
            if inside:
                inside.popleft()
            self._lost(place)

        return act

    def _entering(
        self, came: deque[Origins], held: deque[tuple[Origins, float]], loses: str
    ) -> Callable[[float], None]:
        def act(time: float) -> None:
            if loses:
                if held:
                    held.popleft()
                self._lost(loses)
            held.append((came.popleft() if came else {}, time))

        return act

    def _taking(self, held: deque[tuple[Origins, float]], id: str) -> Callable[[float], None]:
        def act(time: float) -> None:
            origins, arrival = held.popleft() if held else ({}, time)
            if id:
                self._current[id] = {**origins, id: arrival}

        return act
