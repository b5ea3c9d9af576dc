"""Signals set together, and signals whose source falls silent."""

from __future__ import annotations

import pytest

from dineros.metamodel import rtm
from dineros.metamodel.errors import FeatureValueError, UnknownElementError
from dineros.runtime.journal.recording import ListRecorder
from dineros.runtime.nets.staleness import Expectation, StalenessError, parse_expectation
from dineros.runtime.nodes.net import Net
from dineros.runtime.nodes.node import Node
from tests.runtime.tiny import tiny


def door(clause: str = "A & B") -> rtm.RuntimeModel:
    """A node with two signals, and one transition that waits for them."""
    return tiny({"go": "p -> q"}, {"p": 1}, signals="A B", clauses={"go": clause})


class TestTogether:
    def test_nothing_fires_in_between(self) -> None:
        """From A alone to B alone: a transition that needs both, or none, never fires."""
        net = Net(door("(A & B) | (!A & !B)"))
        net.signal("A").set(True)
        recorder = ListRecorder()
        seen: list[dict[str, bool]] = []
        net.on_change(lambda change: seen.append(dict(net.inspect().signals)))
        node = Node(net, recorder=recorder)
        node.open()
        seen.clear()
        for values in ({"B": True, "A": False}, {"A": True, "B": False}) * 5:
            net.set_signals(values, "test")
            node.run_until_idle()
            assert all(state == values for state in seen[-2:])
        assert net.count("p") == 1
        signals = [record for record in recorder.records if record["event"] == "signal"]
        assert len(signals) == 20
        assert {record["source"] for record in signals} == {"test"}
        node.close()

    def test_all_or_nothing(self) -> None:
        net = Net(door())
        with pytest.raises(UnknownElementError, match="no signal 'C'"):
            net.set_signals({"A": True, "C": True})
        with pytest.raises(FeatureValueError, match="takes True or False"):
            net.set_signals({"A": True, "B": 1})  # type: ignore[dict-item]
        assert not any(net.inspect().signals.values())


class TestStale:
    @pytest.fixture
    def now(self) -> list[float]:
        return [0.0]

    @pytest.fixture
    def net(self, now: list[float]) -> Net:
        return Net(door(), clock=lambda: now[0])

    def test_fallback(self, net: Net, now: list[float]) -> None:
        net.signal("A").stale_after(2.0, then=True)
        recorder = ListRecorder()
        node = Node(net, recorder=recorder)
        node.open()
        for second in (1.0, 2.5, 4.0):  # a source that repeats its value is not silent
            now[0] = second
            net.signal("A").set(False)
            node.run_until_idle()
            assert net.inspect().stale == ()
        now[0] = 5.9
        node.run_until_idle()
        assert not net.signal("A").value
        now[0] = 6.1
        node.run_until_idle()
        state = net.inspect()
        assert (state.stale, state.signals["A"], state.halted) == (("A",), True, None)
        assert "the signal A is stale: not set for 2 s; it becomes true" in state.errors[0].error
        assert [record["source"] for record in recorder.records if record["event"] == "signal"] == ["stale"]
        net.signal("A").set(False)
        node.run_until_idle()
        assert net.inspect().stale == ()
        now[0] = 9.0
        node.run_until_idle()
        assert net.inspect().stale == ("A",)
        node.close()

    def test_keep(self, net: Net, now: list[float]) -> None:
        net.signal("A").set(True)
        net.signal("A").stale_after(1.0)
        node = Node(net)
        node.open()
        now[0] = 1.5
        node.run_until_idle()
        state = net.inspect()
        assert (state.stale, state.signals["A"], state.halted) == (("A",), True, None)
        node.close()

    def test_stop(self, net: Net, now: list[float]) -> None:
        net.signal("A").stale_after(1.0, then="stop")
        node = Node(net)
        node.open()
        now[0] = 1.5
        node.run_until_idle()
        net.set_signals({"A": True, "B": True})
        node.run_until_idle()
        assert net.count("p") == 1
        assert str(net.inspect().halted).startswith("the signal A is stale")
        net.proceed()
        node.run_until_idle()
        assert net.count("p") == 0
        node.close()

    def test_no_more(self, net: Net, now: list[float]) -> None:
        net.signal("A").stale_after(1.0, then=True)
        net.signal("A").stale_after(None)
        node = Node(net)
        node.open()
        now[0] = 100.0
        node.run_until_idle()
        assert (net.inspect().stale, net.next_timer) == ((), None)
        node.close()


@pytest.mark.parametrize("text", ["", "x", "0", "-1", "nan", "inf", "1:", "1:2"])
def test_wrong_expectations(text: str) -> None:
    with pytest.raises(StalenessError):
        parse_expectation(text)


def test_expectations() -> None:
    assert parse_expectation("2") == Expectation(2.0, "keep")
    assert parse_expectation("0.5:STOP") == Expectation(0.5, "stop")
    assert parse_expectation("1:true") == Expectation(1.0, True)
