"""A net without intervals can do the same with time as without."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import pytest

from benchmarks.contest.archives import unpack
from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import explore
from dineros.analysis.timed import timed_subject
from dineros.analysis.timed.classes import Kind
from dineros.analysis.timed.graph import class_graph
from dineros.analysis.timed.nets import Interval, TimedNet
from dineros.metamodel import pn
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.files import load
from tests.support.ros2_systems.waiting_models import sharing_a_lock
from tests.support.systems.door import door
from tests.support.systems.shop import shop
from tests.support.systems.small import small_system
from tests.support.systems.talker import talker

ROOT = Path(__file__).resolve().parents[3]
OF_OTHERS = ROOT.parent / "shared/mcc/nets"
FEW, MANY = Budget(states=20_000), Budget(states=150_000)
KINDS: tuple[Kind, ...] = ("W", "M", "S", "E")

MODELS = sorted(
    path
    for room in ("examples", "case_study", "tests")
    for kind in ("net", "pnml", "xmi")
    for path in (ROOT / room).rglob(f"*.{kind}")
)
ARCHIVES = sorted(OF_OTHERS.glob("*.tgz"))


def without_times(model: pn.Net) -> TimedNet | None:
    """Return the net of a model, all intervals and priorities left out; None if it has no net of its own."""
    try:
        with patch.object(timed_subject, "says_times", return_value=False):
            net = timed_subject.timed_base_subject(model).timed
    except DinerosError:
        return None
    return replace(net, intervals=(Interval(),) * len(net.intervals), above=((),) * len(net.intervals))


def figures_agree(net: TimedNet, budget: Budget) -> bool:
    """Compare the classes with the markings; whether all of them were within the budget."""
    plain = explore(net.untimed, budget)
    if not plain.complete:
        return False
    for kind in KINDS:
        graph = class_graph(net, kind, Budget())
        assert graph.is_complete
        expected = (plain.markings, plain.arcs, plain.markings, plain.deadlocks)
        assert (graph.classes, graph.edges, graph.markings, graph.deadlocks) == expected, kind
    return True


@pytest.mark.parametrize("make", [sharing_a_lock, talker, door, shop, small_system])
def test_models_of_tests(make: Callable[[], pn.Net]) -> None:
    net = without_times(make())
    assert net is not None
    assert figures_agree(net, FEW)


@pytest.mark.long
def test_models_of_the_project() -> None:
    compared = 0
    for path in MODELS:
        try:
            model = load(path)
        except (DinerosError, OSError):
            continue
        net = without_times(model)
        compared += net is not None and figures_agree(net, MANY)
    assert compared >= 12


@pytest.mark.long
@pytest.mark.skipif(not ARCHIVES, reason="the nets are not beside the project")
def test_nets_of_others(tmp_path: Path) -> None:
    compared = 0
    for archive in ARCHIVES:
        if archive.stat().st_size > 50_000:
            continue
        unpack(archive, tmp_path / archive.stem)
        (path,) = (tmp_path / archive.stem).rglob("model.pnml")
        net = without_times(load(path))
        compared += net is not None and figures_agree(net, FEW)
    assert compared >= 20
