"""The flattened case study, written down directly: plain dictionaries, no rule engine, no metamodel.

An independent second source for the nets that the flattening rules must produce (semantics, section 3),
used to test the rules and as the main benchmark of the engines.
"""

from __future__ import annotations

from typing import Literal

from dineros.analysis.nets.compiled import CompiledNet, Transition

SignalVariant = Literal["none", "input", "io", "fully"]
OverflowVariant = Literal["inhibitor", "weighted"]
SIGNAL_VARIANTS: tuple[SignalVariant, ...] = ("none", "input", "io", "fully")

PUBLISHER_LIMIT = SUBSCRIBER_LIMIT = 10
DISPATCHER_LIMIT = 16
COLOURS = ("Red", "Blue", "Green")
ROBOTS = ("L", "R")

Literals = list[tuple[str, bool]]

#: (places, transitions) of the flattened net by variant, and reachable markings by (red, blue, green).
SIZES: dict[SignalVariant, tuple[int, int]] = {
    "none": (149, 127),
    "input": (188, 185),
    "io": (188, 243),
    "fully": (188, 145),
}
MARKINGS: dict[tuple[int, int, int], dict[SignalVariant, int]] = {
    (1, 0, 0): {"none": 432, "input": 4_942, "io": 30_016, "fully": 221_184},
    (1, 1, 0): {"none": 9_640, "input": 156_920, "io": 1_848_960, "fully": 4_935_680},
    (1, 1, 1): {"none": 330_112, "input": 6_484_580, "io": 147_263_744, "fully": 169_017_344},
}


class _Builder:
    def __init__(self, overflow: OverflowVariant) -> None:
        self.overflow = overflow
        self.places: dict[str, int] = {}
        self.inputs: dict[str, dict[str, int]] = {}
        self.outputs: dict[str, dict[str, int]] = {}
        self.inhibitors: dict[str, dict[str, int]] = {}
        self.reads: dict[str, dict[str, int]] = {}
        self.clauses: dict[str, list[Literals]] = {}

    def place(self, name: str, tokens: int = 0) -> str:
        assert name not in self.places, name
        self.places[name] = tokens
        return name

    def transition(self, name: str, inputs: list[str], outputs: list[str]) -> str:
        assert name not in self.inputs, name
        self.inputs[name] = dict.fromkeys(inputs, 1)
        self.outputs[name] = dict.fromkeys(outputs, 1)
        self.inhibitors[name] = {}
        self.reads[name] = {}
        return name

    def queue(self, prefix: str, source: str, limit: int, sinks: list[str]) -> None:
        load, capacity = self.place(f"{prefix}.Load"), self.place(f"{prefix}.Capacity", limit)
        self.transition(f"{prefix}.T_in", [source, capacity], [load])
        self.transition(f"{prefix}.T_out", [load], [capacity, *sinks])
        drop = self.transition(f"{prefix}.T_drop", [source], [])
        if self.overflow == "inhibitor":
            self.inhibitors[drop][capacity] = 1
        else:
            self.reads[drop][load] = limit

    def topic(self, name: str, publishers: list[str], subscribers: dict[str, list[str]]) -> None:
        topic = self.place(f"{name}.P_topic")
        for place in publishers:
            self.queue(f"{name}.publish.{place}", place, PUBLISHER_LIMIT, [topic])
        inlets = [self.place(f"{name}.In.{node}") for node in subscribers]
        self.transition(f"{name}.T_topic", [topic], inlets)
        for (node, places), inlet in zip(subscribers.items(), inlets, strict=True):
            entries = [self.place(f"{name}.In.{node}.{place}") for place in places]
            self.queue(f"{name}.dispatch.{node}", inlet, DISPATCHER_LIMIT, entries)
            for place, entry in zip(places, entries, strict=True):
                self.queue(f"{name}.subscribe.{place}", entry, SUBSCRIBER_LIMIT, [place])

    def service(self, name: str, clients: dict[str, tuple[str, str]], servers: list[tuple[str, str]]) -> None:
        for i, _ in enumerate(servers):
            self.place(f"{name}.active{i}")
            self.place(f"{name}.inactive{i}", 1)
        for c, (request, response) in clients.items():
            ready = self.place(f"{name}.ready{c}", 1)
            requests, responses = self.place(f"{name}.requests{c}"), self.place(f"{name}.responses{c}")
            self.transition(f"{name}.T_req{c}", [request, ready], [requests])
            self.transition(f"{name}.T_res{c}", [responses], [response, ready])
            for i, (entry, exit_) in enumerate(servers):
                in_use = self.place(f"{name}.inUse{c}{i}")
                active, inactive = f"{name}.active{i}", f"{name}.inactive{i}"
                self.transition(f"{name}.T_call{c}{i}", [requests, inactive], [entry, active, in_use])
                self.transition(f"{name}.T_return{c}{i}", [exit_, active, in_use], [responses, inactive])

    def signals(self, variant: SignalVariant) -> None:
        if variant == "none":
            return
        uses: dict[str, list[str]] = {}
        disjunctions: dict[str, Literals] = {}
        inputs = {x: list(self.inputs[x]) for x in self.clauses}
        outputs = {x: list(self.outputs[x]) for x in self.clauses}
        for x, clause in self.clauses.items():
            for k, literals in enumerate(clause):
                # All signals start false, so exactly the negated literals are true.
                d = self.place(f"{x}.D{k}", sum(not plain for _, plain in literals))
                disjunctions[d] = literals
                self.reads[x][d] = 1
                for signal, _ in literals:
                    users = uses.setdefault(signal, [])
                    if x not in users:
                        users.append(x)
        for s, users in uses.items():
            self.place(s)
            self.place(f"not {s}", 1)
            if variant == "fully":
                self.pair(s, "", disjunctions, [])
                continue
            for x in users:
                self.pair(s, f".{x}", disjunctions, inputs[x])
                if variant == "io":
                    self.pair(s, f".{x}.Out", disjunctions, outputs[x])

    def pair(self, s: str, suffix: str, disjunctions: dict[str, Literals], reads: list[str]) -> None:
        to_true = self.transition(f"toTrue.{s}{suffix}", [f"not {s}"], [s])
        to_false = self.transition(f"toFalse.{s}{suffix}", [s], [f"not {s}"])
        for d, literals in disjunctions.items():
            for signal, plain in literals:
                if signal == s:
                    up, down = (to_true, to_false) if plain else (to_false, to_true)
                    self.outputs[up][d] = 1
                    self.inputs[down][d] = 1
        for transition in (to_true, to_false):
            self.reads[transition].update(dict.fromkeys(reads, 1))

    def compile(self) -> CompiledNet:
        return CompiledNet.build(
            self.places,
            [
                Transition(t, self.inputs[t], self.outputs[t], self.inhibitors[t], self.reads[t])
                for t in self.inputs
            ],
        )


def reference_case_study(
    objects: tuple[int, int, int],
    signals: SignalVariant = "none",
    overflow: OverflowVariant = "inhibitor",
) -> CompiledNet:
    """The flattened case study with (red, blue, green) objects."""
    net = _Builder(overflow)
    for colour, tokens in zip(COLOURS, objects, strict=True):
        pool, sort = net.place(f"{colour}Objects", tokens), net.place(f"Sort{colour}")
        net.clauses[net.transition(f"Select{colour}", [pool], [sort])] = [[(colour, True)]]
    for x in ROBOTS:
        chain = ["ReqControl", "GetReq", "GetRes", "PickReq", "PickRes", "PlaceReq", "PlaceRes"]
        for name in [*chain, "EndReq", "EndRes", "Result"]:
            net.place(name + x)
        steps = [("TReqControl", "ReqControl", "GetReq"), ("TStartPick", "GetRes", "PickReq")]
        steps += [("TStartPlace", "PickRes", "PlaceReq"), ("TRelease", "PlaceRes", "EndReq")]
        for name, source, target in [*steps, ("TReport", "EndRes", "Result")]:
            net.transition(name + x, [source + x], [target + x])
    net.place("StateGet", 1)
    net.place("StateEnd")
    net.place("Unsafe", 1)
    net.place("Safe")
    for name in ("SensorReq", "SensorRes", "Feedback", "Shown"):
        net.place(name)
    _servers(net)
    net.transition("TRetry", ["Unsafe"], ["SensorReq"])
    net.transition("TSafe", ["SensorRes"], ["Safe"])
    net.transition("TUnsafe", ["SensorRes"], ["Unsafe"])
    net.clauses[net.transition("TStop", ["Safe"], ["SensorReq"])] = [[("Danger", True)]]
    net.transition("TShowResult", ["Feedback"], ["Shown"])
    net.topic("LeftCellObjects", ["SortRed", "SortBlue"], {"controller": ["ReqControlL"]})
    net.topic("RightCellObjects", ["SortGreen"], {"controller": ["ReqControlR"]})
    net.topic("UITopic", ["ResultL", "ResultR"], {"feedback": ["Feedback"]})
    net.signals(signals)
    return net.compile()


def _servers(net: _Builder) -> None:
    for operation, source, target in (("Get", "StateGet", "StateEnd"), ("End", "StateEnd", "StateGet")):
        servers = []
        for i in range(len(ROBOTS)):
            entry, exit_ = net.place(f"{operation}Entry{i}"), net.place(f"{operation}Exit{i}")
            net.transition(f"T{operation}{i}", [entry, source], [exit_, target])
            servers.append((entry, exit_))
        clients = {x: (f"{operation}Req{x}", f"{operation}Res{x}") for x in ROBOTS}
        net.service(f"{operation}Control", clients, servers)
    for operation in ("Pick", "Place"):
        done = f"ObjectIs{operation}{'ed' if operation == 'Pick' else 'd'}"
        servers = []
        for i in range(len(ROBOTS)):
            entry, run, exit_ = (net.place(f"{operation}{part}{i}") for part in ("Entry", "Run", "Exit"))
            net.transition(f"T{operation}{i}", [entry, "Safe"], [run, "Safe"])
            idle: Literals = [("RobotIsIdle", True), ("RobotHasFinished", True)]
            for outcome, plain in (("Success", True), ("Fail", False)):
                x = net.transition(f"T{operation}{outcome}{i}", [run], [exit_])
                net.clauses[x] = [idle, [(done, plain)]]
            net.transition(f"T{operation}Abort{i}", [run, "Unsafe"], [exit_, "Unsafe"])
            servers.append((entry, exit_))
        net.service(operation, {x: (f"{operation}Req{x}", f"{operation}Res{x}") for x in ROBOTS}, servers)
    entry, exit_ = net.place("SensorEntry0"), net.place("SensorExit0")
    net.clauses[net.transition("TSense0", [entry], [exit_])] = [[("Sensor", True)]]
    net.service("SensorService", {"E": ("SensorReq", "SensorRes")}, [(entry, exit_)])
