"""The plain way to explain a recording: every marking and every order, one after the other."""

from __future__ import annotations

import random
import re
from collections.abc import Iterable, Sequence

from dineros.analysis.model.subject import subject_of
from dineros.metamodel import sym

Marking = tuple[int, ...]
Message = tuple[str, int]
MILLISECOND = 1_000_000
EVENTS = {
    "req": "request sent",
    "call": "request received",
    "return": "response sent",
    "res": "response received",
}
"""What a service tells of a step, by how its transition is named."""


class TooLargeError(Exception):
    """There are more markings than a plain search should look at."""


class Reference:
    """A model flattened with its signals, and its runs.

    Topics are those of the model, all of them recorded unless named as `hidden`; so are the events of its
    services where `events` says so.
    """

    def __init__(
        self, model: sym.SystemModel, most: int = 800, hidden: Iterable[str] = (), *, events: bool = False
    ) -> None:
        self._net = subject_of(model, "fully-enabled").net
        self._most = most
        self.topics = {
            channel.id: channel.topic if channel.topic.startswith("/") else f"/{channel.topic}"
            for channel in model.channels
            if isinstance(channel, sym.TopicChannel)
        }
        ros1 = model.middleware == sym.Middleware.ros1
        self._label: dict[int, str] = {}
        for number, name in enumerate(self._net.transitions):
            for channel, topic in self.topics.items():
                sees = (
                    name == f"{channel}.transport"
                    if ros1
                    else name.startswith(f"{channel}.publisher.") and name.endswith(".publish")
                )
                if sees and topic not in hidden:
                    self._label[number] = topic
            for each in model.channels:
                if events and isinstance(each, sym.ServiceChannel):
                    step = re.fullmatch(
                        rf"{re.escape(str(each.id))}\.(client\..*|late)\.(\w+)(\[\d+\])*", name
                    )
                    if step is not None and step[2] in EVENTS:
                        self._label[number] = f"/{each.service.strip('/')} ({EVENTS[step[2]]})"
        self.names = sorted({*self._label.values(), *set(self.topics.values()).difference(hidden)})
        self._afters: dict[tuple[frozenset[Marking], str], set[Marking]] = {}
        self._silent = [n for n in range(len(self._net.transitions)) if n not in self._label]

    def first_unexplained(
        self, messages: Sequence[Message], tolerance: int = 0, *, midway: bool = False
    ) -> int | None:
        """Return the number, from 1, of the first message that no run shows; None: there is a run.

        A run begins at the start or, `midway`, in any marking that is reached from there.
        """
        everything = range(len(self._net.transitions)) if midway else self._silent
        ways = {frozenset[int](): self._closed({tuple(self._net.initial.tolist())}, everything)}
        for first, (_, time) in enumerate(messages):
            known = [m for m, (_, other) in enumerate(messages) if m <= first or other <= time + tolerance]
            reached = dict(ways)
            queue = list(ways)
            while queue:
                done = queue.pop(0)
                for message in known:
                    topic, own = messages[message]
                    before = [
                        m
                        for m, (other, its) in enumerate(messages[:message])
                        if other == topic or its + tolerance < own
                    ]
                    if message in done or not done.issuperset(before) or first in done:
                        continue
                    after = self._after(reached[done], topic)
                    more = done | {message}
                    if after - reached.get(more, set()):
                        reached[more] = reached.get(more, set()) | after
                        queue.append(more)
            ways = {done: markings for done, markings in reached.items() if first in done and markings}
            if not ways:
                return first + 1
        return None

    def recording(self, seed: int, length: int, gap: int = 20) -> list[Message]:
        """Return the messages of a random run, `gap` milliseconds apart at most."""
        drawn, marking = random.Random(seed), self._net.initial.tolist()
        messages: list[Message] = []
        time = 0
        for _ in range(50 * length):
            enabled = [t for t in range(len(self._net.transitions)) if self._net.is_enabled(t, marking)]
            if not enabled or len(messages) == length:
                break
            chosen = drawn.choice(enabled)
            marking = self._net.fire(chosen, marking)
            if chosen in self._label:
                time += drawn.randrange(gap * MILLISECOND)
                messages.append((self._label[chosen], time))
        return messages

    def _after(self, markings: set[Marking], topic: str) -> set[Marking]:
        key = frozenset(markings), topic
        if key not in self._afters:
            self._afters[key] = self._fired(markings, topic)
        return self._afters[key]

    def _fired(self, markings: set[Marking], topic: str) -> set[Marking]:
        return self._closed(
            {
                tuple(self._net.fire(number, marking))
                for marking in markings
                for number, label in self._label.items()
                if label == topic and self._net.is_enabled(number, marking)
            }
        )

    def _closed(self, markings: set[Marking], moves: Iterable[int] | None = None) -> set[Marking]:
        moves = self._silent if moves is None else moves
        found, queue = set(markings), list(markings)
        while queue:
            marking = queue.pop()
            for number in moves:
                if self._net.is_enabled(number, marking):
                    after = tuple(self._net.fire(number, marking))
                    if after not in found:
                        found.add(after)
                        queue.append(after)
            if len(found) > self._most:
                raise TooLargeError
        return found


def mutants(messages: Sequence[Message], topics: Sequence[str], seed: int) -> list[tuple[str, list[Message]]]:
    """Return a recording with one message swapped with the next, dropped, doubled and invented."""
    drawn = random.Random(seed)
    at = drawn.randrange(len(messages))
    made = {
        "dropped": [*messages[:at], *messages[at + 1 :]],
        "doubled": [*messages[: at + 1], messages[at], *messages[at + 1 :]],
        "invented": [*messages[:at], (drawn.choice(topics), messages[at][1]), *messages[at:]],
    }
    if at + 1 < len(messages):
        (one, early), (other, late) = messages[at], messages[at + 1]
        made["swapped"] = [*messages[:at], (other, early), (one, late), *messages[at + 2 :]]
    return list(made.items())
