"""Exact response times of nodes of the execution `net`, and latencies of chains through them."""

from __future__ import annotations

import os
from fractions import Fraction
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies
from dineros.analysis.latencies.results import Latency
from dineros.metamodel import pn, sym
from dineros.metamodel.build import callback, node_net, place, step
from dineros.metamodel.elements import find
from tests.support.timed_systems.engine_chains import UNIT, Chain, Stage, drawn, explored, model_of

SEEDS = 8 * int(os.environ.get("DINEROS_EXAMPLES", "1"))


def asked(chain: Chain, first: int, last: int) -> Latency:
    """Return the time from a release of the timer (-1) or a stage to the end of one."""
    model = model_of(chain)
    pages = [
        find(model, "Timer" if number < 0 else f"On{number}", sym.CallbackPage) for number in (first, last)
    ]
    latencies = Latencies(model, Budget(seconds=60, states=20_000))
    return latencies.response(pages[0]) if first == last else latencies.between(*pages, with_ages=False)


def require_equal(chain: Chain, first: int, last: int) -> bool:
    """Return whether an answer is exact; then it is that of the explorer."""
    exact, found = explored(chain, first, last), asked(chain, first, last)
    if exact is None or not found.is_exact:
        return False
    where = (first, last, chain)
    bounds = [None if each is None else each.value for each in (found.least, found.greatest)]
    unit = Fraction(str(UNIT))
    times = [min(exact.times) * unit, max(exact.times) * unit] if exact.times else [None, None]
    assert bounds == times, where
    assert found.is_lost == exact.is_lost, where
    return True


@pytest.mark.parametrize("seed", range(SEEDS))
def test_times_are_those_of_the_explorer(seed: int) -> None:
    chain = drawn(Random(seed), most_stages=1 + seed % 2)
    last = len(chain.stages) - 1
    for first in {-1, last}:
        require_equal(chain, first, last)


def test_a_chain_through_two_engines() -> None:
    stages = (Stage((0, 1), 1, (0, 1)), Stage((1, 1), 1, (0, 1), second=(0, 1)))
    chain = Chain(8, (0, 1), stages)
    for first, last in ((-1, -1), (0, 0), (1, 1), (-1, 1), (0, 1)):
        assert require_equal(chain, first, last), (first, last)


def inner() -> sym.SystemModel:
    """Return a chain with a node that works on its messages by two transitions."""
    return model_of(Chain(8, (0, 1), (Stage((0, 1), 1, (0, 1), second=(2, 3)),)))


def response(model: sym.SystemModel) -> Latency:
    page = find(model, "On0", sym.CallbackPage)
    found, bound = Latencies(model, Budget(seconds=60)).response(page), Bounds(model).response(page)
    if found.greatest is not None and bound.greatest is not None:
        assert found.greatest.value <= bound.greatest.value
    return found


def test_a_callback_ends_where_its_model_says() -> None:
    model = inner()
    found = response(model)
    assert found.greatest is not None and found.greatest.value == Fraction("0.05")
    find(model, "Do0", sym.Transition).kind = sym.TransitionKind.end
    found = response(model)
    assert found.greatest is not None and found.greatest.value == Fraction("0.02")


def test_a_callback_that_waits_for_a_response_has_not_ended() -> None:
    """It sends a request by its first transition, and goes on with the response."""
    model = inner()
    page = find(model, "On0", sym.CallbackPage)
    ask, answer = place(page, "Ask"), place(page, "Answer")
    first, second = (find(model, name, sym.Transition) for name in ("Do0", "Then0"))
    for arc in [arc for arc in page.arcs if "Inside0" in (arc.source.id, arc.target.id)]:
        page.arcs.remove(arc)
        if arc.source is first:
            pn.Arc(source=first, target=ask, page=page)
        else:
            pn.Arc(source=answer, target=second, page=page)
    page.objects.remove(find(model, "Inside0", sym.Place))
    server = node_net(model, "server")
    server.reaction = pn.TimeInterval(earliest=0.0, latest=0.01)
    serving = callback(server, "Serve", "server")
    entry, exit_ = place(serving, "Entry"), place(serving, "Exit")
    step(serving, "Reply", [entry], [exit_])
    service = sym.ServiceChannel(id="Service", service="s", instances=1, model=model)
    service.server = sym.ServerPort(page=serving, entry=entry, exit=exit_)
    service.latency = pn.TimeInterval(earliest=0.0, latest=0.01)
    service.clients.append(sym.ClientPort(client="c", request=ask, response=answer))
    waits = "callback On0 waits for a response"
    assert response(model).reason == Bounds(model).response(page).reason == waits
