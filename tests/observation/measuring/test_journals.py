"""Times in traces, beside the true times of runs that are made up."""

from __future__ import annotations

from collections import defaultdict
from dataclasses import replace
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel.records import Fire, Header
from dineros.observation.measuring.declared import Comparison
from dineros.observation.measuring.journals import JournalTimes
from dineros.observation.measuring.seen import Part, Seen
from tests.observation.measuring.camera import PERIOD, KnownRun, camera

TIGHT = 1e-6
LATENCY = Part("latency", "Images", "Image", "Seen")


def seen_of(run: KnownRun) -> dict[Part, list[Seen]]:
    found: defaultdict[Part, list[Seen]] = defaultdict(list)
    times = JournalTimes(camera(), {node: partial(iter, kept) for node, kept in run.records.items()})
    for each in times.seen():
        found[each.part].append(each)
    return found


def true_times(run: KnownRun) -> dict[Part, list[float]]:
    return {
        Part("period", "OnTimer"): run.periods,
        Part("duration", "OnImage"): run.durations,
        LATENCY: run.latencies,
    }


@given(seed=st.integers(0, 10**6), jitter=st.sampled_from([0.0, 0.03]))
def test_the_true_times_lie_within_the_bounds(seed: int, jitter: float) -> None:
    """Callbacks of up to 250 ms beside a timer of 100 ms: ticks are lost, messages wait."""
    run = KnownRun(seed, jitter=jitter)
    found = seen_of(run)
    for part, known in true_times(run).items():
        assert len(found[part]) == len(known)
        for seen, true in zip(found[part], known, strict=True):
            assert seen.least - TIGHT <= true <= seen.most + TIGHT, (part, seen, true)


@given(seed=st.integers(0, 10**6))
def test_where_nothing_waits_the_times_are_exact(seed: int) -> None:
    run = KnownRun(seed, quick=True)
    found = seen_of(run)
    for part, known in true_times(run).items():
        times = [each.least for each in found[part]]
        assert times == pytest.approx(known, abs=TIGHT), part
    assert all(each.least == pytest.approx(PERIOD) for each in found[Part("period", "OnTimer")])


def breaches(run: KnownRun, allowance: float = 0.001) -> list[str]:
    comparison = Comparison(camera(), allowance)
    for all_seen in seen_of(run).values():
        for seen in all_seen:
            comparison.take(seen, 1000.0)
    return [f"{each.rule} {each}" for each in comparison.breaches()]


@given(seed=st.integers(0, 10**6), jitter=st.sampled_from([0.0, 0.01]))
def test_a_run_within_its_times_breaks_none(seed: int, jitter: float) -> None:
    assert [each for each in breaches(KnownRun(seed, quick=True, jitter=jitter)) if "short" not in each] == []


@given(seed=st.integers(0, 10**6))
def test_a_busy_timer_is_not_called_late(seed: int) -> None:
    """However long the callback takes, the timer itself strikes in step."""
    assert not [each for each in breaches(KnownRun(seed)) if each.startswith("period")]


@given(seed=st.integers(0, 10**6))
def test_what_breaks_a_time_is_found_exactly(seed: int) -> None:
    """Each run of the detector that takes longer than 20 ms, less than 2 ms, by more than the allowance."""
    run = KnownRun(seed)
    found = breaches(run)
    for word, bad in (
        ("long", [each for each in run.durations if each > 0.021]),
        ("short", [each for each in run.durations if each < 0.001]),
    ):
        lines = [each for each in found if each.startswith(f"duration-too-{word} callback OnImage")]
        assert bool(lines) == bool(bad)
        assert not bad or f"({len(bad)} of {len(run.durations)})" in lines[0]


def test_a_breach_in_words() -> None:
    run = KnownRun(3, quick=True)
    kept = run.records["brain"]
    at = next(
        number for number, each in enumerate(kept) if isinstance(each, Fire) and each.transition == "Detect"
    )
    record = kept[at]
    assert isinstance(record, Fire) and record.time is not None
    kept[at] = replace(record, duration=0.083, time=1012.4)
    del kept[at + 1 :]
    for number, each in enumerate(kept[:at]):
        if isinstance(each, Fire):
            kept[number] = replace(each, duration=0.0)
    long = next(each for each in breaches(run) if "OnImage" in each)
    assert long == "duration-too-long callback OnImage took 83 ms at 12.4 s; declared: at most 20 ms"


def test_a_timer_that_strikes_late_although_its_node_is_idle() -> None:
    run = KnownRun(3, quick=True)
    eye = run.records["eye"]
    late = [replace(each, time=(each.time or 0) + 0.05) for each in eye if (each.time or 0) > 1002]
    run.records["eye"] = [each for each in eye if (each.time or 0) <= 1002] + late
    assert any(each.startswith("period-too-long ticks of callback OnTimer") for each in breaches(run))


def test_times_of_a_simulated_run_mean_nothing() -> None:
    run = KnownRun(3)
    for kept in run.records.values():
        assert isinstance(kept[0], Header)
        kept[0] = replace(kept[0], simulated=True)
    assert seen_of(run) == {}
