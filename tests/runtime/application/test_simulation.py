"""A simulation keeps a pace where it is told to, and stays the same run."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from dineros.runtime.application import simulation
from dineros.runtime.application.simulation import LocalApplication
from dineros.transformations.flattening.split import split
from tests.runtime.channels.test_local import Recorders, talk


@pytest.fixture
def machine(monkeypatch: pytest.MonkeyPatch) -> SimpleNamespace:
    """The machine's time, which passes while somebody sleeps, and no otherwise."""
    found = SimpleNamespace(now=100.0)

    def sleep(seconds: float) -> None:
        assert seconds > 0
        found.now += seconds

    clock = SimpleNamespace(monotonic=lambda: found.now, sleep=sleep)
    monkeypatch.setattr(simulation, "time", clock)
    return found


def test_simulated_seconds_pass_at_a_pace(machine: SimpleNamespace) -> None:
    application, times = LocalApplication(split(talk(3)), seed=1), []
    application.every(0.5, lambda seconds: times.append((round(application.clock(), 6), machine.now - 100.0)))
    with application:
        assert application.run(lambda each: False, timeout=2.2, speed=4.0) == "timeout"
    assert [simulated for simulated, _ in times] == [0.5, 1.0, 1.5, 2.0]
    assert [real for _, real in times] == pytest.approx([0.125, 0.25, 0.375, 0.5])


def test_who_waits_hears_that_it_is_over(machine: SimpleNamespace) -> None:
    application = LocalApplication(split(talk(0)), seed=1)
    application.every(1000.0, lambda seconds: None)
    with application:
        assert application.run(lambda each: machine.now >= 100.3, speed=1.0) == "reached"
    assert machine.now == pytest.approx(100.3, abs=simulation.LONGEST_WAIT)


@pytest.mark.parametrize("speed", [0.5, 100.0])
def test_a_pace_changes_no_run(machine: SimpleNamespace, speed: float) -> None:
    def trace(speed: float | None) -> list[object]:
        recorders = Recorders()
        with LocalApplication(split(talk(5)), seed=3, recorder=recorders) as application:
            application.run(lambda each: each.count("listener", "noted") == 5, speed=speed)
        return [
            (node, each["event"], each.get("message"))
            for node, kept in recorders.items()
            for each in kept.records
        ]

    assert trace(speed) == trace(None)
