"""Messages that an observer may follow on their way: how many are before it, and whether it is lost."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

from dineros.analysis.latencies.editing import PLAIN, Case, EditedNet, Firing
from dineros.analysis.latencies.markers import GO, LOST, NOW, WATCHING, exactly, some
from dineros.analysis.latencies.parts import Parts, Pipe
from dineros.analysis.latencies.paths import Hop
from dineros.analysis.latencies.sampling import NotFollowedError
from dineros.analysis.timed.exploring import Explored


@dataclass
class StartOfInstance:
    """What a release does that an observer may choose."""

    begins: dict[str, int]
    measures: dict[str, int]
    """`begins`, `measures`: what the observer takes and puts when it chooses the release."""
    plain: Case = PLAIN
    """The case in which it does not."""
    arms: list[Case] = field(default_factory=list)
    """Cases in which it starts its clock, and follows the next release."""


class FollowedMessages:
    """Follows messages from a publisher to a reader history.

    `start`: what the release of an instance does.

    Attributes
    ----------
    is_exact : bool
        Whether it is known of each message that is lost which one it is.
    """

    def __init__(self, net: EditedNet, parts: Parts, explored: Explored, start: StartOfInstance) -> None:
        self._net, self._parts, self._explored, self._start = net, parts, explored, start
        self.is_exact = True

    def pipe(self, number: int, hop: Hop, received: str, arrived: str, is_first: bool) -> None:
        """Follow a message on its way to a history; `publish` puts it on the way."""
        if (hop.writer, hop.reader) not in self._parts.pipes:
            raise NotFollowedError
        net, pipe = self._net, self._parts.pipes[hop.writer, hop.reader]
        sent, ahead = net.place(f"observer {number} on the way"), net.place(f"observer {number} sooner")
        inside, landed = net.place(f"observer {number} sent"), net.place(f"observer {number} landed")
        if is_first:
            self.publish(hop, number, [(self._start.begins, self._start.measures, {})], is_first=True)
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
        if pipe.loses:
            net.split(
                pipe.loses, [Case(inhibit={sent: 1}), *self._lost_on_the_way(pipe, sent, ahead, inside)]
            )
            net.extend(pipe.loses, take={inside: 1})

    def _lost_on_the_way(self, pipe: Pipe, sent: str, ahead: str, inside: str) -> Iterator[Case]:
        """Yield the cases in which a message is lost before it leaves its writer: one of the last ones."""
        for together in range(1, self._most([pipe.load]) + 1):
            for number in range(together, self._most(pipe.inside) + 1):
                # The transition itself takes one of each.
                inhibit = {pipe.load: together + 1, inside: number + 1}
                read = some(some({}, pipe.load, together - 1), inside, number - 1)
                in_load = some(read, ahead, number - together)
                # The followed one, one before it, and one after it.
                yield Case({sent: 1, WATCHING: 1, GO: 1}, {LOST: 1}, in_load, inhibit)
                if together > 1:
                    yield Case({ahead: 1}, {}, {**in_load, sent: 1}, inhibit)
                if number > 1:
                    yield Case(read={**read, sent: 1}, inhibit={**inhibit, ahead: number - 1})

    def _most(self, places: Sequence[str]) -> int:
        """Return how many tokens some places hold together, at most."""
        index = self._explored.net.untimed.places
        inside = [index.index(place) for place in places]
        return int(self._explored.markings[:, inside].sum(axis=1).max())

    def publish(
        self,
        hop: Hop,
        number: int,
        ways: Sequence[tuple[dict[str, int], dict[str, int], dict[str, str]]],
        only: str | None = None,
        is_first: bool = False,
    ) -> None:
        """Put a message on its way to callback `number`, behind those that are on it."""
        pipe = self._parts.pipes[hop.writer, hop.reader]
        most = self._most(pipe.inside)
        sent, ahead = f"observer {number} on the way", f"observer {number} sooner"
        counted = f"observer {number} sent"
        for publish in self._parts.published[hop.writer]:
            if only in (None, publish):
                cases = [
                    Case(
                        take=take,
                        put=some({**put, sent: 1}, ahead, k),
                        rename=rename,
                        **exactly(counted, k),
                    )
                    for take, put, rename in ways
                    for k in range(most + 1)
                ]
                others = [self._start.plain, *self._start.arms] if is_first else [PLAIN]
                self._net.split(publish, [*others, *cases])

    def sources(self, publish: str) -> list[str]:
        """Return the places from which a publication takes its message."""
        return [each for each in self._net.original(publish).take if each not in self._parts.rooms]
