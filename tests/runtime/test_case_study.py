"""The case study runs in one process: every object is sorted, nothing starts while it is unsafe."""

from __future__ import annotations

from collections import Counter
from typing import Any

import pytest

from dineros.metamodel.settings import apply
from dineros.runtime import Candidates, Enabled, Firing, Net
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal.recording import ListRecorder
from dineros.transformations.flattening.split import split
from tests.runtime.tiny import case_study

COLORS = {"Red": 3, "Blue": 2, "Green": 3}


class Cell:
    """The arms, a human who walks in and out, and the user; signals go through the developers' interface."""

    def __init__(self, application: LocalApplication, *, visits: bool) -> None:
        self.executor = application.nets["executor"]
        self.visits = visits
        self.human = False
        self.time = 0.0
        self.motion: tuple[str, float] | None = None
        self.shown: list[dict[str, Any]] = []
        self.selector = application.nets["selector"]
        for color in COLORS:
            self.selector.signal(color).set(True, "user")
            self.selector.handler(f"Select{color}")(self.name_color)
        application.nets["sensorics"].signal("Sensor").set(True, "sensor")
        self.executor.signal("RobotIsIdle").set(True, "arm")
        application.nets["sensorics"].handler("TSense")(self.sense)
        self.executor.handler("TPick", priority=1)(self.start)
        self.executor.handler("TPlace", priority=1)(self.start)
        for operation in ("Pick", "Place"):
            for outcome in ("Success", "Fail"):
                self.executor.handler(f"T{operation}{outcome}")(self.finish)
            self.executor.handler(f"T{operation}Abort", name="abort")(self.abort)
        self.executor.selection(prefer_by_sensor)
        application.nets["feedback"].handler("TShowResult", priority=1)(self.show)
        application.every(0.05, self.advance)

    def name_color(self, firing: Firing) -> dict[str, object]:
        return {"color": firing.transition.removeprefix("Select").lower()}

    def sense(self, firing: Firing) -> dict[str, object]:
        return {"humanDetected": self.human, "sensorData": f"at {self.time:.2f} s"}

    def start(self, firing: Firing) -> None:
        operation = "Picked" if firing.transition == "TPick" else "Placed"
        self.motion = (operation, 0.2)
        self.executor.signal(f"ObjectIs{operation}").set(False, "arm")
        self.executor.signal("RobotIsIdle").set(False, "arm")

    def finish(self, firing: Firing) -> dict[str, object]:
        field = "pickSuccess" if "Pick" in firing.transition else "placeSuccess"
        return {field: firing.transition.endswith("Success")}

    def abort(self, firing: Firing) -> dict[str, object]:
        self.motion = None
        self.executor.signal("RobotIsIdle").set(True, "arm")
        return {"errors": [*firing.data["errors"], firing.transition]}

    def show(self, firing: Firing) -> None:
        self.shown.append(dict(firing.data))

    def advance(self, seconds: float) -> None:
        self.time += seconds
        human = self.visits and 0.3 < self.time % 1.0 < 0.6
        if human is not self.human:
            self.human = human
            self.executor.signal("Danger").set(human, "scanner")
        if self.motion is not None:
            operation, left = self.motion
            self.motion = (operation, left - seconds)
            if left <= 0:
                self.motion = None
                self.executor.signal(f"ObjectIs{operation}").set(True, "arm")
                self.executor.signal("RobotIsIdle").set(True, "arm")


def prefer_by_sensor(enabled: Candidates) -> Enabled | None:
    """Take the safety transition that the sensor's data asks for; otherwise any (paper, Listing 2)."""
    for name, wanted in (("TUnsafe", True), ("TSafe", False)):
        candidate = enabled.named(name)
        if candidate and candidate.inputs["SensorRes"][0].data["humanDetected"] is wanted:
            return candidate
    others = [each for each in enabled if each.transition not in ("TSafe", "TUnsafe")]
    return others[0] if others else None


def parts() -> list[Any]:
    model = case_study()
    for color, count in COLORS.items():
        apply(model, f"{color}Objects.tokens={count}")
    return split(model)


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("visits", [False, True])
def test_all_objects_are_sorted(seed: int, visits: bool) -> None:
    recorders: dict[str, ListRecorder] = {}
    total = sum(COLORS.values())
    application = LocalApplication(
        parts(), seed=seed, recorder=lambda node: recorders.setdefault(node, ListRecorder())
    )
    cell = Cell(application, visits=visits)
    with application:
        outcome = application.run(lambda each: each.count("feedback", "Shown") == total, timeout=200)
    assert outcome == "reached"
    assert Counter(shown["color"] for shown in cell.shown) == {"red": 3, "blue": 2, "green": 3}
    assert all(shown["pickSuccess"] or shown["errors"] for shown in cell.shown)
    events = Counter(str(record["event"]) for recorder in recorders.values() for record in recorder.records)
    assert not {"error", "drop", "timeout"} & set(events)
    check_safety(recorders["executor"].records)
    if visits:
        assert any(record.get("transition") == "TUnsafe" for record in recorders["executor"].records)


def check_safety(records: list[dict[str, Any]]) -> None:
    """Replay the executor: no pick or place starts while `Unsafe` is marked, no reading is misjudged."""
    marking: Counter[str] = Counter()
    data: dict[int, Any] = {}
    for record in records:
        if record["event"] == "start":
            marking.update({place: len(tokens) for place, tokens in record["marking"].items()})
        if record["event"] == "response":
            data[record["token"]] = record["data"]
        if record["event"] == "fire":
            if str(record["transition"]).endswith((".TPick", ".TPlace")):
                assert marking["Unsafe"] == 0
                assert marking["Safe"] == 1
            if record["transition"] in ("TSafe", "TUnsafe"):
                (token,) = record["taken"]["SensorRes"]
                assert data[token]["humanDetected"] is (record["transition"] == "TUnsafe")
        marking.update(record.get("change", {}))


@pytest.mark.long
def test_on_threads_in_real_time() -> None:
    application = LocalApplication(parts(), seed=1, simulated_time=False)
    Cell(application, visits=True)
    with application:
        feedback: Net = application.nets["feedback"]
        feedback.wait_for(lambda state: state.count("Shown") == sum(COLORS.values()), timeout=120)
    assert all(net.inspect().failures == 0 for net in application.nets.values())
