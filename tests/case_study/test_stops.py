"""Applications, stopped, killed and flooded: a short run of the benchmarks that do it for hours."""

from __future__ import annotations

from collections import Counter
from pathlib import Path
from typing import Any

import pytest

from benchmarks.endurance import flood, periodic, stops_and_kills
from benchmarks.endurance.applications import APPLICATIONS
from tests.support.programs.on_ros import on_ros


@pytest.mark.long
@pytest.mark.parametrize(("name", "pieces", "messages"), [("sorting", 2, 12), ("fleet", 8, 16)])
def test_nothing_is_lost_when_it_is_stopped_and_killed(
    name: str,
    pieces: int,
    messages: int,
    workspace: Path,  # its interfaces are built once
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Each piece of work is published to where it is done, and comes back."""
    monkeypatch.setattr(stops_and_kills, "KINDS", ("SIGINT", "SIGKILL", "node SIGKILL"))
    application = APPLICATIONS[name]
    with on_ros() as domain:
        lines: list[dict[str, Any]] = list(
            stops_and_kills.stress(application, tmp_path, 3, 2, pieces, domain, longest=1.5)
        )
    assert sum("stop" in line for line in lines) == 3
    assert sum(line.get("publish", 0) for line in lines) >= messages


@pytest.mark.long
def test_the_flooded_case_study_stays_flat(tmp_path: Path) -> None:
    with on_ros() as domain:
        samples = list(flood.flood(4.0, 400.0, 0.5, tmp_path, domain))
    assert samples[-1].messages > 100
    assert samples[-1].memory < samples[2].memory + 16
    assert Counter(sample.descriptors for sample in samples[1:]).most_common(1)[0][1] > len(samples) // 2


@pytest.mark.long
def test_the_periodic_publisher_stays_flat(tmp_path: Path) -> None:
    with on_ros() as domain:
        samples = list(periodic.run(6.0, 0.5, 0.02, 0.05, tmp_path, domain, journal=True))
    begun = samples[len(samples) // 2]  # before that, a busy machine may still load modules
    assert samples[-1].talker_anonymous < begun.talker_anonymous + 8
    assert samples[-1].logger_anonymous < begun.logger_anonymous + 8
    verdict = periodic.replayed(0.02, tmp_path)
    assert (verdict.status, verdict.violations) == ("conforms", [])
    assert verdict.steps > 100
    assert "drop" in (tmp_path / "journal/logger.jsonl").read_text()


def test_growth_is_that_of_a_straight_line_after_the_start() -> None:
    """Whatever it does while buffers fill."""
    samples = [periodic.Sample(s, 0.0, 0.0, 0.0 if s < 100 else s / 3600, 5.0, 0.0) for s in range(1, 1001)]
    assert periodic.growth(samples, "talker_anonymous") == pytest.approx(1.0)
    assert periodic.growth(samples, "logger_anonymous") == pytest.approx(0.0)
