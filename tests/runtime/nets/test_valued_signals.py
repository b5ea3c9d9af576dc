"""Signals with several values, as programs and texts from outside set them."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.metamodel import rtm, sym
from dineros.metamodel.clauses import set_clause
from dineros.metamodel.elements import find
from dineros.metamodel.errors import FeatureValueError
from dineros.runtime.bridges.values import SignalValueError, read_setting, read_signals
from dineros.runtime.nets.staleness import StalenessError, parse_expectation
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from tests.runtime.tiny import tiny

VALUES = ("idle", "moving", "broken")


def machine() -> rtm.RuntimeModel:
    """A node that may go unless its mode is idle, and whose button does not matter."""
    model = tiny({"go": "p -> q"}, {"p": 2}, signals="Mode Button")
    find(model, "Mode", sym.InputSignal).values.extend(sym.SignalValue(name=each) for each in VALUES)
    set_clause(find(model, "go", sym.Transition), "Mode <> 'idle'")
    return model


def test_the_first_value_or_start_is_the_first() -> None:
    model = machine()
    assert Net(model).signal("Mode").value == "idle"
    find(model, "Mode", sym.InputSignal).start = "broken"
    assert Net(model).signal("Mode").value == "broken"


def test_a_net_fires_by_values() -> None:
    net = Net(machine())
    node = Node(net)
    node.open()
    node.run_until_idle()
    assert net.count("q") == 0
    net.set_signals({"Mode": "moving", "Button": True})
    node.run_until_idle()
    assert (net.count("q"), net.signal("Mode").value, net.signal("Mode").values) == (2, "moving", VALUES)
    node.close()


def test_values_that_are_none_are_refused_and_nothing_is_set() -> None:
    net = Net(machine())
    several: list[Any] = ["movin", True, None, 1, ["idle"], {}]
    for wrong in several:
        with pytest.raises(FeatureValueError, match="the signal Mode has no value"):
            net.set_signals({"Button": True, "Mode": wrong})
        with pytest.raises(FeatureValueError, match="the signal Mode has no value"):
            net.signal("Mode").set(wrong)
    with pytest.raises(FeatureValueError, match="takes True or False, not 'moving'"):
        net.signal("Button").set("moving")
    assert dict(net.inspect().signals) == {"Mode": "idle", "Button": False}


def test_a_stale_signal_gets_a_value_of_its_own() -> None:
    now = [0.0]
    net = Net(machine(), clock=lambda: now[0])
    with pytest.raises(StalenessError, match="'stopped'"):
        net.signal("Mode").stale_after(1.0, then="stopped")
    with pytest.raises(StalenessError, match="'moving'"):
        net.signal("Button").stale_after(1.0, then="moving")
    expected = parse_expectation("1:broken")
    net.signal("Mode").stale_after(expected.seconds, expected.then)
    node = Node(net)
    node.open()
    now[0] = 1.5
    node.run_until_idle()
    assert net.signal("Mode").value == "broken"
    node.close()


@pytest.mark.parametrize("text", ["moving", " moving\n", b'{"value": "moving"}', '{"value": " moving "}'])
def test_texts_that_name_a_value(text: str | bytes) -> None:
    assert read_setting(text, VALUES) == "moving"


@pytest.mark.parametrize(
    "text", ["Moving", "true", "", "1", '{"value": true}', '{"value": null}', '["moving"]', "{"]
)
def test_texts_that_name_none(text: str) -> None:
    with pytest.raises(SignalValueError):
        read_setting(text, VALUES)


def test_several_signals_in_one_text() -> None:
    def known(name: str) -> tuple[str, ...]:
        return VALUES if name == "Mode" else ()

    assert read_signals('{"Mode": "broken", "Button": "on"}', known) == {"Mode": "broken", "Button": True}
    for wrong in ('{"Mode": "on"}', '{"Button": "broken"}', '{"Mode": true}'):
        with pytest.raises(SignalValueError):
            read_signals(wrong, known)
