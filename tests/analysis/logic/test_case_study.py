"""The temporal properties of the case study (scenario 4), on the nets written down for the engines' tests."""

from __future__ import annotations

import pytest

from dineros.analysis.logic import verify_ltl
from dineros.analysis.portfolio.branching_time import check_ctl
from tests.analysis.reference_case_study import MARKINGS, SignalVariant, reference_case_study

PICK_ANSWERS = "G (PickReqL >= 1 -> F PickResL >= 1)"


@pytest.mark.parametrize("signals", ["none", "input"])
def test_the_sensor_loop_can_run_for_ever(signals: SignalVariant) -> None:
    # A signal that toggles forever would do too, so we ask for a run in which sensing continues.
    net = reference_case_study((1, 1, 1), signals)
    verdict = verify_ltl(net, f"G F fired(TSense0) -> {PICK_ANSWERS}")
    assert verdict.status == "violated"
    assert verdict.states is not None and verdict.states < 100_000
    fired = {net.transitions[t] for t in verdict.loop}
    assert {"TSense0", "TUnsafe", "TRetry"} <= fired or {"TSense0", "TSafe", "TStop"} <= fired


def test_a_counterexample_needs_few_states() -> None:
    verdict = verify_ltl(reference_case_study((1, 1, 1), "input"), PICK_ANSWERS)
    assert verdict.status == "violated"
    assert verdict.states is not None and verdict.states < 100_000
    assert len(verdict.stem) < 30


def test_picking_ends_under_strong_fairness() -> None:
    net = reference_case_study((1, 1, 0), "none")
    verdict = verify_ltl(net, PICK_ANSWERS, strong=net.transitions)
    assert verdict.status == "holds"
    assert (verdict.states or 0) > MARKINGS[1, 1, 0]["none"]


@pytest.mark.parametrize(("signals", "objects"), [("none", 3), ("input", 2)])
def test_every_state_can_still_finish_all_objects(signals: SignalVariant, objects: int) -> None:
    colours = (1, 1, 1) if objects == 3 else (1, 1, 0)
    verdict = check_ctl(reference_case_study(colours, signals), f"AG EF (Shown >= {objects})")
    assert (verdict.status, verdict.states) == ("holds", MARKINGS[colours][signals])


def test_not_every_run_finishes() -> None:
    net = reference_case_study((1, 0, 0), "none")
    verdict = check_ctl(net, "AF (Shown >= 1)")
    assert verdict.status == "violated"
    assert verdict.loop
    assert check_ctl(net, "EF (Shown >= 1 & EG Shown >= 1)").status == "holds"
