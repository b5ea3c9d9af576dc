"""Tests from traces can do every step of the trace: ticks, goals, lost messages, lives of managed nodes."""

from __future__ import annotations

import logging
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import HealthCheck, Phase, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.model.subject import base_subject
from dineros.generators.workspace.steps import ScriptError
from dineros.metamodel import pn, sym
from dineros.metamodel.build import flow
from dineros.metamodel.elements import find, transitions
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split
from tests.runtime.ros.errands import errands
from tests.support.programs.scripted import drive, write_walk, write_witness
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.history_models import history_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models
from tests.support.ros2_systems.managed_systems import camera
from tests.support.systems.talker import talker

MODELS = {
    "actions": action_models(),
    "executors": executor_models(),
    "histories": history_models(),
    "lifecycles": lifecycle_models(),
}


def hello(middleware: str = "ros2") -> sym.SystemModel:
    """Return the talker, who says a word whenever his timer ticks, through histories of one message."""
    model = talker()
    speaker = find(model, "talker", sym.NodeNet)
    page = sym.CallbackPage(id="OnTimer", kind="timer", timer=500.0)
    nodes, arcs = list(speaker.objects), list(speaker.arcs)
    page.objects.extend(nodes)
    page.arcs.extend(arcs)
    speaker.objects.append(page)
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    channel.publishers[0].limit = channel.subscribers[0].limit = 1
    model.middleware = middleware
    return model


def fired(model: sym.SystemModel, path: Path, *names: str) -> Path:
    """Write the witness of a firing sequence, by ids of the flattened net."""
    subject = base_subject(model)
    write_witness(subject, [subject.transition_index[name] for name in names], path)
    return path


SAY = ("OnTimer.tick", "Say", "Chatter.publisher.Said.publish", "Chatter.writer.Said.Heard.in")
HEAR = ("Chatter.writer.Said.Heard.out", "Chatter.reader.Heard.in", "Chatter.reader.Heard.out", "Listen")


def test_a_timer_ticks_when_its_callback_begins(tmp_path: Path) -> None:
    trace = fired(hello(), tmp_path / "heard.jsonl", *SAY, *HEAR, "OnTimer.tick", "Say", "OnTimer.tick")
    drive(hello(), trace, tmp_path / "ws")


def test_under_the_rules_of_ros1_no_tick_is_in_the_trace(tmp_path: Path) -> None:
    drive(hello("ros1"), fired(hello("ros1"), tmp_path / "said.jsonl", "Say", "Say"), tmp_path / "ws")


def test_a_full_history_of_a_writer_loses_a_message_on_its_way_to_one_reader(tmp_path: Path) -> None:
    lost = [*SAY[:3], "Chatter.writer.Said.Heard.drop"]
    trace = fired(hello(), tmp_path / "lost.jsonl", *SAY, *lost, *HEAR)
    drive(hello(), trace, tmp_path / "ws")


def test_no_time_has_to_pass(tmp_path: Path) -> None:
    model = hello()
    find(model, "Listen", sym.Transition).interval = pn.TimeInterval(earliest=900.0, latest=900.0)
    drive(model, fired(model, tmp_path / "slow.jsonl", *SAY, *HEAR), tmp_path / "ws")


def test_a_transition_that_the_model_lacks_is_still_refused(tmp_path: Path) -> None:
    model = hello()
    trace = fired(model, tmp_path / "heard.jsonl", *SAY)
    trace.write_text(trace.read_text().replace('"OnTimer.tick"', '"OnTime.tick"'))
    with pytest.raises(ScriptError, match=r"no transition 'OnTime\.tick'"):
        drive(model, trace, tmp_path / "ws")


def delivery() -> sym.SystemModel:
    """Return an office that sends two goals to a robot and may recall one, as a goal may be refused."""
    robot, office = sym.NodeNet(id="robot", execution="callbacks"), sym.NodeNet(id="office")
    work = sym.CallbackPage(id="Deliver", kind="goal", page=robot)
    parcel, driving, there, stop, back = (
        sym.Place(id=id, page=work) for id in ("Parcel", "Driving", "There", "Stop", "Back")
    )
    flow(parcel, sym.Transition(id="Start", page=work), driving)
    flow(driving, sym.Transition(id="Arrive", page=work), there)
    flow(driving, turn := sym.Transition(id="Turn", page=work), back)
    flow(stop, turn)
    send, recall = sym.Place(id="Send", tokens=2, page=office), sym.Place(id="Recall", page=office)
    flow(sym.Place(id="Doubt", tokens=1, page=office), sym.Transition(id="Regret", page=office), recall)
    done, failed, no = (sym.Place(id=id, page=office) for id in ("Done", "Failed", "Refused"))
    server = sym.ActionServerPort(
        page=work, entry=parcel, succeeded=there, canceled=back, cancel=stop, mayReject=True
    )
    client = sym.ActionClientPort(
        client="office", goal=send, succeeded=done, canceled=failed, rejected=no, cancel=recall
    )
    action = sym.ActionChannel(id="Delivery", action="/deliver", server=server, clients=[client])
    return sym.SystemModel(id="delivery", middleware="ros2", pages=[robot, office], channels=[action])


@pytest.mark.long
def test_goals_are_accepted_canceled_and_refused(tmp_path: Path) -> None:
    for seed in range(5):
        folder = tmp_path / str(seed)
        folder.mkdir()
        assert write_walk(delivery(), folder / "walk.jsonl", seed)
        drive(delivery(), folder / "walk.jsonl", folder / "ws")


@pytest.mark.long
@pytest.mark.parametrize("kind", sorted(MODELS))
@settings(max_examples=6, deadline=None, phases=[Phase.generate], suppress_health_check=list(HealthCheck))
@given(st.data())
def test_a_walk_of_any_model_can_be_done(kind: str, data: st.DataObject) -> None:
    logging.disable(logging.CRITICAL)
    model, seed = data.draw(MODELS[kind]), data.draw(st.integers(0, 1000))
    for transition in transitions(model):
        transition.overrides.clear()  # no net with priorities is compiled
    for action in [each for each in model.channels if isinstance(each, sym.ActionChannel)]:
        for client in action.clients:
            if (client.outstanding or 1) > 1:
                client.accepted = None  # no marking says which of several goals is known to be accepted
    try:
        with TemporaryDirectory() as name:
            folder = Path(name)
            assume(write_walk(model, folder / "walk.jsonl", seed))
            try:
                drive(model, folder / "walk.jsonl", folder / "ws")
            except ScriptError as error:
                # No script knows how long a client waits, and nodes wait for the end of a goal.
                assert "gives up a request" in error.message or "without waiting for" in error.message
    finally:
        logging.disable(logging.NOTSET)


@pytest.mark.long
@pytest.mark.parametrize("make", [errands, delivery, camera])
def test_what_was_recorded_can_be_done_again(make: object, tmp_path: Path) -> None:
    assert callable(make)
    model = make()
    application = LocalApplication(split(model), seed=3, recorder=partial(JournalRecorder, tmp_path / "run"))
    application.open()
    application.run(lambda _: False, 2.0)
    application.close()
    drive(make(), tmp_path / "run", tmp_path / "ws")
