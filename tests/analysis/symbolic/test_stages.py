"""State spaces in stages: components are found, and the diagram is that of other engines."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Progress
from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.symbolic import saturation
from dineros.analysis.symbolic.counting import DiagramCounts
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import encode
from dineros.analysis.symbolic.stages import staged as stages
from dineros.analysis.symbolic.stages.joining import components, components_without_shared, joined
from dineros.analysis.symbolic.stages.staged import staged
from tests.analysis import classic_nets as classic

MEMORY = 1 << 28


def claims(processes: int) -> CompiledNet:
    """Processes that write their number to one variable, and go on if it is still there.

    Each has variables of its own: whether it wants to go on, which others read, whether it has been through
    before, and how often, as odd or even.
    """
    places = {"last is 0": 1}
    transitions: list[tuple[str, dict[str, int], dict[str, int]]] = []
    for i in range(1, processes + 1):
        places |= {f"last is {i}": 0, f"idle {i}": 1, f"asks {i}": 0, f"works {i}": 0}
        places |= {
            f"wants {i}": 0,
            f"wants not {i}": 1,
            f"been {i}": 0,
            f"new {i}": 1,
            f"odd {i}": 0,
            f"even {i}": 1,
        }
    for i in range(1, processes + 1):
        mine, want, calm = f"last is {i}", f"wants {i}", f"wants not {i}"
        for v in range(processes + 1):
            found = f"last is {v}"
            transitions.append(
                (f"ask {i} {v}", {f"idle {i}": 1, found: 1, calm: 1}, {f"asks {i}": 1, mine: 1, want: 1})
            )
            if v != i:
                transitions.append(
                    (
                        f"leave {i} {v}",
                        {f"asks {i}": 1, found: 1, want: 1},
                        {f"idle {i}": 1, found: 1, calm: 1},
                    )
                )
        other = f"wants not {i % processes + 1}"
        for known in (f"new {i}", f"been {i}"):
            transitions.append(
                (
                    f"enter {i} {known}",
                    {f"asks {i}": 1, mine: 1, other: 1, known: 1},
                    {f"works {i}": 1, mine: 1, other: 1, f"been {i}": 1},
                )
            )
        for before, after in (("odd", "even"), ("even", "odd")):
            transitions.append(
                (
                    f"end {i} {before}",
                    {f"works {i}": 1, want: 1, f"{before} {i}": 1},
                    {f"idle {i}": 1, calm: 1, f"{after} {i}": 1},
                )
            )
        transitions.append((f"forget {i}", {f"idle {i}": 1, f"been {i}": 1}, {f"idle {i}": 1, f"new {i}": 1}))
    return CompiledNet.build(places, transitions)


def rounds(processes: int) -> CompiledNet:
    """Peterson's algorithm without its loop over the others: as many shared variables as rounds."""
    last = processes - 1
    places = {f"turn {r} is {i}": int(i == 0) for r in range(last) for i in range(processes)}
    transitions: list[tuple[str, dict[str, int], dict[str, int]]] = []
    for i in range(processes):
        places |= {f"idle {i}": 1, f"calm {i}": 1, f"works {i}": 0, f"odd {i}": 0, f"even {i}": 1}
        for r in range(last):
            places |= {f"asks {i} {r}": 0, f"waits {i} {r}": 0}
            after = f"asks {i} {r + 1}" if r + 1 < last else f"works {i}"
            for j in range(processes):
                turn, mine = f"turn {r} is {j}", f"turn {r} is {i}"
                take = (f"take {i} {r} {j}", {f"asks {i} {r}": 1, turn: 1}, {f"waits {i} {r}": 1, mine: 1})
                transitions.append(take)
                if j != i:
                    for name, other in (("yield", turn), ("alone", f"calm {j}")):
                        taken = {f"waits {i} {r}": 1, other: 1}
                        transitions.append((f"{name} {i} {r} {j}", taken, {after: 1, other: 1}))
        transitions.append((f"ask {i}", {f"idle {i}": 1, f"calm {i}": 1}, {f"asks {i} 0": 1}))
        for before, after in (("odd", "even"), ("even", "odd")):
            calm = {f"idle {i}": 1, f"calm {i}": 1, f"{after} {i}": 1}
            transitions.append((f"end {i} {before}", {f"works {i}": 1, f"{before} {i}": 1}, calm))
    return CompiledNet.build(places, transitions)


def fast_exclusion(processes: int) -> CompiledNet:
    """Lamport's fast mutual exclusion, where a process looks at the flags of the others in any order."""
    every = range(1, processes + 1)
    places = {f"{v} is {w}": int(w == 0) for v in "xy" for w in (0, *every)}
    transitions: list[tuple[str, dict[str, int], dict[str, int]]] = []

    def step(name: str, before: list[str], after: list[str]) -> None:
        transitions.append((name, dict.fromkeys(before, 1), dict.fromkeys(after, 1)))

    for i in every:
        places |= {f"idle {i}": 1, f"down {i}": 1, f"up {i}": 0}
        others = [j for j in every if j != i]
        seen, new = ([f"{word} {i} {j}" for j in others] for word in ("seen", "new"))
        places |= dict.fromkeys(seen, 0) | dict.fromkeys(new, 1)
        for at in ("sets x", "tests y", "waits", "sets y", "tests x", "looks", "decides", "works", "leaves"):
            places[f"{at} {i}"] = 0
        step(f"start {i}", [f"idle {i}", f"down {i}"], [f"sets x {i}", f"up {i}"])
        step(f"again {i}", [f"waits {i}", "y is 0"], [f"idle {i}", "y is 0"])
        step(f"free {i}", [f"tests y {i}", "y is 0"], [f"sets y {i}", "y is 0"])
        step(f"go {i}", [f"tests x {i}", f"x is {i}"], [f"works {i}", f"x is {i}"])
        step(f"go late {i}", [f"decides {i}", f"y is {i}"], [f"works {i}", f"y is {i}"])
        step(f"leave {i}", [f"leaves {i}", f"up {i}"], [f"idle {i}", f"down {i}"])
        step(f"all seen {i}", [f"looks {i}", *seen], [f"decides {i}", *new])
        for j, old, fresh in zip(others, seen, new, strict=True):
            step(f"see {i} {j}", [f"looks {i}", fresh, f"down {j}"], [f"looks {i}", old, f"down {j}"])
        for w in (0, *every):
            x, y = f"x is {w}", f"y is {w}"
            step(f"set x {i} {w}", [f"sets x {i}", x], [f"tests y {i}", f"x is {i}"])
            step(f"set y {i} {w}", [f"sets y {i}", y], [f"tests x {i}", f"y is {i}"])
            step(f"clear y {i} {w}", [f"works {i}", y], [f"leaves {i}", "y is 0"])
            if w != 0:
                step(f"taken {i} {w}", [f"tests y {i}", y, f"up {i}"], [f"waits {i}", y, f"down {i}"])
            if w != i:
                step(f"raced {i} {w}", [f"tests x {i}", x, f"up {i}"], [f"looks {i}", x, f"down {i}"])
                step(f"lost {i} {w}", [f"decides {i}", y], [f"waits {i}", y])
    return CompiledNet.build(places, transitions)


def repetitions(clients: int, servers: int, room: int) -> CompiledNet:
    """Clients that repeat their requests until one is answered; all requests share room, and all answers."""
    places = {"room for requests": room, "room for answers": room}
    transitions: list[tuple[str, dict[str, int], dict[str, int]]] = []
    for s in range(servers):
        places[f"free {s}"] = 1
    for c in range(clients):
        idle, waits, asked, answered = f"idle {c}", f"waits {c}", f"asked {c}", f"answered {c}"
        places |= {idle: 1, waits: 0, asked: 0, answered: 0}
        for name, before, after in (("send", idle, waits), ("repeat", waits, waits)):
            transitions.append((f"{name} {c}", {before: 1, "room for requests": 1}, {after: 1, asked: 1}))
        for name, before in (("get", waits), ("drop", idle)):
            transitions.append((f"{name} {c}", {before: 1, answered: 1}, {idle: 1, "room for answers": 1}))
        for s in range(servers):
            works = f"works {s} for {c}"
            places[works] = 0
            take = {asked: 1, f"free {s}": 1}
            transitions.append((f"take {c} {s}", take, {works: 1, "room for requests": 1}))
            give = {works: 1, "room for answers": 1}
            transitions.append((f"answer {c} {s}", give, {answered: 1, f"free {s}": 1}))
    return CompiledNet.build(places, transitions)


@pytest.mark.parametrize(("clients", "servers", "room"), [(4, 2, 3), (6, 2, 2)])
def test_clients_that_share_counters_are_components(clients: int, servers: int, room: int) -> None:
    net = repetitions(clients, servers, room)
    encoding = encode(net)
    groups = components_without_shared(encoding, clients)
    assert groups is not None
    assert sum(len(group) > 1 for group in groups) == clients
    diagram, _ = staged(encoding, MEMORY)
    assert diagram is not None
    assert DiagramCounts(diagram).vectors() == explore(net).markings


def test_many_shared_variables_are_worth_stages() -> None:
    net = rounds(4)
    diagram, _ = staged(encode(net), MEMORY)
    assert diagram is not None
    assert DiagramCounts(diagram).vectors() == explore(net).markings


def test_shared_variables_that_processes_pass_first_are_near_them() -> None:
    """The other direction of the shared levels takes 82 381 cache misses; both are begun."""
    net = rounds(4)
    diagram, work = staged(encode(net), MEMORY)
    assert diagram is not None
    assert diagram.effort < 80_000
    assert diagram.effort < work < 100_000
    shared = [diagram.encoding.levels[level].places[0] for level in diagram.order[-3:]]
    assert [net.places[place] for place in shared] == [f"turn {number} is 0" for number in range(3)]


def test_a_process_and_its_own_variables_are_a_component() -> None:
    encoding = encode(claims(4))
    groups = components(encoding)
    several = [group for group in groups if len(group) > 1]
    assert [len(group) for group in groups].count(1) == 1  # the variable of all
    assert len(several) == 4
    parts = joined(encoding, groups)
    assert parts is not None
    for component in parts.components:
        level = parts.encoding.levels[component]
        product = 1
        for k in groups[component]:
            product *= len(encoding.levels[k].states)
        assert len(level.states) < product


@pytest.mark.parametrize("processes", [3, 4, 5])
def test_stages_reach_what_the_explicit_engine_reaches(processes: int) -> None:
    net = claims(processes)
    diagram, work = staged(encode(net), MEMORY)
    assert diagram is not None
    assert work >= diagram.effort > 0
    assert DiagramCounts(diagram).vectors() == explore(net).markings


@pytest.mark.parametrize("processes", [2, 3])
def test_processes_that_look_at_each_other_in_any_order(processes: int) -> None:
    net = fast_exclusion(processes)
    space = symbolic_state_space(net, order=[["unknown"]])  # so that stages come first
    seen = explore(net)
    assert (space.markings, space.arcs(), space.deadlocks()) == (seen.markings, seen.arcs, seen.deadlocks)


def test_the_latest_components_are_closed_before_earlier_ones() -> None:
    """All stages in turn take 401 702 cache misses, as closures of the components at the bottom cost most."""
    diagram, work = staged(encode(fast_exclusion(5)), MEMORY)
    assert diagram is not None
    assert DiagramCounts(diagram).vectors() == 43_828_637
    assert work < 280_000


def test_the_cache_of_stages_stays_small(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "MOST_CACHE", saturation.FIRST_CACHE)
    diagram, work = staged(encode(fast_exclusion(5)), MEMORY)
    assert diagram is not None
    assert work > saturation.FULL_CACHE * saturation.FIRST_CACHE  # it would have grown
    assert diagram.cache.size == 4 * saturation.FIRST_CACHE
    assert DiagramCounts(diagram).vectors() == 43_828_637


@pytest.mark.parametrize("processes", [3, 4])
def test_all_figures_are_those_of_the_explicit_engine(processes: int) -> None:
    net = claims(processes)
    space = symbolic_state_space(net, order=[["unknown"]])  # so that stages come first
    assert len(space.order) == processes + 1
    seen = explore(net)
    assert (space.markings, space.arcs(), space.deadlocks()) == (seen.markings, seen.arcs, seen.deadlocks)
    assert space.largest_place() == (1,) * len(net.places)
    for transition in ("ask 1 0", "enter 2 new 2", "leave 1 2"):
        assert space.enabled(transition) == symbolic_state_space(net).enabled(transition) > 0
    sets = space.sets
    assert sets.closure(
        sets.single([level.initial for level in space.encoding.levels]), space.diagram.root, False
    )


@pytest.mark.parametrize("net", [claims(4), fast_exclusion(3)])
def test_garbage_between_closures_changes_nothing(monkeypatch: pytest.MonkeyPatch, net: CompiledNet) -> None:
    monkeypatch.setattr(stages, "FIRST_GARBAGE", 1)
    monkeypatch.setattr(stages, "GARBAGE", 1)
    diagram, _ = staged(encode(net), MEMORY)
    assert diagram is not None
    assert diagram.collections > 4
    assert DiagramCounts(diagram).vectors() == explore(net).markings


def test_stages_report_how_many_markings_exist_at_least() -> None:
    net = claims(4)
    told: list[Progress] = []
    diagram, _ = staged(encode(net), MEMORY, told.append)
    assert diagram is not None
    known = [progress.at_least for progress in told if progress.at_least]
    assert len(known) == 4
    assert known == sorted(known)
    assert known[0] < known[-1] == explore(net).markings == DiagramCounts(diagram).vectors()


def test_too_much_work_ends_them() -> None:
    assert staged(encode(claims(5)), MEMORY, allowed=(100, 0))[0] is None
    assert staged(encode(claims(5)), MEMORY, allowed=(0, 100)) == (None, 0)
    assert staged(encode(rounds(4)), MEMORY, allowed=(100, 0)) == (None, 0)


@pytest.mark.parametrize("net", [classic.philosophers(6), classic.round_robin_mutex(4)])
def test_nets_without_components_are_not_run_in_stages(net: CompiledNet) -> None:
    assert staged(encode(net), MEMORY) == (None, 0)


def test_components_may_hold_many_tokens() -> None:
    net = classic.kanban(2)
    diagram, _ = staged(encode(net), MEMORY)
    assert diagram is not None
    assert DiagramCounts(diagram).vectors() == explore(net).markings
