"""Requests to a managed node that is not there, or leaves: their nets behave as the interpreter says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from dineros.analysis.model.wording import words
from dineros.metamodel import sym
from dineros.metamodel.constraints import validate
from dineros.metamodel.files import load, save
from dineros.transformations.flattening.flatten import flatten
from tests.support.equal_behaviour import compare
from tests.support.equality import differences
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.references.lifecycles import LifecycleInterpreter
from tests.support.ros2_systems.deserted_services import Asking, ask

LIVES: tuple[Callable[[], sym.Lifecycle | None], ...] = (
    lambda: None,
    sym.Lifecycle,
    lambda: sym.Lifecycle(cleansUp=True),
    lambda: sym.Lifecycle(shutsDown=True),
    lambda: sym.Lifecycle(cleansUp=True, shutsDown=True, deactivates=True),
)
CLIENTS: tuple[list[Asking], ...] = (
    ["once"],
    ["waits"],
    ["gives up"],
    ["engine"],
    ["engine gives up"],
    ["once", "engine"],
    ["once", "engine gives up"],
    ["waits", "gives up"],
)


@pytest.mark.long
@pytest.mark.parametrize("by_hand", [True, False])
@pytest.mark.parametrize("life", range(len(LIVES)))
def test_every_kind_of_client(life: int, by_hand: bool) -> None:
    for clients in CLIENTS:
        model = ask(LIVES[life](), clients, threads=2, written_by_hand=by_hand)
        assert [found for found in validate(model) if found.severity == "error"] == []
        found = compare(plain_net_of(flatten(model, "none").net), LifecycleInterpreter(model), 20_000)
        assert (found.difference, found.complete) == ("", True)


@pytest.mark.long
@pytest.mark.parametrize("clients", [["once", "engine gives up"], ["gives up"]])
def test_every_arc_counts(clients: list[Asking]) -> None:
    """Without any arc but those of the executor, which has threads enough, the net behaves in another way."""
    executor = (".threads", ".lock", ".running", ".active")
    model = ask(sym.Lifecycle(cleansUp=True, shutsDown=True), clients, threads=2, times=2)
    net, interpreter = plain_net_of(flatten(model, "none").net), LifecycleInterpreter(model)
    assert compare(net, interpreter, 20_000).complete
    unnoticed = []
    for number, arc in enumerate(net.arcs):
        if str(arc[0]).endswith(executor):
            continue
        altered = PlainNet(net.places, net.transitions, [*net.arcs[:number], *net.arcs[number + 1 :]])
        found = compare(altered, interpreter, 20_000)
        if not found.difference and found.complete:
            unnoticed.append(arc)
    assert unnoticed == []


def test_clients_that_send_again_are_as_they_were() -> None:
    """A service that only our engine asks, or whose server is always there, has nothing of these rules."""
    for model in (ask(sym.Lifecycle(cleansUp=True), ["engine"]), ask(None, ["once", "waits"])):
        assert not [link for link in flatten(model, "none").trace if link.rule.startswith(("L6", "L7"))]


@pytest.mark.parametrize("suffix", [".sym.xmi", ".pnml"])
def test_files(tmp_path: Path, suffix: str) -> None:
    model = ask(sym.Lifecycle(cleansUp=True), ["once", "waits"])
    save(model, tmp_path / f"asking{suffix}")
    loaded = load(tmp_path / f"asking{suffix}")
    assert differences(model, loaded, frozenset({"toolInfos", "graphics", "labels", "type"})) == []
    assert [client.waitsForService for client in loaded.channels[0].clients] == [False, True]  # type: ignore[attr-defined]


def test_what_is_said() -> None:
    life = sym.Lifecycle(cleansUp=True)
    said = {link.target.id: words(link) for link in flatten(ask(life, ["once", "gives up"]), "none").trace}
    assert said["Ask.client.c0.miss"] == (
        "client c0 of service /ask waits forever: its request is lost because node net server is not there"
    )
    assert said["Ask.client.c1.unanswered[1]"] == (
        "client c1 of service /ask waits until its time-out: "
        "its request is lost because node net server is gone before it answers"
    )
    assert said["Ask.late.gone"] == (
        "the request of a client of service /ask that has given up is discarded with node net server"
    )
