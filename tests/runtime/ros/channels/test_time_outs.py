"""Clients of the real middleware that give up, and that have several requests under way."""

from __future__ import annotations

import os
import signal
from functools import partial

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.files import save
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.transformations.flattening.split import split
from tests.runtime.ros.channels.test_simulated_time import SIMULATION
from tests.runtime.ros.conftest import Ros
from tests.runtime.ros.post import post

SLOW = """
import time
from pathlib import Path
def configure(net):
    @net.handler("TWeigh", thread=True)
    def weigh(firing):
        while not Path("open").exists():
            time.sleep(0.01)
        time.sleep(0.2)
"""


def weighing(ros: Ros, timeout: float, depth: int = 4) -> sym.SystemModel:
    """Save and return the desk and the scale: client A asks three times at once, client B gives up."""
    model = post()
    model.middleware = "ros2"
    service = next(each for each in model.channels if isinstance(each, sym.ServiceChannel))
    for channel in [each for each in model.channels if each is not service]:
        model.channels.remove(channel)
    service.instances, service.depth = 1, depth
    first, second = service.clients
    first.outstanding = 3
    (wishes,) = (arc.source for each in first.request.incoming for arc in each.source.incoming)
    assert isinstance(wishes, sym.Place)
    wishes.tokens = 3
    page = second.request.page
    second.timeout, second.timedOut = timeout, sym.Place(id="LateB", page=page)
    flow(second.timedOut, sym.Transition(id="TComplain", page=page), sym.Place(id="Complaint", page=page))
    for part in split(model):
        save(part, ros.folder / f"{part.node.id}.rtm.xmi")
    return model


def check(ros: Ros, model: sym.SystemModel) -> None:
    """Replay what was recorded."""
    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([ros.folder / "journal"]).items()}
    verdict = conform(model, traces)
    assert (verdict.status, verdict.violations, verdict.unknown) == ("conforms", [], [])


@pytest.mark.long
def test_a_client_gives_up_and_the_late_response_is_dropped(ros: Ros) -> None:
    # Longer than it takes to find the server: what is given up before that is never sent.
    model = weighing(ros, timeout=5.0)
    scale, desk = ros.node("scale", handlers=SLOW), ros.node("desk")
    ros.wait(lambda: ros.records("scale", "serve"), "serving one")
    ros.wait(lambda: ros.records("desk", "giveUp"), "giving up")
    requests = {record["message"] for record in ros.records("desk", "request")}
    assert len(requests) == 4  # three of client A at once
    assert len(ros.records("scale", "serve")) == 1  # the others stay in the middleware
    (ros.folder / "open").touch()
    ros.wait(lambda: len(ros.records("scale", "reply")) == 4, "answering all")
    ros.wait(lambda: len(ros.records("desk", "response")) == 3, "three responses")
    ros.wait(lambda: ros.fired("desk", "TComplain"), "complaining")
    assert desk.interrupt() == 0
    assert scale.interrupt() == 0
    (given_up,) = ros.records("desk", "giveUp")
    assert (given_up["client"], given_up["place"]) == ("clientB", "LateB")
    assert {record["message"] for record in ros.records("scale", "serve")} == requests
    assert {record["message"] for record in ros.records("desk", "response")} == requests - {
        given_up["message"]
    }
    check(ros, model)


@pytest.mark.long
def test_killed_nodes_go_on_with_all_their_requests(ros: Ros) -> None:
    """The requests keep their ids and their ages; what is answered meanwhile is not served again."""
    model = weighing(ros, timeout=6.0)
    scale, desk = ros.node("scale", handlers=SLOW), ros.node("desk", {"request_timeout": 0.5})
    ros.wait(lambda: len(ros.records("desk", "request")) == 4, "four requests")
    ros.wait(lambda: len(ros.records("desk", "timeout")) >= 4, "asking again")
    for process in (desk, scale):
        os.kill(process.popen.pid, signal.SIGKILL)
        process.popen.wait()
        ros.processes.remove(process)
    asked = {record["message"]: record["time"] for record in ros.records("desk", "request")}
    killed = max(record["time"] for record in ros.records("desk"))
    scale, desk = ros.node("scale", handlers=SLOW), ros.node("desk", {"request_timeout": 0.5})
    ros.wait(lambda: ros.records("desk", "giveUp"), "giving up")
    (ros.folder / "open").touch()
    ros.wait(lambda: len(ros.records("desk", "response")) == 3, "three responses")
    assert desk.interrupt() == 0
    assert scale.interrupt() == 0
    (given_up,) = ros.records("desk", "giveUp")
    began = next(r["time"] for r in ros.records("desk", "start") if r["resumed"])
    waited = (killed - asked[given_up["message"]]) + (given_up["time"] - began)
    assert 5.0 < waited < 12.0, waited
    assert len(asked) == len(ros.records("desk", "request")) == 4
    served = [record["message"] for record in ros.records("scale", "serve")]
    assert len(served) == len(set(served))
    check(ros, model)


@pytest.mark.long
def test_a_client_gives_up_by_the_clock_of_a_simulation(ros: Ros) -> None:
    """Nobody serves it: it waits 300 s of a simulation, which take less than a second."""
    model = weighing(ros, timeout=300.0)
    desk = ros.node("desk", {"use_sim_time": True})
    ros.wait(lambda: len(ros.records("desk", "request")) == 4, "four requests")
    ros.script(SIMULATION)
    ros.wait(lambda: ros.records("desk", "giveUp"), "giving up")
    assert desk.interrupt() == 0
    assert [record["client"] for record in ros.records("desk", "giveUp")] == ["clientB"]
    check(ros, model)
