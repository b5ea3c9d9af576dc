"""Classic scalable nets with published counts."""

from __future__ import annotations

from dineros.analysis.nets.compiled import CompiledNet, Transition


def philosophers(count: int) -> CompiledNet:
    """Dining philosophers who take their two forks one after the other, in any order: 3^count markings."""
    places: dict[str, int] = {}
    transitions = []
    for i in range(count):
        places |= {f"think{i}": 1, f"left{i}": 0, f"right{i}": 0, f"eat{i}": 0, f"fork{i}": 1}
        own, other = f"fork{i}", f"fork{(i + 1) % count}"
        transitions += [
            Transition(f"take_left{i}", {f"think{i}": 1, own: 1}, {f"left{i}": 1}),
            Transition(f"take_right{i}", {f"think{i}": 1, other: 1}, {f"right{i}": 1}),
            Transition(f"left_eat{i}", {f"left{i}": 1, other: 1}, {f"eat{i}": 1}),
            Transition(f"right_eat{i}", {f"right{i}": 1, own: 1}, {f"eat{i}": 1}),
            Transition(f"end{i}", {f"eat{i}": 1}, {f"think{i}": 1, own: 1, other: 1}),
        ]
    return CompiledNet.build(places, transitions)


def kanban(cards: int) -> CompiledNet:
    """Kanban system of four cells (Ciardo and Tilgner, 1996)."""
    places: dict[str, int] = {}
    transitions = []
    for i in range(1, 5):
        places |= {f"machine{i}": 0, f"back{i}": 0, f"kanban{i}": cards, f"out{i}": 0}
        transitions += [
            Transition(f"redo{i}", {f"machine{i}": 1}, {f"back{i}": 1}),
            Transition(f"ok{i}", {f"machine{i}": 1}, {f"out{i}": 1}),
            Transition(f"return{i}", {f"back{i}": 1}, {f"machine{i}": 1}),
        ]
    transitions += [
        Transition("enter", {"kanban1": 1}, {"machine1": 1}),
        Transition(
            "split",
            {"out1": 1, "kanban2": 1, "kanban3": 1},
            {"kanban1": 1, "machine2": 1, "machine3": 1},
        ),
        Transition("join", {"out2": 1, "out3": 1, "kanban4": 1}, {"kanban2": 1, "kanban3": 1, "machine4": 1}),
        Transition("leave", {"out4": 1}, {"kanban4": 1}),
    ]
    return CompiledNet.build(places, transitions)


def flexible_manufacturing(pallets: int) -> CompiledNet:
    """Flexible manufacturing system with three machines (Ciardo and Trivedi, 1993)."""
    names = [
        "P1wM1",
        "P1M1",
        "P1d",
        "P1s",
        "P1wP2",
        "P2wM2",
        "P2M2",
        "P2d",
        "P2s",
        "P2wP1",
        "P12",
        "P12wM3",
        "P12M3",
        "P12s",
        "P3M2",
        "P3s",
    ]
    places = {
        "P1": pallets,
        "P2": pallets,
        "P3": pallets,
        "M1": 3,
        "M2": 1,
        "M3": 2,
        **dict.fromkeys(names, 0),
    }
    arcs = """tP1: P1 > P1wM1; tM1: P1wM1 M1 > P1M1; tP1M1: P1M1 > P1d M1; tP1e: P1d > P1s; tP1j: P1d > P1wP2;
        tP1s: P1s > P1; tP2: P2 > P2wM2; tM2: P2wM2 M2 > P2M2; tP2M2: P2M2 > P2d M2; tP2e: P2d > P2s;
        tP2j: P2d > P2wP1; tP2s: P2s > P2; tx: P1wP2 P2wP1 > P12; tP12: P12 > P12wM3; tM3: P12wM3 M3 > P12M3;
        tP12M3: P12M3 > P12s M3; tP12s: P12s > P1 P2; tP3: P3 > P3M2; tP3M2: P3M2 M2 > P3s M2; tP3s: P3s >
        P3"""
    return CompiledNet.build(places, [_transition(line) for line in arcs.split(";")])


def round_robin_mutex(processes: int) -> CompiledNet:
    """Mutual exclusion by a token that goes round: a process that has it works once, or passes it on."""
    places: dict[str, int] = {}
    transitions = []
    for i in range(processes):
        places |= {f"idle{i}": 1, f"wait{i}": 0, f"critical{i}": 0, f"turn{i}": int(i == 0)}
        after = f"turn{(i + 1) % processes}"
        transitions += [
            Transition(f"ask{i}", {f"idle{i}": 1}, {f"wait{i}": 1}),
            Transition(f"enter{i}", {f"wait{i}": 1, f"turn{i}": 1}, {f"critical{i}": 1}),
            Transition(f"leave{i}", {f"critical{i}": 1}, {f"idle{i}": 1, after: 1}),
            Transition(f"pass{i}", {f"turn{i}": 1}, {after: 1}, {f"wait{i}": 1}),
        ]
    return CompiledNet.build(places, transitions)


def swimming_pool(scale: int) -> CompiledNet:
    """Swimming pool with cabins and bags (Berard and Fribourg, 1999), as in the Model Checking Contest."""
    places = {"Out": 20 * scale, "Cabins": 10 * scale, "Bags": 15 * scale}
    places |= dict.fromkeys(["Entered", "WaitBag", "Undress", "InBath", "Dress", "Dressed"], 0)
    arcs = """Enter: Out > Entered; GetK: Entered Cabins > WaitBag; GetB: WaitBag Bags > Undress;
        RKey: Undress > InBath Cabins; GetK2: InBath Cabins > Dress; RBag: Dress > Dressed Bags;
        RelK: Dressed > Out Cabins"""
    return CompiledNet.build(places, [_transition(line) for line in arcs.split(";")])


def _transition(line: str) -> Transition:
    name, arcs = line.strip().split(":")
    inputs, outputs = arcs.split(">")
    return Transition(name, dict.fromkeys(inputs.split(), 1), dict.fromkeys(outputs.split(), 1))
