"""Times that traces and tracing files propose are exactly those that they were made of."""

from __future__ import annotations

import math
import random
from functools import partial
from itertools import pairwise
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import pages
from dineros.metamodel.files import load, save
from dineros.observation.importing.given import Given, GivenCallback, GivenNode
from dineros.observation.importing.given_reading import read_given
from dineros.observation.measuring.journals import JournalTimes
from dineros.observation.measuring.proposing import TimeProposal, give_times, time_proposals
from dineros.observation.measuring.samples import Samples, Summary
from dineros.observation.narrowing import traced
from dineros.observation.narrowing.written import given_text
from dineros.observation.systems import ObservedNode, ObservedSystem, TopicEndpoint
from dineros.observation.tracing import Tracing
from tests.observation.measuring.camera import KnownRun, camera
from tests.support.traces import Trace

MICRO = 1000


def ranked(values: list[float]) -> Summary:
    """Return what is to be said of values, by plain counting."""

    def quantile(percent: int) -> float:
        return next(v for v in sorted(values) if 100 * sum(w <= v for w in values) >= percent * len(values))

    return Summary(len(values), min(values), quantile(50), quantile(95), quantile(99), max(values))


@given(st.lists(st.floats(0, 10), min_size=1, max_size=300))
def test_quantiles_are_observed_times_of_their_rank(values: list[float]) -> None:
    assert Samples(values).summary() == ranked(values)


def test_many_times_are_kept_as_a_sample_with_exact_extremes() -> None:
    draw = random.Random(1)
    values = [draw.uniform(0, 1) for _ in range(20_000)]
    found, exact = Samples(values, most=2000).summary(), ranked_quickly(values)
    assert (found.count, found.least, found.greatest) == (exact.count, exact.least, exact.greatest)
    assert found.median == pytest.approx(exact.median, abs=0.05)
    assert found.q95 == pytest.approx(exact.q95, abs=0.03)


def ranked_quickly(values: list[float]) -> Summary:
    at = sorted(values)
    ranks = (at[math.ceil(len(at) * share) - 1] for share in (0.5, 0.95, 0.99))
    return Summary(len(at), at[0], *ranks, at[-1])  # type: ignore[call-arg]


SYSTEM = ObservedSystem(
    "a test",
    (
        ObservedNode("/lidar", (TopicEndpoint("/scan", "std_msgs/msg/String"),)),
        ObservedNode("/mapper", (), (TopicEndpoint("/scan", "std_msgs/msg/String"),)),
    ),
)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6), jitter=st.sampled_from([0, 4000]))
def test_times_of_tracing_files_are_found_exactly(seed: int, jitter: int, tmp_path: Path) -> None:
    draw, trace = random.Random(seed), Trace()
    lidar, mapper = trace.node("/lidar"), trace.node("/mapper")
    tick = trace.timer(lidar, 100_000 * MICRO)
    on_scan = trace.subscription(mapper, "/scan")
    works: list[float] = []
    scans: list[float] = []
    begins: list[int] = []
    for number in range(1, 30):
        strike = number * 100_000 + draw.randint(0, jitter)
        for callback, thread, taken in ((tick, 2, works), (on_scan, 3, scans)):
            begin = strike + (20_000 if callback == on_scan else 0)
            took = draw.randint(1, 15_000)
            trace.at((begin - 1) * MICRO)  # an event comes a microsecond later
            trace.start(callback, thread=thread)
            trace.at((begin + took - 1) * MICRO)
            trace.end(callback, thread=thread)
            taken.append(took / 1e6)
        begins.append(strike)
    found = {
        (each.feature, each.element): each
        for each in traced(SYSTEM, Tracing(trace.write(tmp_path / "trace.txt"))).times("trace.txt")
    }
    gaps = [(after - before) / 1e6 for before, after in pairwise(begins)]
    for key, values in (
        (("duration", "/lidar timer_100ms"), works),
        (("duration", "/mapper /scan"), scans),
        (("period", "/lidar timer_100ms"), gaps),
    ):
        assert_same(found.pop(key).summary, ranked(values))  # type: ignore[arg-type]
    assert not found


def assert_same(found: Summary, known: Summary) -> None:
    assert found.count == known.count
    for name, value in vars(known).items():
        assert getattr(found, name) == pytest.approx(value, abs=1e-8), name


@settings(deadline=None, max_examples=30)
@given(seed=st.integers(0, 10**6))
def test_times_of_a_run_become_intervals_that_hold_them(seed: int) -> None:
    run, model = KnownRun(seed, quick=True, jitter=0.004), camera()
    times = JournalTimes(model, {node: partial(iter, kept) for node, kept in run.records.items()})
    found = {(each.feature, each.element): each for each in time_proposals(model, times.seen(), "run")}
    for key, values in (
        (("duration", "OnImage"), run.durations),
        (("latency", "Seen"), run.latencies),
        (("period", "OnTimer"), run.periods),
    ):
        assert_near(found[key].summary, ranked(values))  # type: ignore[index]
    give_times(model, found.values())
    by_id = {page.id: page for page in pages(model) if isinstance(page, sym.CallbackPage)}
    reader = model.channels[0].subscribers[0]  # type: ignore[attr-defined]
    for interval, values in ((by_id["OnImage"].duration, run.durations), (reader.latency, run.latencies)):
        assert isinstance(interval, pn.TimeInterval) and interval.latest is not None
        assert min(values) - 1.1e-6 <= interval.earliest <= min(values) + 1e-7
        assert max(values) - 1e-7 <= interval.latest <= max(values) + 1.1e-6
        assert str(interval.source).startswith(f"run: {len(values)} measured: least ")
    assert by_id["OnTimer"].timer == 0.1
    assert by_id["OnTimer"].jitter == pytest.approx(max(abs(each - 0.1) for each in run.periods), abs=2e-6)


def assert_near(found: Summary, known: Summary) -> None:
    assert found.count == known.count
    for name, value in vars(known).items():
        assert getattr(found, name) == pytest.approx(value, abs=1e-6), name


@pytest.mark.parametrize("suffix", [".sym.xmi", ".pnml"])
def test_the_source_of_an_interval_is_kept_in_files(suffix: str, tmp_path: Path) -> None:
    model = camera()
    proposal = TimeProposal("duration", "OnImage", "x", Samples([0.001, 0.01] * 5).summary(), "run")
    give_times(model, [proposal])
    path = tmp_path / f"measured{suffix}"
    save(model, path)
    again = next(page for page in pages(load(path)) if page.id == "OnImage")
    assert isinstance(again, sym.CallbackPage) and again.duration is not None
    assert again.duration.source == proposal.origin
    assert (again.duration.earliest, again.duration.latest) == (0.001, 0.01)


def test_what_is_given_of_times_is_read_again(tmp_path: Path) -> None:
    callback = GivenCallback(None, takes=(0.001, 0.02), jitter=0.0, measured='a "run": 3 measured')
    given = Given({"/a": GivenNode(timers={"tick": 0.1}, callbacks={"tick": callback})})
    path = tmp_path / "a.given.toml"
    path.write_text(given_text(given))
    assert read_given(path).nodes == given.nodes
