"""Managed nodes without ROS: brought up in the start order, held back while inactive, resumed, conforming."""

from __future__ import annotations

from functools import partial
from pathlib import Path

import pytest

from dineros.analysis.conformance import conform
from dineros.metamodel import sym
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.records import Drop, Lifecycle, Publish, Record, Take, read_trace, traces_of_runs
from dineros.metamodel.settings import apply
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder, resume_journal
from dineros.transformations.flattening.split import split
from tests.support.ros2_systems.managed_systems import camera, talk


def application(model: sym.SystemModel, folder: Path) -> LocalApplication:
    return LocalApplication(split(model), seed=1, recorder=lambda id: JournalRecorder(folder, id))


def records(folder: Path, node: str) -> list[Record]:
    return list(read_trace(traces_of_runs([folder])[node]))


def conforms(model: sym.SystemModel, folder: Path) -> bool:
    traces = {n: partial(read_trace, files) for n, files in traces_of_runs([folder]).items()}
    return conform(model, traces).status == "conforms"


def test_brought_up_in_the_start_order(tmp_path: Path) -> None:
    model = camera()
    for step, node in enumerate(("display", "detector", "camera"), 1):
        apply(model, f"{node}.lifecycle.configureStep={step}")
        apply(model, f"{node}.lifecycle.activateStep={step + 3}")
    with application(model, tmp_path) as app:
        assert {net.state for net in app.nets.values()} == {"active"}
        app.run(lambda app: False, timeout=2)
    changes = sorted(
        (record.time or 0, record.label, node)
        for node in app.nets
        for record in records(tmp_path, node)
        if isinstance(record, Lifecycle)
    )
    assert [change[1:] for change in changes] == [
        *(("configure", node) for node in ("display", "detector", "camera")),
        *(("activate", node) for node in ("display", "detector", "camera")),
    ]
    assert conforms(model, tmp_path)
    apply(model, "camera.lifecycle.activateStep=1")
    apply(model, "display.lifecycle.configureStep=7")
    apply(model, "display.lifecycle.activateStep=8")
    assert not conforms(model, tmp_path), "another order is not what was done"


def test_what_is_published_while_inactive_is_lost(tmp_path: Path) -> None:
    model = talk(sym.Lifecycle(deactivates=True), sym.Lifecycle(), tokens=4, depth=4)
    with application(model, tmp_path) as app:
        app.nets["talker"].change_state("deactivate")
        for _ in range(5):
            app.nodes["talker"].step()
        app.nets["talker"].change_state("activate")
        app.run(lambda app: False, timeout=2)
        assert app.count("talker", "Said") == 0
    lost = [each for each in records(tmp_path, "talker") if isinstance(each, Drop)]
    sent = [each for each in records(tmp_path, "talker") if isinstance(each, Publish)]
    assert {each.queue for each in lost} == {"inactive"}
    assert lost and len(lost) + len(sent) == 4
    assert conforms(model, tmp_path)
    model.pages[0].lifecycle.deactivates = False  # type: ignore[attr-defined]
    assert not conforms(model, tmp_path)


def test_who_pauses_fires_nothing_while_inactive(tmp_path: Path) -> None:
    model = talk(sym.Lifecycle(deactivates=True, pauses=True), None, tokens=3, depth=3)
    with application(model, tmp_path) as app:
        app.nets["talker"].change_state("deactivate")
        app.run(lambda app: False, timeout=1)
        assert app.count("talker", "Words") == 3
        app.nets["talker"].change_state("activate")
        app.run(lambda app: False, timeout=1)
        assert app.count("talker", "Words") == 0
    assert conforms(model, tmp_path)


def test_it_comes_back_in_the_state_it_had(tmp_path: Path) -> None:
    model = talk(sym.Lifecycle(deactivates=True), None, tokens=1)
    with application(model, tmp_path) as app:
        app.nets["talker"].change_state("deactivate")
    resumed = {id: resume_journal(tmp_path, id) for id in ("talker", "listener")}
    recorders = {id: recorder for id, (recorder, _) in resumed.items()}
    checkpoints = {id: checkpoint for id, (_, checkpoint) in resumed.items() if checkpoint is not None}
    again = LocalApplication(split(model), seed=2, recorder=recorders.__getitem__, resume=checkpoints)
    with again as app:
        assert app.nets["talker"].state == "inactive"
        app.run(lambda app: False, timeout=1)
    assert [each.queue for each in records(tmp_path, "talker") if isinstance(each, Drop)] == ["inactive"]
    assert conforms(model, tmp_path)


def test_a_change_that_is_not_allowed(tmp_path: Path) -> None:
    with application(talk(sym.Lifecycle(), None), tmp_path) as app:
        with pytest.raises(DinerosError, match="the node talker is active: it cannot configure"):
            app.nets["talker"].change_state("configure")
        with pytest.raises(DinerosError, match="the node listener has no lifecycle"):
            app.nets["listener"].change_state("activate")


def test_reader_that_is_cleaned_up_conforms(tmp_path: Path) -> None:
    """In a run whose listener goes and comes again, what it missed is lost."""
    model = talk(None, sym.Lifecycle(deactivates=True, cleansUp=True), tokens=2)
    with application(model, tmp_path) as app:
        app.run(lambda app: False, timeout=1)
        for label in ("deactivate", "cleanup", "configure", "activate"):
            app.nets["listener"].change_state(label)
        app.run(lambda app: False, timeout=1)
    assert conforms(model, tmp_path)


def test_writer_that_keeps_for_a_reader_that_comes_again_conforms(tmp_path: Path) -> None:
    """It sends more than it keeps: what is new takes the place of what is delivered."""
    model = talk(None, sym.Lifecycle(deactivates=True, cleansUp=True), tokens=6, depth=2)
    (topic,) = model.channels
    assert isinstance(topic, sym.TopicChannel)
    topic.qos = sym.QualityOfService(durability="transientLocal")
    with application(model, tmp_path) as app:
        app.run(lambda app: False, timeout=1)
    assert len([each for each in records(tmp_path, "listener") if isinstance(each, Take)]) > 2
    assert conforms(model, tmp_path)
