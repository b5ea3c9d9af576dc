"""Managed nodes: their nets behave as the interpreter says; what readers that come late, or again, get."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from dineros.analysis.model.wording import words
from dineros.metamodel import sym
from dineros.metamodel.build import flow
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import find
from dineros.metamodel.files import load, save
from dineros.metamodel.lifecycles.start_order import start_order
from dineros.metamodel.settings import apply
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.rules.phases import OverflowVariant, SignalVariant
from tests.histories.comparing import variants
from tests.support.equal_behaviour import compare
from tests.support.equality import differences
from tests.support.references.flattening import PlainNet, plain_net_of
from tests.support.references.lifecycles import LifecycleInterpreter
from tests.support.ros2_systems.lifecycle_models import lifecycle_models
from tests.support.ros2_systems.managed_systems import camera, talk

Life = Callable[[], sym.Lifecycle | None]

LIVES: tuple[Life, ...] = (
    lambda: None,
    sym.Lifecycle,
    lambda: sym.Lifecycle(deactivates=True, pauses=True),
    lambda: sym.Lifecycle(deactivates=True, cleansUp=True),
    lambda: sym.Lifecycle(shutsDown=True, cleansUp=True, configureFails=True, activateFails=True),
)


@given(lifecycle_models())
@settings(max_examples=15, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_models_are_valid(model: sym.SystemModel) -> None:
    assert [found for found in validate(model) if found.severity == "error"] == []


@pytest.mark.long
@given(
    lifecycle_models(), st.sampled_from(get_args(SignalVariant)), st.sampled_from(get_args(OverflowVariant))
)
@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
def test_generated_models(model: sym.SystemModel, signals: SignalVariant, overflow: OverflowVariant) -> None:
    for _, _, found in variants(model, 200, [signals], [overflow]):
        assert found.difference == ""


@pytest.mark.long
@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("overflow", ["weighted", "inhibitor"])
def test_every_pair_of_lives(late: bool, overflow: OverflowVariant) -> None:
    for writer, reader in itertools.product(LIVES, LIVES):
        model = talk(writer(), reader(), late=late)
        found = compare(plain_net_of(flatten(model, "none", overflow).net), LifecycleInterpreter(model), 2000)
        assert (found.difference, found.complete) == ("", True)


def test_a_difference_is_noticed() -> None:
    """Every arc of a net with all that the rules make counts."""
    model = talk(
        sym.Lifecycle(shutsDown=True), sym.Lifecycle(cleansUp=True, deactivates=True), late=True, tokens=3
    )
    find(model, "talker", sym.NodeNet).lifecycle.activateStep = 1  # type: ignore[union-attr]
    find(model, "listener", sym.NodeNet).lifecycle.activateStep = 2  # type: ignore[union-attr]
    net, interpreter = plain_net_of(flatten(model, "none").net), LifecycleInterpreter(model)
    assert compare(net, interpreter, 5000).complete
    unnoticed = []
    for number, arc in enumerate(net.arcs):
        altered = PlainNet(net.places, net.transitions, [*net.arcs[:number], *net.arcs[number + 1 :]])
        found = compare(altered, interpreter, 5000)
        if not found.difference and found.complete:
            unnoticed.append(arc)
    assert unnoticed == []


def test_figures() -> None:
    """Counted by the interpreter: nobody is managed, the writer, the reader, both."""
    for lives, states in (((0, 0), 32), ((1, 0), 38), ((0, 1), 72), ((1, 1), 90), ((3, 3), 288)):
        model = talk(*(LIVES[life]() for life in lives))
        assert LifecycleInterpreter(model).count()[0] == states


def test_a_node_that_hears_itself() -> None:
    """A history at whose both ends the same node stands is asked once whether it is empty."""
    model = talk(sym.Lifecycle(cleansUp=True, deactivates=True), None, depth=1)
    talker = find(model, "talker", sym.NodeNet)
    heard = sym.Place(id="Echo", page=talker)
    flow(heard, sym.Transition(id="Hear itself", page=talker))
    model.channels[0].subscribers.append(sym.SubscriberPort(place=heard, limit=1))  # type: ignore[attr-defined]
    for overflow in ("weighted", "inhibitor"):
        net = plain_net_of(flatten(model, "none", overflow).net)
        found = compare(net, LifecycleInterpreter(model), 3000)
        assert (found.difference, found.complete) == ("", True)


def test_ros1_has_no_managed_nodes() -> None:
    plain, managed = talk(), talk(sym.Lifecycle(), sym.Lifecycle())
    plain.middleware = managed.middleware = "ros1"
    assert plain_net_of(flatten(plain, "none").net) == plain_net_of(flatten(managed, "none").net)


def test_what_is_best_effort_is_not_kept_for_a_late_reader() -> None:
    for reliability, late, parts in (
        ("reliable", True, False),
        ("bestEffort", True, True),
        ("reliable", False, True),
    ):
        model = talk(None, sym.Lifecycle(), late=late, reliability=reliability)
        ids = {link.target.id for link in flatten(model, "none").trace}
        assert ("Talk.writer.Said.Heard.miss" in ids) is parts


def test_certificates() -> None:
    net = flatten(talk(None, sym.Lifecycle(cleansUp=True, shutsDown=True), late=True), "none").net
    found = {each.name: (each.value, {term.place.id for term in each.terms}) for each in net.certificate}
    states = {f"listener.{state}" for state in ("unconfigured", "inactive", "active", "finalized")}
    assert found["listener is in one state"] == (1, states)
    assert found["listener is configured or not"][0] == 1
    assert found["listener exists or is finalized"][1] == {"listener.existing", "listener.finalized"}
    pair = "Talk.writer.Said.Heard."
    assert found[f"{pair}Kept is delivered or to be"] == (
        0,
        {f"{pair}Kept", f"{pair}Delivered", f"{pair}Load"},
    )


def test_what_is_said() -> None:
    life = sym.Lifecycle(cleansUp=True, configureFails=True)
    said = {link.target.id: words(link) for link in flatten(talk(life, life_of_all()), "none").trace}
    assert said["talker.configure.fails"] == "node net talker fails to be configured"
    assert said["listener.shutdown.active"] == "node net listener is shut down"
    assert said["Talk.publisher.Said.discard"] == (
        "a message of Said on topic /talk is lost: node net talker is inactive"
    )
    assert said["Talk.writer.Said.Heard.miss"] == (
        "a message of Said on topic /talk is lost: Heard of node net listener is not there"
    )
    assert said["talker.inactive"] == "node net talker is inactive"


def life_of_all() -> sym.Lifecycle:
    return sym.Lifecycle(deactivates=True, cleansUp=True, shutsDown=True)


@pytest.mark.parametrize("name", ["camera.sym.xmi", "camera.pnml"])
def test_files(tmp_path: Path, name: str) -> None:
    model = camera()
    apply(model, "display.lifecycle.activateStep=3")
    apply(model, "camera.lifecycle.configureFails=true")
    save(model, tmp_path / name)
    loaded = load(tmp_path / name)
    assert differences(model, loaded, frozenset({"toolInfos", "graphics", "labels", "type"})) == []


def test_settings_make_a_lifecycle() -> None:
    model = talk()
    apply(model, "talker.lifecycle.pauses=true")
    talker = find(model, "talker", sym.NodeNet)
    assert talker.lifecycle is not None and talker.lifecycle.pauses
    assert [(label, node.id) for label, node in start_order(model)] == [
        ("configure", "talker"),
        ("activate", "talker"),
    ]
