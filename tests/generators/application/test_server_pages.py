"""Packages of a system whose server pages call and publish: what they say, and their tests from traces."""

from __future__ import annotations

import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest

from dineros.generators import Options, generate
from dineros.generators.application.collecting import application_of
from dineros.metamodel.records import Publish, Serve, read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.support.systems.bakery import bakery


def test_clients_and_publishers_on_a_server_page_are_there_per_instance() -> None:
    shop = next(node for node in application_of(bakery()).nodes if node.id == "shop")
    assert {(port.kind, port.place, port.service) for port in shop.ports} == {
        ("server", "Ordered", None),
        ("client", "Dough", "Order"),
        ("publisher", "Told", "Order"),
    }
    oven = next(node for node in application_of(bakery(5)).nodes if node.id == "oven")
    assert [port.instances for port in oven.ports] == [5]


@pytest.mark.long
def test_generated_tests_follow_traces_through_any_instance(tmp_path: Path) -> None:
    """Instances are numbered again in a test: it maps those of the trace, with their clients and messages."""
    runs = []
    for seed in (1, 4, 7):
        runs.append(tmp_path / f"run{seed}")
        recorder = partial(JournalRecorder, runs[-1])
        application = LocalApplication(split(bakery()), seed=seed, recorder=recorder)
        application.open()
        while application.step():
            pass
        application.close()
    records = [
        record for run in runs for parts in traces_of_runs([run]).values() for record in read_trace(parts)
    ]
    assert {each.instance for each in records if isinstance(each, Serve)} == {1, 2}
    assert {each.place for each in records if isinstance(each, Publish)} == {"Order[1].Told", "Order[2].Told"}
    generate(bakery(), tmp_path / "ws", Options(source="bakery.sym.xmi", tests=tuple(runs)))
    shop = (tmp_path / "ws/src/shop/README.md").read_text(encoding="utf-8")
    assert (
        "| client | `/bake` | `bakery_interfaces/srv/Bake` | `Dough` → `Baked` (per instance of Order) |"
        in shop
    )
    for package in ("bakery_bringup", "shop"):
        done = subprocess.run(
            [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"],
            cwd=tmp_path / "ws/src" / package,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stdout
    assert "passed" in done.stdout
