"""Traces for tests of the Trace Visualizer: a witness with a loop, a run of three nodes, and a long run."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from dineros.metamodel.records import (
    Checkpoint,
    Drop,
    Error,
    Fire,
    Header,
    Publish,
    Record,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Start,
    Stop,
    StoredToken,
    Take,
    Timeout,
    write_records,
)

CASE_STUDY = Path(__file__).resolve().parents[2] / "case_study" / "sorting.sym.xmi"


class Scribe:
    """Numbers the records of one trace, and gives those of a run a time and a node."""

    def __init__(self, node: str | None = None, start: float = 1000.0) -> None:
        self.node, self.now = node, start
        self.records: list[Record] = []

    def write(self, record: type[Record], after: float = 0.0, /, **fields: Any) -> Scribe:
        """Add a record, some seconds after the last."""
        if self.node is not None:
            self.now += after
            fields = {"node": self.node, "time": self.now, **fields}
        self.records.append(record(sequence=len(self.records), **fields))
        return self

    def save(self, path: Path) -> Path:
        """Write the trace to a file."""
        write_records(path, self.records)
        return path


def lasso(*, differs: bool = False) -> Scribe:
    """Return a witness of the case study: a signal, a clause, a topic, a service, then a loop."""
    witness = Scribe()
    witness.write(
        Header,
        kind="witness",
        model="sorting",
        source=str(CASE_STUDY),
        property="G (Shown < 1 & signal(Red))",
        verdict="violated",
        loop=8,
        signals="input-enabled",
        overflow="weighted",
        marking={
            "RedObjects": 1,
            "Unsafe": 1,
            "Red.false": 1,
            "LeftCellObjects.publisher.SortRed.Capacity": 10,
        },
        signals_initial={"Blue": False, "Red": False, "Danger": False},
    )
    witness.write(
        Fire, transition="TRetry", node="executor", text="TRetry", change={"Unsafe": -1, "SensorReq": 1}
    )
    witness.write(
        Signal,
        signal="Red",
        value=True,
        transition="Red.toTrue.SelectRed",
        text="signal Red becomes true",
        change={"Red.false": -1, "Red.true": 1, "SelectRed.D1": 1},
    )
    witness.write(
        Fire,
        transition="SelectRed",
        node="selector",
        text="SelectRed",
        change={"RedObjects": -1, "SortRed": 1},
    )
    load, capacity = (f"LeftCellObjects.publisher.SortRed.{name}" for name in ("Load", "Capacity"))
    witness.write(
        Publish,
        channel="LeftCellObjects",
        place="SortRed",
        transition="publish",
        text="publisher queue takes a message",
        change={"SortRed": -1, load: 1, capacity: -1},
    )
    call = {"channel": "SensorService", "client": "safety"}
    witness.write(Request, **call, place="SensorReq", transition="req", change={"SensorReq": -1})
    witness.write(
        Serve,
        **call,
        instance=1,
        place="SensorService[1].SensorEntry",
        transition="call",
        change={"SensorService[1].SensorEntry": 1},
    )
    witness.write(
        Drop, channel="LeftCellObjects", queue="publisher", place="SortRed", transition="drop", change={}
    )
    for value in (True, False):
        signal = "Blue" if differs else "Danger"
        witness.write(Signal, signal=signal, value=value, transition=f"{signal}.{value}", change={})
    return witness


def run() -> dict[str, Scribe]:
    """Return the traces of three nodes of the case study; the clock of the server is 5 s behind."""
    selector, controller, synchronizer = (
        Scribe("selector"),
        Scribe("controller", 1000.2),
        Scribe("synchronizer", 995.0),
    )
    for scribe, marking in (
        (selector, {"RedObjects": [StoredToken(1, {"color": "red"})]}),
        (controller, {}),
        (synchronizer, {"StateGet": [StoredToken(1, {})]}),
    ):
        scribe.write(Header, kind="run", model="sorting", source=str(CASE_STUDY))
        signals = {"Red": False} if scribe is selector else {}
        scribe.write(Checkpoint, marking=marking, signals=signals)
        scribe.write(Start, marking=marking, signals=signals, seed=1)
    red = StoredToken(2, {"color": "red"})
    selector.write(Signal, 0.5, signal="Red", value=True, source="user")
    selector.write(
        Fire,
        0.1,
        transition="SelectRed",
        change={"RedObjects": -1, "SortRed": 1},
        taken={"RedObjects": [1]},
        made={"SortRed": [red]},
        handlers=["announce"],
        duration=0.05,
    )
    topic = {"channel": "LeftCellObjects", "message": "selector/SortRed/1"}
    selector.write(Publish, 0.1, **topic, place="SortRed", token=2, change={"SortRed": -1})
    selector.write(Stop, 5.0, reason="stopped")
    # By its clock the controller takes the message before it is sent.
    controller.write(
        Take, 0.3, **topic, place="ReqControlL", token=1, data=red.data, change={"ReqControlL": 1}
    )
    controller.write(
        Error, 0.1, transition="TReqControlL", handler="ask", error="ValueError: no", policy="retry"
    )
    controller.write(Fire, 0.1, transition="TReqControlL", change={"ReqControlL": -1, "GetReqL": 1})
    call = {"channel": "GetControl", "message": "controller/GetReqL/1"}
    controller.write(Request, 0.1, **call, client="L", place="GetReqL", token=2, change={"GetReqL": -1})
    controller.write(Timeout, 0.4, channel="GetControl", client="L", message="controller/GetReqL/1")
    synchronizer.write(
        Serve,
        0.1,
        **call,
        instance=2,
        place="GetControl[2].GetEntry",
        token=2,
        change={"GetControl[2].GetEntry": 1},
    )
    synchronizer.write(
        Fire,
        0.1,
        transition="GetControl[2].TGet",
        change={"GetControl[2].GetEntry": -1, "StateGet": -1, "GetControl[2].GetExit": 1, "StateEnd": 1},
    )
    synchronizer.write(
        Reply,
        0.1,
        **call,
        client="L",
        instance=2,
        place="GetControl[2].GetExit",
        token=3,
        change={"GetControl[2].GetExit": -1},
    )
    controller.write(Response, 0.1, **call, client="L", place="GetResL", token=3, change={"GetResL": 1})
    second = {**call, "message": "controller/GetReqL/2"}
    controller.write(
        Request, 0.1, **second, client="L", place="GetReqL", token=4, change={}
    )  # never answered
    controller.write(Drop, 0.1, channel="LeftCellObjects", queue="subscriber", place="ReqControlL", count=3)
    return {scribe.node or "": scribe for scribe in (selector, controller, synchronizer)}


def save_run(folder: Path) -> Path:
    """Write the run to a folder."""
    folder.mkdir(exist_ok=True)
    for node, scribe in run().items():
        scribe.save(folder / f"{node}.jsonl")
    return folder


def long_run(steps: int) -> Scribe:
    """Return the run of a node that works, signals, publishes and calls a service, for so many steps."""
    node = Scribe("executor")
    node.write(Header, kind="run", model="sorting", source="")
    node.write(Start, marking={"Safe": [StoredToken(1, {})]}, signals={"Danger": False})
    for number in range(steps):
        match number % 8:
            case 0 | 4:
                node.write(Signal, 0.01, signal="Danger", value=number % 8 == 0)
            case 1:
                node.write(
                    Fire, 0.01, transition="TStop", change={"Safe": -1, "SensorReq": 1}, handlers=["h"]
                )
            case 2:
                node.write(
                    Request,
                    0.01,
                    channel="SensorService",
                    client="safety",
                    place="SensorReq",
                    message=f"executor/SensorReq/{number}",
                    change={"SensorReq": -1},
                )
            case 3:
                node.write(
                    Serve,
                    0.01,
                    channel="SensorService",
                    client="safety",
                    instance=1,
                    place="E",
                    message=f"executor/SensorReq/{number - 1}",
                    change={"E": 1},
                )
            case 5:
                node.write(
                    Response,
                    0.01,
                    channel="SensorService",
                    client="safety",
                    place="SensorRes",
                    message=f"executor/SensorReq/{number - 3}",
                    change={"E": -1, "SensorRes": 1},
                )
            case 6:
                node.write(Fire, 0.01, transition=f"T{number // 8 % 40}", change={"SensorRes": -1, "Safe": 1})
            case _:
                node.write(
                    Publish, 0.01, channel="UITopic", place="ResultL", message=f"executor/ResultL/{number}"
                )
    return node


def schedule() -> Scribe:
    """Return a witness of a plain net with times: one moment, a window, and an open window."""
    witness = Scribe()
    witness.write(Header, kind="witness", model="plant", property="sent >= 1", verdict="reachable")
    for at, name, latest in ((100.0, "tick", 100.0), (130.0, "work", 190.0), (135.0, "send", None)):
        witness.write(
            Fire, transition=name, time=at, earliest=at, latest=latest, change={"sent": 1}, text=name
        )
    return witness
