"""A run to a fault in which a round repeats is found where another one fills a queue in many ways."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import FiringRows, can_fire, replay
from dineros.analysis.witnesses import rounds
from dineros.analysis.witnesses.folding import in_rounds, lines_of
from dineros.analysis.witnesses.rounds import LEAST_LINES, repeating_way

DEPTH = 40
TURNS = 40
START = {"driving": 1, "held": 0, "goal": 0, "failed": 0, "written": 0, "history": 0, "room": DEPTH}
NET = CompiledNet.build(
    {**START, "waypoints": 0},
    [
        Transition("hold", {"driving": 1}, {"held": 1}),
        Transition("send", {"held": 1}, {"held": 1, "goal": 1}),
        Transition("refuse", {"goal": 1}, {"failed": 1}),
        Transition("report", {"failed": 1}, {"written": 1, "waypoints": 1}),
        Transition("take", {"written": 1, "room": 1}, {"history": 1}),
        Transition("lose", {"written": 1, "history": DEPTH}, {"history": DEPTH}),
        *(
            Transition(f"turn{number}", {"driving": 1}, {"driving": 1, "written": 1})
            for number in range(TURNS)
        ),
    ],
)
HOLD, SEND, REFUSE, REPORT, TAKE, LOSE, FIRST_TURN = range(7)


def filled(seed: int) -> list[int]:
    """Return a run that fills the history while it drives, always in another way, and then holds."""
    rng = random.Random(seed)
    turns = [FIRST_TURN + rng.randrange(TURNS) for _ in range(DEPTH)]
    return [*(step for turn in turns for step in (turn, TAKE)), HOLD]


@pytest.mark.parametrize("seed", range(5))
def test_a_history_is_filled_by_the_round_that_continues_forever(seed: int) -> None:
    way, loop = filled(seed), (SEND, REFUSE, REPORT, LOSE)
    assert lines_of(in_rounds(NET, way)) >= LEAST_LINES
    assert repeating_way(NET, way, loop) == (HOLD, *(SEND, REFUSE, REPORT, TAKE) * DEPTH)


@pytest.mark.parametrize("seed", range(5))
def test_a_history_is_filled_by_one_of_the_turns(seed: int) -> None:
    found = repeating_way(NET, [*filled(seed)[:-1], FIRST_TURN], [LOSE])
    assert lines_of(found) <= 4
    assert can_fire(NET, [LOSE], replay(NET, found)[-1])


def test_the_search_for_rounds_in_a_long_run_has_a_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    """A run of 6 000 firings has 1.6 million parts; each may cost 24 firings."""
    fired = 0
    fire = FiringRows.fire

    def counted(self: FiringRows, transition: int, marking: list[int]) -> bool:
        nonlocal fired
        fired += 1
        return fire(self, transition, marking)

    monkeypatch.setattr(FiringRows, "fire", counted)
    rng = random.Random(3)
    turns = [FIRST_TURN + rng.randrange(TURNS) for _ in range(3_000)]
    way = [step for at, turn in enumerate(turns) for step in (turn, TAKE if at < DEPTH else LOSE)]
    found = repeating_way(NET, way, [FIRST_TURN], most_tried=100_000)
    assert can_fire(NET, [FIRST_TURN], replay(NET, found)[-1])
    assert fired < 300_000


@pytest.mark.parametrize("seed", range(40))
def test_what_is_found_in_random_nets_can_fire(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(rounds, "LEAST_LINES", 2)
    monkeypatch.setattr(rounds, "MOST_TRIED", 20_000)
    rng = random.Random(seed)
    places = [f"p{number}" for number in range(5)]

    def arcs(most: int) -> dict[str, int]:
        return {place: rng.randint(1, 2) for place in rng.sample(places, rng.randint(0, most))}

    moves = [Transition(f"t{number}", arcs(2), arcs(2), inhibitors=arcs(1)) for number in range(6)]
    net = CompiledNet.build({place: rng.randint(0, 2) for place in places}, moves)
    way: list[int] = []
    marking = replay(net, [])[-1]
    for _ in range(40):
        able = [t for t in range(len(moves)) if net.is_enabled(t, marking)]
        if not able:
            break
        way.append(rng.choice(able))
        marking = net.fire(way[-1], marking)
    for size in (1, 3):
        before, then = way[:-size], way[-size:]
        found = repeating_way(net, before, then)
        assert can_fire(net, then, replay(net, found)[-1])
        assert lines_of(found) <= lines_of(in_rounds(net, before))
