"""The developers' interface of a running net, from other threads."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from dineros.metamodel.errors import DinerosError, FeatureValueError, ModelFileError, UnknownElementError
from dineros.metamodel.files import save
from dineros.runtime import Change, Firing, Net, Node
from dineros.runtime.nets.ports import Ports
from tests.runtime.tiny import ROOT, counts, tiny

SECONDS = 20.0
LOOP = {"there": "a -> b", "back": "b -> a"}


def test_a_net_runs_in_a_with_block_and_ends_with_it(tmp_path: Path) -> None:
    path = tmp_path / "tiny.rtm.xmi"
    save(tiny({"go": "a -> b"}, {"a": 3}, signals="s", clauses={"go": "s"}), path)
    others = set(threading.enumerate())
    with Net.load(path, seed=1) as net:
        net.signal("s").set(True)
        state = net.wait_for(lambda state: state.count("b") == 3, timeout=SECONDS)
        assert state.enabled == ()
        assert net.signal("s").value
    assert not any(
        thread.name.startswith("dineros") for thread in set(threading.enumerate()).difference(others)
    )
    assert counts(net) == {"a": 0, "b": 3}  # can be asked afterwards


def test_files_that_are_no_runtime_model(tmp_path: Path) -> None:
    with pytest.raises(ModelFileError, match="dineros split"):
        Net.load(ROOT / "case_study/sorting.sym.xmi")
    with pytest.raises(ModelFileError):
        Net.load(tmp_path / "nothing.xmi")


def test_a_snapshot_does_not_change() -> None:
    net = Net(tiny(LOOP, {"a": ['{"notes": ["x"]}']}))
    before = net.inspect()
    before.marking["a"][0].data["notes"].append("y")  # type: ignore[union-attr]
    with pytest.raises(TypeError):
        before.marking["a"] = ()  # type: ignore[index]
    node = Node(net)
    node.open()
    node.step()
    assert before.count("a") == 1
    assert net.inspect().marking["b"][0].data["notes"] == ["x"]
    node.close()


def test_inspecting_a_net_that_never_rests() -> None:
    with Net(tiny(LOOP, {"a": 5})) as net:
        firings = [net.inspect().firings for _ in range(20)]
        assert firings == sorted(firings)
        for _ in range(5):
            state = net.inspect()
            assert state.count("a") + state.count("b") == 5
        net.wait_for(lambda state: state.firings > firings[-1] + 1000, timeout=SECONDS)


def test_changes_are_told_and_a_faulty_callback_changes_nothing() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 2}, signals="s", clauses={"go": "s"}))
    told: list[Change] = []

    @net.on_change
    def note(change: Change) -> None:
        told.append(change)
        made = change.fields.get("made")
        if isinstance(made, dict):
            made["b"][0][1]["color"] = "stolen"  # a copy
        raise RuntimeError

    node = Node(net)
    node.open()
    net.signal("s").set(True, source="test")
    node.run_until_idle()
    assert [change.event for change in told] == ["start", "signal", "fire", "fire"]
    assert told[1].fields == {"signal": "s", "value": True, "source": "test"}
    net.remove_callback(note)
    node.close()
    assert len(told) == 4
    assert {token.data["color"] for token in net.inspect().marking["b"]} == {""}


def test_a_signal_set_by_a_handler_counts_after_the_firing() -> None:
    net = Net(tiny({"go": "a -> b", "on": "b -> c"}, {"a": 1}, signals="s", clauses={"on": "s"}))
    values: list[object] = []

    @net.handler("go")
    def go(firing: Firing) -> None:
        net.signal("s").set(True)
        values.append(net.signal("s").value)
        values.append(net.inspect().count("a"))

    node = Node(net)
    node.open()
    node.run_until_idle()
    assert values == [False, 1]
    assert counts(net) == {"a": 0, "b": 0, "c": 1}
    node.close()


def test_signals_that_are_not_there_or_no_booleans() -> None:
    net = Net(tiny({"go": "a -> b"}, signals="Danger"))
    with pytest.raises(UnknownElementError, match="did you mean 'Danger'"):
        net.signal("Dagger")
    with pytest.raises(FeatureValueError, match="takes True or False"):
        net.signal("Danger").set(1)  # type: ignore[arg-type]
    with pytest.raises(UnknownElementError):
        net.count("nowhere")


def test_a_net_has_one_node() -> None:
    net = Net(tiny({"go": "a -> b"}))
    Node(net)
    with pytest.raises(DinerosError, match="already has a node"):
        Node(net)


def test_waiting_in_vain() -> None:
    with (
        Net(tiny({"go": "a -> b"}, {"a": 1})) as net,
        pytest.raises(TimeoutError, match=r"did not reach this state in 0\.05 s"),
    ):
        net.wait_for(lambda state: state.count("b") == 2, timeout=0.05)


class _FullDisk:
    """A recorder that cannot write any more."""

    def open(self, ports: Ports, checkpoint: object) -> None:
        pass

    def record(self, event: str, **fields: object) -> None:
        if event == "fire":
            raise DinerosError("no space left")

    def close(self) -> None:
        pass


def test_a_recorder_that_fails_ends_the_node() -> None:
    net = Net(tiny(LOOP, {"a": 1}))
    node = Node(net, recorder=_FullDisk())
    node.start()
    assert node.join(SECONDS)
    assert "no space left" in str(net.inspect().halted)
    with pytest.raises(DinerosError, match="no space left"):
        node.stop()


def test_a_recorder_that_fails_ends_a_stepped_node() -> None:
    net = Net(tiny(LOOP, {"a": 1}))
    node = Node(net, recorder=_FullDisk())
    node.open()
    with pytest.raises(DinerosError, match="no space left"):
        node.run_until_idle()
    assert not node.step()
    assert node.failure is not None
    node.close()


def test_stopping_while_a_thread_hangs() -> None:
    net = Net(tiny({"go": "a -> b"}, {"a": 1}))
    gate = threading.Event()
    returned = threading.Event()

    def hang(firing: Firing) -> None:
        gate.wait(SECONDS)
        returned.set()

    net.handler("go", thread=True)(hang)
    with net:
        net.wait_for(lambda state: bool(state.in_flight), timeout=SECONDS)
    assert not returned.is_set()
    gate.set()
    assert counts(net) == {"a": 1, "b": 0}
