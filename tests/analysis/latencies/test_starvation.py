"""Whether a callback can wait without end: against published examples, and a formula of temporal logic."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.analysis.latencies.paths import callback_pages
from dineros.analysis.timed.linear_time import verify_timed_ltl
from dineros.metamodel import sym
from dineros.metamodel.elements import find
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

Row = tuple[int, int, str]


def timers(threads: int, order: str, *rows: Row) -> dict[str, Any]:
    """Return a node with timers: period, duration and exclusive group of each."""
    callbacks = [
        {
            "name": f"t{n}",
            "node": "n",
            "period": period,
            "offset": 0,
            "group": group,
            "script": [["work", w, w]],
        }
        for n, (period, w, group) in enumerate(rows)
    ]
    nodes = {"n": {"threads": threads, "order": order}}
    return {"nodes": nodes, "latency": {}, "callbacks": callbacks}


def asked(system: dict[str, Any]) -> Latencies:
    return Latencies(model_of(system), Budget(seconds=100))


CASES: dict[str, tuple[tuple[Row, ...], str]] = {
    "three timers, two groups": (((1000, 1000, "a"), (1000, 500, "a"), (1000, 500, "b")), "t1"),
    "four timers": (((1000, 500, "a"), (1000, 500, "b"), (1000, 500, "c"), (1000, 1, "c")), "t3"),
    "four periods": (((1000, 333, "a"), (1000, 333, "b"), (500, 334, "c"), (5000, 1, "c")), "t3"),
}


@pytest.mark.parametrize("case", CASES)
def test_a_timer_can_starve_with_two_threads(case: str) -> None:
    """Examples of H. Teper et al., EMSOFT 2024."""
    rows, timer = CASES[case]
    latencies = asked(timers(2, "rclcpp", *rows))
    page = find(latencies.model, timer)
    assert isinstance(page, sym.CallbackPage) and latencies.starves(page) is True
    response = latencies.response(page)
    assert response.greatest is None and "can starve" in response.reason


def test_nothing_starves_with_one_thread_and_a_wait_result() -> None:
    rows, timer = CASES["three timers, two groups"]
    assert asked(timers(1, "any", *rows)).everything().starved[timer] is True
    assert set(asked(timers(1, "rclcpp", *rows)).everything().starved.values()) == {False}


def test_without_a_duration_it_is_not_known() -> None:
    model = model_of(timers(1, "any", (10, 1, "a"), (10, 1, "b")))
    page = find(model, "t0")
    assert isinstance(page, sym.CallbackPage)
    page.duration = None
    assert set(Latencies(model, Budget(seconds=100)).everything().starved.values()) == {None}


@st.composite
def systems(draw: st.DrawFn) -> dict[str, Any]:
    callbacks = []
    for number in range(draw(st.integers(1, 3))):
        work = draw(st.integers(0, 3))
        group = draw(st.sampled_from("ab"))
        script = [["work", work, work + draw(st.integers(0, 1))], ["publish", f"from{number}"]]
        period = draw(st.integers(2, 4))
        callbacks.append(
            {
                "name": f"t{number}",
                "node": "n",
                "period": period,
                "offset": 0,
                "group": group,
                "script": script,
            }
        )
    if draw(st.booleans()):
        heard = {"topic": "from0", "depth": draw(st.integers(1, 2)), "group": draw(st.sampled_from("abc"))}
        callbacks.append(
            {"name": "log", "node": "n", "script": [["work", 1, draw(st.integers(1, 3))]], **heard}
        )
    nodes = {"n": {"threads": draw(st.integers(1, 2)), "order": draw(st.sampled_from(["any", "rclcpp"]))}}
    return {"nodes": nodes, "latency": {}, "callbacks": callbacks}


@settings(max_examples=8, deadline=None)
@given(systems())
def test_the_answer_is_that_of_temporal_logic(system: dict[str, Any]) -> None:
    latencies = asked(system)
    net = latencies.subject.timed
    for page in callback_pages(latencies.model):
        ready = f"{page.id}.due"
        if page.kind == sym.CallbackKind.subscriber:
            ready = f"from0.reader.{page.id}.heard.Load"
            assert ready in net.untimed.places
        answer = verify_timed_ltl(net, f"!(F G (({ready} >= 1) && ({page.id}.running == 0)))")
        starves = latencies.starves(page)
        assert answer.status == ("violated" if starves else "holds"), page.id
        event(f"starves: {starves}")


def test_a_chain_whose_callback_can_starve_has_no_reaction_time_and_no_data_age() -> None:
    """No search looks for what nothing bounds."""
    work = {"node": "n", "group": "default"}
    publishes = [["work", 1, 3], ["publish", "t"]]
    callbacks = [
        {"name": "tick", "period": 6, "offset": 0, "script": publishes, **work},
        {"name": "first", "topic": "t", "depth": 1, "script": [["work", 1, 3]], **work},
        {"name": "second", "topic": "t", "depth": 1, "script": [["work", 3, 4]], **work},
    ]
    nodes = {"n": {"threads": 1}}
    model = model_of({"nodes": nodes, "latency": {"t": (0, 1)}, "chains": [], "callbacks": callbacks})
    found = Latencies(model, Budget(seconds=100)).between(end_of(model, "tick"), end_of(model, "first"))
    assert found.greatest is not None and found.greatest.value == 29 and found.is_lost
    why = "callback first can starve, because others run first"
    assert found.reasons == {"reaction": why, "age": why}


def test_a_chain_through_a_managed_node_names_it_even_if_the_search_does_not_end() -> None:
    model = model_of(COUNTED[11].system)
    find(model, "b", sym.NodeNet).lifecycle = sym.Lifecycle()
    found = Latencies(model, Budget(states=50)).between(end_of(model, "sense"), end_of(model, "act"))
    assert found.reason == "node b of topic scan is managed, and nothing says when it is active"
