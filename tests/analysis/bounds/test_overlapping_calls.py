"""Bounds of servers whose callers overlap: in reentrant groups, on slots of an action, on client pages."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random
from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.build import callback, here, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, find
from tests.analysis.bounds.test_no_bound_is_too_low import require_above, require_safe
from tests.support.timed_systems.models import System, model_of
from tests.support.timed_systems.overlapping import Overlapping

SEEDS = 40 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
MOST_STATES = 6_000


def called_by_overlapping_runs() -> System:
    """Return a timer whose runs take up to 10 units, every 7 units, and a server that takes up to 6."""
    server = {"name": "s", "node": "n0", "group": "g", "service": "look", "depth": 10}
    caller = {"name": "a0", "node": "n1", "group": "reentrant", "period": 7, "offset": 2}
    script = [["work", 0, 1], ["call", "look", "answers"], ["work", 1, 1], ["publish", "t0"]]
    return {
        "nodes": {"n0": {"threads": 2}, "n1": {"threads": 3}},
        "latency": {"look": (0, 1), "t0": (0, 0)},
        "chains": [],
        "callbacks": [{**server, "script": [["work", 3, 6]]}, {**caller, "script": script}],
    }


def test_each_run_that_overlaps_has_a_request_of_its_own() -> None:
    system = called_by_overlapping_runs()
    facts = Overlapping(system).explore(MOST_STATES)
    assert facts.response["s"] == (3, 7)
    found = Bounds(model_of(system, 0.01)).everything()
    assert require_above(found.callbacks["s"], 3, 7)


def test_no_bound_is_proved_that_such_runs_exceed() -> None:
    model = model_of(called_by_overlapping_runs(), 0.01)
    model.properties.append(sym.Property(id="Soon", text="s responds within 0.06"))
    report = check_timed(model, Budget(seconds=20))
    assert not [each for each in report.proved if "Soon" in each]


def test_requests_of_overlapping_runs_come_as_late_as_in_truth() -> None:
    """The steps of runs share a clock, which keeps their latest bounds."""
    model = model_of(called_by_overlapping_runs(), 0.01)
    found = Latencies(model, Budget(seconds=60)).response(find(model, "s", sym.CallbackPage))
    assert found.least is not None and found.greatest is not None
    assert (found.least.value, found.greatest.value) == (Fraction("0.03"), Fraction("0.07"))


def drawn(seed: int) -> System:
    """Return a server, one or two callbacks that call it, mostly reentrant, and up to two others."""
    random = Random(seed)
    nodes = {f"n{number}": {"threads": random.randint(1, 3)} for number in range(random.randint(2, 3))}

    def span(most: int, wider: int) -> list[int]:
        least = random.randint(0, most)
        return [least, least + random.randint(0, wider)]

    def home(*groups: str) -> dict[str, str]:
        return {"node": random.choice(sorted(nodes)), "group": random.choice(groups)}

    server = {"name": "s", "service": "look", "depth": 10, "script": [["work", *span(3, 4)]]}
    callbacks: list[dict[str, Any]] = [{**server, **home("default", "g")}]
    for number in range(random.choice([1, 1, 2])):
        call = ["call", "look", random.choice(["answers", "reentrant", "default"])]
        script = [["work", *span(1, 1)], call, ["work", *span(1, 2)], ["publish", f"t{number}"]]
        released: dict[str, Any] = {"period": random.randint(4, 9), "offset": random.choice([0, 0, 2])}
        if number and random.random() < 0.3:
            released = {"topic": "t0", "depth": random.randint(1, 2)}
        caller = {"name": f"a{number}", **released, "script": script}
        callbacks.append({**caller, **home("reentrant", "reentrant", "default")})
    for number in range(random.randint(0, 2)):
        other = {"name": f"c{number}", "script": [["work", *span(2, 1)]], **home("default", "g", "reentrant")}
        timer = {"period": random.randint(4, 12), "offset": 0}
        callbacks.append(other | random.choice([timer, {"topic": "t0", "depth": random.randint(1, 2)}]))
    latency = {"look": random.choice([(0, 0), (0, 1), (1, 1), (1, 2)]), "t0": random.choice([(0, 0), (0, 2)])}
    return {"nodes": nodes, "latency": latency, "chains": [], "callbacks": callbacks}


def test_no_bound_is_too_low() -> None:
    systems, bounded = require_safe(
        map(drawn, range(SEEDS)), lambda system: Overlapping(system).explore(MOST_STATES)
    )
    assert systems > SEEDS / 8 and bounded > systems / 2, (systems, bounded)


def goals_that_call(slots: int, execution: str = "callbacks", is_shared: bool = False) -> sym.SystemModel:
    """Return an action whose goals each call a service that takes up to 0.06 s."""
    model = sym.SystemModel(id="m", middleware="ros2", times=sym.DefaultTimes(latency=seconds(0, 0.001)))
    driver = node_net(model, "driver", execution=execution)
    if execution == "callbacks":
        driver.executor, driver.threads = sym.Executor.multi, slots + 1
    else:
        driver.reaction = seconds(0, 0.01)
    page = callback(driver, "Drive", "goal")
    goal, there = place(page, "Goal"), place(page, "There")
    request, response = (place(driver if is_shared else page, each) for each in ("Ask", "Answer"))
    for number, (before, after) in enumerate([(goal, request), (response, there)]):
        made = step(page, f"Step{number}", [here(before, page)], [here(after, page)])
        made.interval = seconds(0, 0.01)
    look = callback(node_net(model, "eye", execution="callbacks"), "Look", "server")
    look.duration = seconds(0.03, 0.06)
    entry, exit_ = place(look, "In"), place(look, "Out")
    step(look, "See", [entry], [exit_])
    sender = node_net(model, "sender", execution="callbacks")
    tick, over = callback(sender, "Tick", "timer", 0.05), callback(sender, "OnResult", "client")
    tick.duration = over.duration = seconds(0, 0.001)
    sent, done = place(tick, "Send"), place(over, "Done")
    step(tick, "Go", [], [sent])
    step(over, "Note", [done])
    server = sym.ServerPort(page=look, entry=entry, exit=exit_)
    client = sym.ClientPort(client="driver", request=request, response=response)
    sym.ServiceChannel(id="look", service="/look", server=server, clients=[client], model=model)
    sym.ActionChannel(
        id="Act",
        action="/act",
        instances=slots,
        server=sym.ActionServerPort(page=page, entry=goal, succeeded=there),
        clients=[sym.ActionClientPort(client="sender", goal=sent, succeeded=done)],
        model=model,
    )
    assert [str(each) for each in validate(model) if each.severity == "error"] == []
    return model


@pytest.mark.parametrize("execution", ["callbacks", "net"])
@pytest.mark.parametrize("slots", [1, 3])
def test_each_slot_of_an_action_has_a_request_of_its_own(slots: int, execution: str) -> None:
    model = goals_that_call(slots, execution)
    found = Bounds(model).response(find(model, "Look", sym.CallbackPage)).greatest
    assert found is None or found.value == slots * Fraction("0.06")
    assert execution == "net" or found is not None


def test_slots_can_share_the_places_of_a_call() -> None:
    model = goals_that_call(3, is_shared=True)
    found = Bounds(model).response(find(model, "Look", sym.CallbackPage)).greatest
    assert found is None or found.value == Fraction("0.18")


def test_requests_of_goals_fit_into_the_history_of_the_server_or_not() -> None:
    model = goals_that_call(3)
    (service,) = channels(model, sym.ServiceChannel)
    for depth, expected in ((3, (3, False)), (2, (2, None))):
        service.depth = depth
        assert Bounds(model).everything().readers["In"] == expected
