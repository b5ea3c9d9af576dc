"""Response times of callbacks, and late and lost ticks, on a clock that the test moves."""

from __future__ import annotations

import pytest

from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.runtime.application.simulation import LocalApplication, SimulatedClock
from dineros.runtime.nodes.health import HealthWatch
from dineros.runtime.ros.diagnostics import parts_of
from dineros.runtime.ros.metrics import metrics_text
from dineros.runtime.ros.overview import NodeView
from dineros.transformations.flattening.split import split


def model() -> sym.SystemModel:
    """Return a node with a timer of 0.1 s, of two steps, whose duration is declared."""
    made = sym.SystemModel(id="watch", middleware="ros2")
    eye = node_net(made, "eye", execution="callbacks")
    on_timer = callback(eye, "OnTimer", "timer", 0.1, duration=seconds(0.0, 0.02), jitter=0.01)
    half = place(on_timer, "Half")
    step(on_timer, "Grab", [], [half])
    step(on_timer, "Send", [half], [])
    return made


class Node:
    """The node: each of the steps takes what `works` has, in seconds of the clock; a move takes 1 ms."""

    def __init__(self, works: list[float]) -> None:
        self.application = LocalApplication(split(model()), seed=1)
        clock = self.application.clock
        assert isinstance(clock, SimulatedClock)

        def work(firing: object) -> None:
            clock.now += works.pop(0) if works else 0.0

        for transition in ("Grab", "Send"):
            self.application.nets["eye"].handler(transition)(work)
        self.watch = HealthWatch(self.application.nets["eye"].core)

    def run(self, seconds: float) -> None:
        with self.application as application:
            application.run(lambda _: False, seconds)


NEAR = 0.006


def test_a_response_goes_from_the_strike_to_the_end() -> None:
    """The second run has to wait for the first, which takes 130 ms: it strikes at 200, begins at 230."""
    node = Node([0.03, 0.1, 0.001, 0.002])
    node.run(0.35)
    (time,) = node.watch.look().responses
    assert time.runs == 3
    assert time.greatest == pytest.approx(0.13, abs=NEAR)
    assert time.work == pytest.approx(0.13, abs=NEAR)
    assert (time.over, time.lost) == (1, 0)
    assert time.late == 1


def test_a_tick_that_finds_the_last_one_waiting_is_lost() -> None:
    node = Node([0.15, 0.2])
    node.run(0.55)
    (time,) = node.watch.look().responses
    # Strikes at 100 (until 450), then at 200, 300 and 400, of which one waits.
    assert time.lost == 2
    assert time.greatest == pytest.approx(0.35, abs=NEAR)


def test_what_is_declared_stands_beside_what_is_measured() -> None:
    node = Node([0.03, 0.1])
    node.run(0.35)
    health = node.watch.look()
    _, _, values = parts_of(health)["callbacks"]
    assert [name for name, _ in values] == ["OnTimer"]
    text = str(dict(values)["OnTimer"])
    assert text.startswith("response 0.13")
    assert "run 0.13 s of declared 0 s to 0.02 s, 1 too long" in text
    assert text.endswith("1 late and 0 lost ticks of 0.1 s")
    metrics = metrics_text("/eye", health)
    assert 'dineros_over_duration_total{node="/eye",callback="OnTimer"} 1' in metrics
    assert 'dineros_duration_seconds_declared{node="/eye",callback="OnTimer"} 0.02' in metrics
    (concern,) = health.concerns
    assert concern.text == "the callback OnTimer took 0.13 s; declared: at most 0.02 s"
    after = node.watch.look()
    assert after.responses[0].longest == 0.0 and not after.concerns


def test_lost_ticks_are_a_concern() -> None:
    node = Node([0.15, 0.2])
    node.run(0.55)
    (concern,) = node.watch.look().concerns
    assert concern.text.endswith("; the timer of OnTimer lost 2 ticks")


def test_top_shows_the_slowest_callback() -> None:
    text = "response 0.131 s, mean 0.055 s, greatest 0.2 s, run 0.13 s"
    parts = {"callbacks": {"OnTimer": text, "OnScan": "response 0.2 s, mean 1 s", "Odd": "response nan s"}}
    assert NodeView("/eye", parts=parts).slowest == (0.2, "OnScan")
    assert NodeView("/eye").slowest is None
