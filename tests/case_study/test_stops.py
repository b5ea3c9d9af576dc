"""The case study, stopped and killed at random: a short run of the benchmark that does it for hours."""

from __future__ import annotations

import fcntl
import importlib.util
import sys
from collections import Counter
from pathlib import Path
from types import ModuleType

import pytest

from dineros.generators.building import missing_tools

ROOT = Path(__file__).resolve().parents[2]
CACHE = ROOT / "build/tests/cache"


def script(name: str) -> ModuleType:
    """Import a script of the benchmarks."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


@pytest.mark.skipif(bool(missing_tools()), reason="the interfaces cannot be built")
def test_nothing_is_lost_when_it_is_stopped_and_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ros_domain: int
) -> None:
    stops = script("stops_and_kills")
    monkeypatch.setattr(stops, "KINDS", ("SIGINT", "SIGKILL", "node SIGKILL"))
    monkeypatch.setenv("XDG_CACHE_HOME", str(CACHE))
    CACHE.mkdir(parents=True, exist_ok=True)
    with (CACHE / "lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        application = stops.APPLICATIONS["sorting"]
        lines = list(stops.stress(application, tmp_path, 3, seed=2, pieces=2, domain=ros_domain, longest=5.0))
    assert sum("stop" in line for line in lines) == 3
    assert sum(line.get("publish", 0) for line in lines) >= 12  # each object to a cell, each result back


def test_the_flooded_case_study_stays_flat(tmp_path: Path) -> None:
    flood = script("flood")
    samples = list(flood.flood(6.0, 200.0, 0.5, tmp_path, kept_parts=2, part_bytes=20_000))
    assert samples[-1].messages > 100
    assert Counter(sample.descriptors for sample in samples[1:]).most_common(1)[0][1] > len(samples) // 2
    assert samples[-1].disk < 6 * 3 * 20_000 * 1.5 / 2**20
    assert len(list(tmp_path.glob("executor.*.jsonl"))) == 2
