"""Chains of engines and callbacks, explored in whole units of time, with one instance that is followed.

It knows a timer, ticks, messages on their way in order, histories, reactions, handlers in flight, places
inside a node, and callbacks on a thread of their own; it has no Petri net.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from random import Random

from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, step

UNIT = 0.01
MOST_STATES = 10_000


@dataclass(frozen=True)
class Stage:
    """A topic, and a node that takes its messages and passes them on if there is another stage.

    Attributes
    ----------
    latency : tuple of int
    depth : int
    reaction : tuple of int
        Of an engine; the duration of a callback of an executor.
    handler : int or None
        Greatest duration of the handler, if the transition has one.
    second : tuple of int or None
        Interval of a second transition, if a place inside the node lies between two transitions.
    is_engine : bool
    """

    latency: tuple[int, int]
    depth: int
    reaction: tuple[int, int]
    handler: int | None = None
    second: tuple[int, int] | None = None
    is_engine: bool = True

    @property
    def fires(self) -> tuple[int, int]:
        """When the transition fires that takes a message in hand."""
        return self.reaction if self.handler is None else (0, self.reaction[1] + self.handler)


@dataclass(frozen=True)
class Chain:
    """A timer of a node with an engine that publishes within its reaction, and what follows."""

    period: int
    reaction: tuple[int, int]
    stages: tuple[Stage, ...]


@dataclass(frozen=True)
class At:
    """What a stage holds; each message is True if it is the followed one.

    Attributes
    ----------
    sent : tuple of (int, bool)
        Ages of messages on their way.
    waiting : tuple of bool
    take : int
        Age of the moment at which the first one can be taken, or -1.
    hand : tuple of (int, bool) or None
        The one in hand, or that a callback works on, and since when.
    inside : tuple of bool
        Tokens between both transitions.
    then : int
        Age of the moment at which the second one can fire, or -1.
    """

    sent: tuple[tuple[int, bool], ...] = ()
    waiting: tuple[bool, ...] = ()
    take: int = -1
    hand: tuple[int, bool] | None = None
    inside: tuple[bool, ...] = ()
    then: int = -1

    def renewed(self, is_restarted: bool = False) -> At:
        """Return it with the clock of the next taking as it must be."""
        can_take = bool(self.waiting) and self.hand is None
        return replace(self, take=-1 if not can_take else 0 if is_restarted or self.take < 0 else self.take)

    def later(self) -> At:
        """Return it a unit later."""
        return replace(
            self,
            sent=tuple((age + 1, tag) for age, tag in self.sent),
            take=self.take + (self.take >= 0),
            hand=None if self.hand is None else (self.hand[0] + 1, self.hand[1]),
            then=self.then + (self.then >= 0),
        )


@dataclass(frozen=True)
class State:
    """Time to the next strike, age and tag of the due tick, the stages, and the time of the instance."""

    left: int
    due: tuple[int, bool] | None
    at: tuple[At, ...]
    watch: int = -1

    def put(self, number: int, stage: At, **more: object) -> State:
        """Return it with another stage."""
        return replace(self, at=(*self.at[:number], stage, *self.at[number + 1 :]), **more)  # type: ignore[arg-type]


@dataclass
class Found:
    """Times of all instances, in units, and whether one can be lost; `longest` history of each stage."""

    times: set[int]
    is_lost: bool
    longest: list[int]
    overflows: set[int]


def explored(chain: Chain, first: int, last: int) -> Found | None:
    """Follow instances from a release to the end of a stage; None if there are too many states.

    Parameters
    ----------
    chain
        The chain.
    first
        The stage in whose history an instance begins, or -1 for the ticks of the timer.
    last
        The stage with which it ends, or -1 for the timer's transition.
    """
    found = Found(set(), False, [0] * len(chain.stages), set())
    start = State(0, None, tuple(At() for _ in chain.stages))
    todo, seen = [start], {start}
    while todo:
        state = todo.pop()
        for number, here in enumerate(state.at):
            found.longest[number] = max(found.longest[number], len(here.waiting))
        for after in _Step(chain, state, first, last, found).successors():
            if after not in seen:
                seen.add(after)
                todo.append(after)
        if len(seen) > MOST_STATES:
            return None
    return found


@dataclass
class _Step:
    chain: Chain
    state: State
    first: int
    last: int
    found: Found

    def successors(self) -> Iterator[State]:
        chain, state = self.chain, self.state
        if state.left == 0:
            if state.due is None:
                for tag in self.tags(-1):
                    watch = 0 if tag else state.watch
                    yield replace(state, left=chain.period, due=(0, tag), watch=watch)
            else:
                yield replace(state, left=chain.period)
        if state.due is not None and state.due[0] >= chain.reaction[0]:
            yield from self.passed(replace(state, due=None), -1, state.due[1])
        for number, (stage, here) in enumerate(zip(chain.stages, state.at, strict=True)):
            yield from self.of_stage(number, stage, here)
        if not self.must_go_on():
            due = None if state.due is None else (state.due[0] + 1, state.due[1])
            at = tuple(each.later() for each in state.at)
            yield State(state.left - 1, due, at, state.watch + (state.watch >= 0))

    def tags(self, place: int) -> tuple[bool, ...]:
        return (False, True) if place == self.first and self.state.watch < 0 else (False,)

    def of_stage(self, number: int, stage: Stage, here: At) -> Iterator[State]:
        state = self.state
        if here.sent and here.sent[0][0] >= stage.latency[0]:
            for chosen in self.tags(number):
                tag = here.sent[0][1] or chosen
                waiting, is_full = (*here.waiting, tag), len(here.waiting) == stage.depth
                lost = is_full and waiting[0]
                self.found.is_lost |= lost
                self.found.overflows |= {number} if is_full else set()
                got = replace(here, sent=here.sent[1:], waiting=waiting[1:] if is_full else waiting)
                if not lost:
                    watch = 0 if chosen else state.watch
                    yield state.put(number, got.renewed(is_full), watch=watch)
        earliest = stage.reaction[0] if stage.is_engine else 0
        if here.take >= earliest and here.take >= 0:
            taken = replace(here, waiting=here.waiting[1:], hand=(0, here.waiting[0]))
            yield state.put(number, taken.renewed(True))
        if here.hand is not None and here.hand[0] >= stage.fires[0]:
            gone = replace(here, hand=None).renewed()
            if stage.second is None:
                yield from self.passed(state.put(number, gone), number, here.hand[1])
            else:
                inside = tuple(sorted((*gone.inside, here.hand[1])))
                yield state.put(number, replace(gone, inside=inside, then=max(gone.then, 0)))
        if stage.second is not None and here.inside and here.then >= stage.second[0]:
            for tag in set(here.inside):
                left = list(here.inside)
                left.remove(tag)
                gone = replace(here, inside=tuple(left), then=0 if left else -1)
                yield from self.passed(state.put(number, gone), number, tag)

    def passed(self, state: State, number: int, tag: bool) -> Iterator[State]:
        if tag and number == self.last:
            self.found.times.add(state.watch)
            return
        following = number + 1
        if following == len(state.at):
            yield state
            return
        here = state.at[following]
        yield state.put(following, replace(here, sent=(*here.sent, (0, tag))))

    def must_go_on(self) -> bool:
        state, chain = self.state, self.chain
        if state.left == 0 or (state.due is not None and state.due[0] == chain.reaction[1]):
            return True
        for stage, here in zip(chain.stages, state.at, strict=True):
            latest = stage.reaction[1] if stage.is_engine else 0
            if (here.sent and here.sent[0][0] == stage.latency[1]) or here.take == latest:
                return True
            if here.hand is not None and here.hand[0] == stage.fires[1]:
                return True
            if stage.second is not None and here.then == stage.second[1]:
                return True
        return False


def seconds(interval: tuple[int, int]) -> pn.TimeInterval:
    return pn.TimeInterval(earliest=interval[0] * UNIT, latest=interval[1] * UNIT)


def model_of(chain: Chain) -> sym.SystemModel:
    """Return the chain as a system model: callbacks `Timer`, `On0`, `On1`, and topics `t0`, `t1`."""
    model = sym.SystemModel(id="chain", middleware="ros2")
    first = node_net(model, "first")
    first.reaction = seconds(chain.reaction)
    page = callback(first, "Timer", "timer", chain.period * UNIT)
    page.offset = seconds((0, 0))
    out = place(page, "Out")
    step(page, "Say", [], [out])
    for number, stage in enumerate(chain.stages):
        node = node_net(model, f"node{number}", execution="net" if stage.is_engine else "callbacks")
        page = callback(node, f"On{number}")
        if stage.is_engine:
            node.reaction = seconds(stage.reaction)
        else:
            page.duration = seconds(stage.reaction)
        heard = place(page, f"Heard{number}")
        topic = sym.TopicChannel(id=f"Topic{number}", topic=f"t{number}", latency=seconds(stage.latency))
        topic.publishers.append(sym.PublisherPort(place=out, limit=9))
        topic.subscribers.append(sym.SubscriberPort(place=heard, limit=stage.depth))
        model.channels.append(topic)
        outs = [] if number == len(chain.stages) - 1 else [out := place(page, f"Out{number}")]
        inside = [place(page, f"Inside{number}")] if stage.second is not None else outs
        move = step(page, f"Do{number}", [heard], inside)
        if stage.handler is not None:
            move.duration = seconds((0, stage.handler))
        if stage.second is not None:
            step(page, f"Then{number}", inside, outs).interval = seconds(stage.second)
    return model


def drawn(random: Random, *, most_stages: int = 2) -> Chain:
    """Return a random chain, of which at least one stage is an engine."""
    stages: list[Stage] = []
    for _ in range(random.randint(1, most_stages)):
        least, earliest = random.randint(0, 2), random.choice((0, 0, 1))
        is_engine = not stages or random.random() < 0.6
        stage = Stage(
            (least, least + random.randint(0, 2)),
            random.randint(1, 2),
            (earliest, earliest + random.randint(0, 2)),
            is_engine=is_engine,
        )
        if is_engine and random.random() < 0.25:
            stage = replace(stage, handler=random.randint(0, 2))
        if is_engine and random.random() < 0.25:
            begin = random.randint(0, 1)
            stage = replace(stage, second=(begin, begin + random.randint(0, 2)))
        stages.append(stage)
    random.shuffle(stages)
    earliest = random.choice((0, 0, 1))
    return Chain(random.randint(2, 7), (earliest, earliest + random.randint(0, 2)), tuple(stages))
