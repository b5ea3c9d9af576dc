"""Runs of a timer's callback in a reentrant group: whether they overlap, by the times of the model."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import here, node_net, place, read
from dineros.metamodel.elements import find
from dineros.metamodel.times.given import runs_at_once
from dineros.metamodel.times.overlaps import runs_overlapping
from dineros.transformations.rules.queries.times import RunsAtOnce
from dineros.transformations.rules.times.work import D2Clock
from tests.support.timed_systems.models import model_of


def timer(
    name: str, period: int, work: tuple[int, int], group: str = "reentrant", **more: Any
) -> dict[str, Any]:
    script = [["work", *work], ["publish", f"from_{name}"]]
    return {"name": name, "node": "n", "period": period, "offset": 0, "group": group, "script": script} | more


def model_with(callbacks: list[dict[str, Any]], threads: int = 2) -> sym.SystemModel:
    return model_of(
        {"nodes": {"n": {"threads": threads}}, "latency": {}, "chains": [], "callbacks": callbacks}
    )


def page_of(model: sym.SystemModel, name: str) -> sym.CallbackPage:
    page = find(model, name)
    assert isinstance(page, sym.CallbackPage)
    return page


def overlapping(callbacks: list[dict[str, Any]], threads: int = 2) -> int:
    return runs_overlapping(page_of(model_with(callbacks, threads), "tick"))


STEPS = [["work", 4, 4], ["publish", "from_tick"], ["work", 0, 1]]
"""Steps with intervals of their own; together they take up to 5."""


def test_a_short_run_ends_before_the_next_strike() -> None:
    assert overlapping([timer("tick", 6, (4, 5))]) == 1
    assert overlapping([timer("tick", 5, (4, 5))]) == 2, "the next one may begin just before this one ends"
    assert overlapping([timer("tick", 6, (4, 5), jitter=1)]) == 2
    assert overlapping([timer("tick", 6, (0, 0), script=STEPS)]) == 1
    assert overlapping([timer("tick", 5, (0, 0), script=STEPS)]) == 2


def test_each_other_callback_needs_a_thread() -> None:
    other = timer("other", 9, (1, 2), "own")
    assert overlapping([timer("tick", 6, (4, 5)), other]) == 1
    assert overlapping([timer("tick", 6, (4, 5)), other, timer("third", 9, (1, 2), "third")]) == 2
    assert overlapping([timer("tick", 6, (4, 5)), other, timer("third", 9, (1, 2), "third")], 3) == 1
    assert overlapping([timer("tick", 6, (4, 5)), timer("other", 9, (1, 9))]) == 2
    calls = timer(
        "other", 9, (0, 0), "own", script=[["work", 0, 1], ["call", "look", "answers"], ["work", 0, 1]]
    )
    look = {"name": "look", "node": "n", "service": "look", "group": "own", "script": [["work", 0, 1]]}
    assert overlapping([timer("tick", 6, (4, 5)), calls, look]) == 1
    assert overlapping([{**calls, "name": "tick", "group": "reentrant"}, {**look, "group": "default"}]) == 2


def test_a_run_that_needs_something_of_others_may_be_kept_back() -> None:
    model = model_with([timer("tick", 6, (4, 5))])
    page, node = page_of(model, "tick"), find(model, "n")
    assert isinstance(node, sym.NodeNet) and runs_overlapping(page) == 1
    does = find(model, "tick.do")
    assert isinstance(does, sym.Transition)
    read(here(place(node, "ready", tokens=1), page), does)
    assert runs_overlapping(page) == 2
    clocks = [link for link in timed_base_subject(model).links() if link.maker is D2Clock]
    assert len([link for link in clocks if link.role == "clock.begin"]) == 2


def test_a_managed_node_may_start_its_timer_again() -> None:
    model = model_with([timer("tick", 6, (4, 5))])
    node = find(model, "n")
    assert isinstance(node, sym.NodeNet)
    node.lifecycle = node_net(model, "managed", lifecycle=sym.Lifecycle()).lifecycle
    assert runs_overlapping(page_of(model, "tick")) == 2


@st.composite
def nodes(draw: st.DrawFn) -> tuple[list[dict[str, Any]], int]:
    callbacks = []
    for name in draw(st.sampled_from([("tick",), ("tick", "tock"), ("tick", "tock", "third")])):
        least = draw(st.integers(0, 4))
        group = draw(st.sampled_from(["reentrant", "reentrant", "own", "other"]))
        jitter = {"jitter": 1} if draw(st.integers(0, 3)) == 0 else {}
        work = (least, least + draw(st.integers(0, 1)))
        callbacks.append(
            timer(name, draw(st.integers(3, 6)), work, group, offset=draw(st.integers(0, 2)), **jitter)
        )
    return callbacks, draw(st.integers(2, 3))


@settings(max_examples=25, deadline=None)
@given(nodes())
def test_what_does_not_overlap_never_runs_twice(made: tuple[list[dict[str, Any]], int]) -> None:
    """The net has a clock for each run that the groups allow, and is explored."""
    model = model_with(*made)
    pages = [page_of(model, each["name"]) for each in made[0]]
    alone = [page for page in pages if runs_at_once(page) > 1 and runs_overlapping(page) == 1]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(RunsAtOnce, "_answer", staticmethod(runs_at_once))
        subject = timed_base_subject(model)
    explored = explore_timed(subject.timed, Budget(seconds=60))
    assert explored.is_complete
    most = dict(zip(subject.timed.untimed.places, explored.markings.max(axis=0), strict=True))
    for page in alone:
        assert most[f"{page.id}.running"] == 1
    event(f"{len(alone)} proved, of which the runs would overlap by their groups")


def test_steps_with_intervals_keep_their_times() -> None:
    """A system that was counted elsewhere. Left open, its steps lose ticks that are never lost."""
    callbacks = [
        timer("tick", 12, (0, 0), script=[["work", 4, 4], ["publish", "scan"], ["work", 0, 0]]),
        {
            "name": "log",
            "node": "m",
            "topic": "scan",
            "depth": 1,
            "group": "default",
            "script": [["work", 2, 3], ["publish", "pose"], ["work", 0, 1]],
        },
        {
            "name": "act",
            "node": "m",
            "topic": "pose",
            "depth": 3,
            "group": "default",
            "script": [["work", 2, 2]],
        },
    ]
    system = {
        "nodes": {"n": {"threads": 2}, "m": {"threads": 1}},
        "latency": {"scan": (0, 1), "pose": (1, 1)},
        "chains": [],
        "callbacks": callbacks,
    }
    model = model_of(system)
    latencies = Latencies(model, Budget(seconds=100))
    found = latencies.everything()
    times: dict[str, object] = {
        name: (each.least and each.least.value, each.greatest and each.greatest.value)
        for name, each in found.callbacks.items()
    }
    assert times == {"tick": (4, 4), "log": (2, 4), "act": (2, 2)}
    assert all(each.is_exact for each in found.callbacks.values())
    assert found.readers == {"log.heard": (1, False), "act.heard": (1, False)}
    assert found.timers == {"tick": False}
    chain = latencies.between(end_of(model, "tick"), end_of(model, "act"))
    assert chain.least is not None and chain.greatest is not None and chain.is_exact
    assert chain.least.value == 9 and chain.greatest.value == 11 and chain.is_lost is False
