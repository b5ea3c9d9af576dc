"""State spaces in stages: components are found, and the diagram is that of other engines."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Progress
from dineros.analysis.explicit import explore
from dineros.analysis.nets.compiled import CompiledNet
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
    assert work == diagram.effort > 0
    assert DiagramCounts(diagram).vectors() == explore(net).markings


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


def test_garbage_between_closures_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "FIRST_GARBAGE", 1)
    monkeypatch.setattr(stages, "GARBAGE", 1)
    net = claims(4)
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
