"""Firing intervals that are left out: which nets have some, and which answers stay with fewer runs."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.analysis.logic.language.parser import parse
from dineros.analysis.model.times import is_of_all_runs, left_out_times
from dineros.metamodel import pn, sym
from dineros.metamodel.files.tina import net_from_text


def net_of(text: str) -> pn.Net:
    return net_from_text(text.encode(), Path("example.net"))


@pytest.mark.parametrize(
    ("text", "said", "changes_runs"),
    [
        ("tr t p -> q", None, None),
        ("tr t [0,w[ p -> q", None, None),  # what TINA takes where nothing is said
        ("tr t [1,w[ p -> q", "(1 transition, such as t [1,w[)", False),
        ("tr t ]0,w[ p -> q", "(1 transition, such as t ]0,w[)", False),
        ("tr t [1,w[ p -> q\ntr u [0,3[ p ->", "(2 transitions, such as u [0,3[)", True),
        ("tr t [0,0] p -> q", "(1 transition, such as t [0,0])", True),
    ],
)
def test_intervals_that_say_something(text: str, said: str | None, changes_runs: bool | None) -> None:
    times = left_out_times(net_of(text))
    if times is None:
        assert said is None
    else:
        assert said is not None and said in str(times)
        assert times.changes_runs is changes_runs
        assert times.survives(is_universal=True)
        assert times.survives(is_universal=False) is not changes_runs


def test_declared_times_of_a_model_of_ros2_count() -> None:
    """Those of callbacks, messages, engines and defaults, not the period of a timer."""
    model = sym.SystemModel(id="robot", middleware="ros2")
    node = sym.NodeNet(id="camera", net=model, execution="callbacks")
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=0.1, page=node)
    assert left_out_times(model) is None
    page.duration = pn.TimeInterval(earliest=0.5)
    assert left_out_times(model) is None, "it can take any time, as without times"
    page.duration = pn.TimeInterval(earliest=0.01, latest=0.02)
    topic = sym.TopicChannel(id="Images", topic="/images", model=model)
    topic.latency = pn.TimeInterval(latest=0.001)
    said = left_out_times(model)
    assert said is not None and said.changes_runs
    assert (
        str(said) == "the times that the model declares are ignored"
        " (2, such as duration of OnTimer [0.01,0.02]; --time takes them into account)"
    )
    model.middleware = "ros1"
    assert left_out_times(model) is None


@pytest.mark.parametrize(("latest", "is_said"), [(None, False), (2.0, True)])
def test_of_a_system_model_only_latest_times_count(latest: float | None, is_said: bool) -> None:
    step = sym.Transition(id="t", interval=pn.TimeInterval(earliest=1.0, latest=latest))
    model = sym.SystemModel(id="m", pages=[sym.NodeNet(id="n", objects=[step])])
    assert (left_out_times(model) is not None) is is_said


@pytest.mark.parametrize(
    ("formula", "value", "stays"),
    [
        ("AG p <= 1", True, True),
        ("AG p <= 1", False, False),
        ("EF p >= 1", True, False),
        ("EF p >= 1", False, True),
        ("!(EF p >= 1)", True, True),
        ("AG (p >= 1 -> AF q >= 1)", True, True),
        ("AG (EF p >= 1)", True, False),
        ("AG (EF p >= 1)", False, False),
        ("(AG p <= 1) -> (AG q <= 1)", True, False),
        ("(EF p >= 1) -> (AG q <= 1)", True, True),
        ("(AG p <= 1) <-> (q >= 1)", True, False),
        ("p >= 1 <-> q >= 1", False, True),
        ("A[p >= 1 U q >= 1]", True, True),
        ("E[p >= 1 U q >= 1]", False, True),
    ],
)
def test_verdicts_that_stay_if_runs_are_taken_away(formula: str, value: bool, stays: bool) -> None:
    assert is_of_all_runs(parse(formula, "ctl"), value) is stays
