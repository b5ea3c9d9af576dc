"""Handlers of node nets that take time: a plain program of the engine, whose runs the net must allow."""

from __future__ import annotations

import os
from collections import Counter
from random import Random
from typing import NamedTuple

import pytest

from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.nets.compiled import ArcTable
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import flow, node_net, place, read, seconds, step
from dineros.metamodel.constraints import validate

Span = tuple[int, int]


class Move(NamedTuple):
    """A transition: places that it takes from, reads and puts on, and how long its handler takes."""

    takes: tuple[str, ...]
    puts: tuple[str, ...]
    handler: Span | None = None
    reads: tuple[str, ...] = ()


class Node(NamedTuple):
    """A node net with its tokens; the engine reacts within a time."""

    moves: dict[str, Move]
    tokens: dict[str, int]
    reaction: int
    capacities: dict[str, int] = {}


def model_of(node: Node) -> sym.SystemModel:
    model = sym.SystemModel(id="system", middleware="ros2")
    net = node_net(model, "node")
    net.reaction = seconds(0, node.reaction)
    names = {name for move in node.moves.values() for name in (*move.takes, *move.puts, *move.reads)}
    names |= {*node.tokens, *node.capacities}
    places = {name: place(net, name, node.tokens.get(name, 0)) for name in sorted(names)}
    for name, most in node.capacities.items():
        places[name].capacity = most
    for name, move in node.moves.items():
        made = step(net, name)
        for each in move.takes:
            flow(places[each], made)
        for each in move.puts:
            flow(made, places[each])
        for each in move.reads:
            read(places[each], made)
        if move.handler is not None:
            made.duration = seconds(*move.handler)
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


SYSTEMS = 12 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_AT_ONCE = 60
"""Steps of an engine at one moment after which its time stops."""

Run = list[tuple[int, str]]
"""Times and transitions that fire."""


class Engine:
    """The engine of a node, in whole units of time.

    It begins what free tokens and free room allow, within its reaction. A handler holds its tokens and its
    room until it ends; then the transition fires. If a token that it reads is taken, its firing is released.
    """

    def __init__(self, node: Node, draw: Random) -> None:
        self.node, self.draw = node, draw
        self.tokens = Counter(node.tokens)
        self.held: Counter[str] = Counter()
        self.room: Counter[str] = Counter()
        self.works: list[tuple[str, int]] = []
        self.waits: dict[str, int] = {}

    def run(self, until: int) -> Run:
        fired: Run = []
        for now in range(until):
            for _ in range(MOST_AT_ONCE):
                self._note()
                must = [name for name, waited in self.waits.items() if waited >= self.node.reaction]
                late = [each for each in self.works if each[1] >= self._handler(each[0])[1]]
                able = [each for each in self.works if each[1] >= self._handler(each[0])[0]]
                if not (must or late) and self.draw.random() < 0.5:
                    break
                choices: list[str | tuple[str, int]] = [*self.waits, *able]
                if not choices:
                    break
                chosen = self.draw.choice(choices)
                if isinstance(chosen, str):
                    self._begin(chosen)
                    if self.node.moves[chosen].handler is not None:
                        continue
                    chosen = next(each for each in self.works if each[0] == chosen and each[1] == 0)
                self._end(chosen)
                fired.append((now, chosen[0]))
            else:
                return fired  # time stops
            self.works = [(name, age + 1) for name, age in self.works]
            self.waits = {name: waited + 1 for name, waited in self.waits.items()}
        return fired

    def _handler(self, name: str) -> Span:
        return self.node.moves[name].handler or (0, 0)

    def _can_begin(self, move: Move) -> bool:
        free = {name: self.tokens[name] - self.held[name] for name in self.tokens}
        if any(free.get(name, 0) < number for name, number in Counter(move.takes).items()):
            return False
        if any(self.tokens[name] < 1 for name in move.reads):
            return False
        full = self.node.capacities
        return all(
            self.tokens[name] - Counter(move.takes)[name] + self.room[name] + number <= full[name]
            for name, number in Counter(move.puts).items()
            if name in full
        )

    def _note(self) -> None:
        able = [name for name, move in self.node.moves.items() if self._can_begin(move)]
        self.waits = {name: self.waits.get(name, 0) for name in able}

    def _begin(self, name: str) -> None:
        move = self.node.moves[name]
        self.held.update(move.takes)
        self.room.update(move.puts)
        self.works.append((name, 0))
        del self.waits[name]

    def _end(self, work: tuple[str, int]) -> None:
        move = self.node.moves[work[0]]
        self._release(work)
        self.tokens.subtract(move.takes)
        broken = [
            each
            for each in self.works
            if any(self.tokens[name] < 1 for name in self.node.moves[each[0]].reads)
        ]
        for each in broken:
            self._release(each)
        self.tokens.update(move.puts)

    def _release(self, work: tuple[str, int]) -> None:
        move = self.node.moves[work[0]]
        self.works.remove(work)
        self.held.subtract(move.takes)
        self.room.subtract(move.puts)


def allows(net: TimedNet, run: Run) -> str:
    """Return what a net with times forbids of a run; empty if it allows all of it."""
    plain = net.untimed
    moves = {name: t for t, name in enumerate(plain.transitions)}
    marking = plain.initial.tolist()

    def is_enabled(transition: int, held: list[int]) -> bool:
        return all(held[p] >= w for p, w in net.untimed.pre.row(transition)) and all(
            held[p] < w for p, w in plain.inhibitor.row(transition)
        )

    def moved(held: list[int], table: ArcTable, transition: int, sign: int) -> list[int]:
        changes = dict(table.row(transition))
        return [tokens + sign * changes.get(place, 0) for place, tokens in enumerate(held)]

    since = {t: 0 for t in moves.values() if is_enabled(t, marking)}
    for now, name in run:
        for each, began in since.items():
            latest = net.intervals[each].latest
            if latest is not None and now - began > latest:
                return f"{plain.transitions[each]} must fire before {now}"
        fires = moves[name]
        if fires not in since or now - since[fires] < net.intervals[fires].earliest:
            return f"{name} cannot fire at {now}"
        between = moved(marking, net.take, fires, -1)
        marking = moved(between, net.put, fires, 1)
        since = {
            t: since[t] if t in since and t != fires and is_enabled(t, between) else now
            for t in moves.values()
            if is_enabled(t, marking)
        }
    return ""


def drawn(seed: int) -> Node:
    """Return two to five transitions over four places; half of them have handlers that take time."""
    draw = Random(seed)
    places = [f"p{number}" for number in range(4)]
    tokens = {name: draw.randint(0, 2) for name in places}
    tokens["p0"] = max(1, tokens["p0"])
    capacities = {name: draw.randint(max(1, tokens[name]), 3) for name in places if draw.random() < 0.2}
    moves = {}
    for number in range(draw.randint(2, 5)):
        takes, puts = draw.sample(places, draw.randint(1, 2)), draw.sample(places, draw.randint(0, 2))
        least = draw.randint(0, 4)
        handler = (least, least + draw.randint(0, 3)) if draw.random() < 0.5 else None
        others = [name for name in places if name not in (*takes, *puts)]
        reads = tuple(draw.sample(others, 1)) if others and draw.random() < 0.2 else ()
        moves[f"t{number}"] = Move(tuple(takes), tuple(puts), handler, reads)
    return Node(moves, tokens, draw.randint(0, 2), capacities)


@pytest.mark.parametrize("group", range(8))
def test_the_net_allows_all_that_an_engine_does(group: int) -> None:
    fired = bounded = 0
    for seed in range(SYSTEMS * group, SYSTEMS * (group + 1)):
        node = drawn(seed)
        net = timed_base_subject(model_of(node)).timed
        bounded += sum(each.latest is not None for each in net.intervals)
        for number in range(5):
            run = Engine(node, Random(1000 * seed + number)).run(30)
            fired += len(run)
            assert allows(net, run) == "", (node, run)
    assert fired > 100 and bounded > 0


def test_what_is_too_late_is_noticed() -> None:
    node = Node({"t": Move(("p",), (), (2, 4))}, {"p": 2}, 1)
    net = timed_base_subject(model_of(node)).timed
    assert str(net.intervals[0]) == "[0,5]"
    assert allows(net, [(5, "t"), (10, "t")]) == ""
    assert allows(net, [(6, "t")]) == "t must fire before 6"
    assert allows(net, [(1, "t"), (1, "t"), (1, "t")]) == "t cannot fire at 1"


def holds(model: sym.SystemModel, formula: str) -> bool:
    bounded = read_bounded(formula)
    assert bounded is not None
    return decide_bounded(timed_base_subject(model).timed, bounded).status == "holds"


def test_a_handler_ends_within_reaction_and_duration() -> None:
    model = model_of(Node({"t": Move(("p",), ("q",), (2, 4))}, {"p": 1}, 1))
    assert holds(model, "F[<=5] (q >= 1)")
    assert not holds(model, "F[<=4] (q >= 1)")


def test_a_handler_in_flight_keeps_others_from_its_tokens() -> None:
    """The handler of ``t`` may hold the token for 4; ``u`` needs it, and does not fire meanwhile."""
    moves = {"t": Move(("p",), ("q",), (3, 4)), "u": Move(("p",), ("r",))}
    assert not holds(model_of(Node(moves, {"p": 1}, 1)), "F[<=1] (q >= 1 | r >= 1)")


def test_a_handler_in_flight_keeps_others_from_the_room_it_needs() -> None:
    moves = {"t": Move(("p",), ("q",), (3, 4)), "u": Move(("s",), ("q",))}
    assert not holds(model_of(Node(moves, {"p": 1, "s": 1}, 1, {"q": 1})), "F[<=1] (q >= 1)")


def test_what_signals_decide_stays_open() -> None:
    model = sym.SystemModel(id="system", middleware="ros2")
    node = node_net(model, "node", ["s"], reaction=seconds(0, 1))
    move = step(node, "t", [place(node, "p", 1)], [place(node, "q")], clause="s")
    move.duration = seconds(2, 4)
    net = timed_base_subject(model).timed
    assert net.intervals[net.untimed.transitions.index("t")].latest is None
