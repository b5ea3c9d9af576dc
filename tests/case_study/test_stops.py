"""Both applications, stopped, killed and flooded: a short run of the benchmarks that do it for hours."""

from __future__ import annotations

import fcntl
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from benchmarks.endurance import flood, stops_and_kills
from benchmarks.endurance.applications import APPLICATIONS
from dineros.generators.building import missing_tools

ROOT = Path(__file__).resolve().parents[2]
CACHE = ROOT / "build/tests/cache"


@contextmanager
def built_interfaces() -> Iterator[None]:
    """Let one test at a time build interfaces, or use what others have built."""
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


@pytest.mark.skipif(bool(missing_tools()), reason="the interfaces cannot be built")
@pytest.mark.parametrize(("name", "pieces", "messages"), [("sorting", 2, 12), ("fleet", 8, 16)])
def test_nothing_is_lost_when_it_is_stopped_and_killed(
    name: str, pieces: int, messages: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros_domain: int
) -> None:
    """Each piece of work is published to where it is done, and comes back."""
    monkeypatch.setattr(stops_and_kills, "KINDS", ("SIGINT", "SIGKILL", "node SIGKILL"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(CACHE))
    application = APPLICATIONS[name]
    with built_interfaces():
        lines: list[dict[str, Any]] = list(
            stops_and_kills.stress(application, tmp_path, 3, 2, pieces, ros_domain, longest=4.0)
        )
    assert sum("stop" in line for line in lines) == 3
    assert sum(line.get("publish", 0) for line in lines) >= messages


@pytest.mark.skipif(bool(missing_tools()), reason="the interfaces cannot be built")
def test_the_flooded_case_study_stays_flat(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros_domain: int
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(CACHE))
    with built_interfaces():
        samples = list(flood.flood(6.0, 400.0, 0.5, tmp_path, ros_domain))
    assert samples[-1].messages > 100
    assert samples[-1].memory < samples[2].memory + 16
    assert Counter(sample.descriptors for sample in samples[1:]).most_common(1)[0][1] > len(samples) // 2
