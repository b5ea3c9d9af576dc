"""Witnesses as traces: every step of a flattened net has its role, found by trace links."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

import pytest

from dineros.analysis.model.step_roles import step_roles
from dineros.analysis.model.subject import subject_of
from dineros.analysis.portfolio.asking import find_firing
from dineros.analysis.witnesses.records import witness_records
from dineros.analysis.witnesses.witness import witness_of
from dineros.metamodel import sym
from dineros.metamodel.files import load
from dineros.metamodel.records import (
    Drop,
    Fire,
    Header,
    Publish,
    Reply,
    Request,
    Response,
    Serve,
    Signal,
    Take,
    Transfer,
    decode_record,
    encode_record,
)
from dineros.metamodel.records.schema import Step
from tests.support.systems.talker import talker

CASE_STUDY = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


def case_study() -> sym.SystemModel:
    model = load(CASE_STUDY)
    assert isinstance(model, sym.SystemModel)
    return model


def test_roles_of_the_case_study() -> None:
    subject = subject_of(case_study(), "fully-enabled")
    roles = step_roles(subject.links())
    assert set(roles) == set(subject.net.transitions)
    clients = sum(2 * 2 for _ in range(4)) + 1  # clients x instances
    assert Counter(role.kind for role in roles.values()) == {
        Publish: 5,
        Take: 3,
        Drop: 5 + 3 + 3,
        Transfer: 3
        + 5
        + 3
        + 3
        + 3,  # transport; publishers leave; dispatchers enter, leave; subscribers enter
        Request: 9,
        Response: 9,
        Serve: clients,
        Reply: clients,
        Signal: 2 * 9,
        Fire: len(subject.net.transitions) - 5 - 3 - 11 - 17 - 18 - 2 * clients - 18,
    }
    assert roles["Pick.client.L.call[2]"].fields() == {
        "node": "executor",
        "channel": "Pick",
        "client": "L",
        "instance": 2,
        "place": "Pick[2].PickEntry",
    }
    assert roles["Pick[1].TPickFail"].fields() == {"node": "executor"}
    stages = {role.stage for role in roles.values() if role.kind is Transfer}
    assert stages == {
        "transport",
        "publisher.leave",
        "dispatcher.enter",
        "dispatcher.leave",
        "subscriber.enter",
    }


@pytest.mark.parametrize("signals", ["fully-enabled", "input-enabled", "io-enabled"])
def test_a_witness_as_a_trace(signals: str) -> None:
    subject = subject_of(talker(), signals)  # type: ignore[arg-type]
    answer = find_firing(subject.net, subject.transition_index["Listen"])
    assert answer.trace is not None
    witness = witness_of(subject, answer.trace)
    header, *steps = witness_records(
        witness, source="a.xmi", settings=["Words.tokens=3"], asked="q", verdict="reachable"
    )
    assert isinstance(header, Header)
    assert (header.model, header.source, header.settings) == ("greeting", "a.xmi", ["Words.tokens=3"])
    assert (header.signals, header.overflow, header.loop) == (signals, "weighted", None)
    assert header.signals_initial == {"Button": False}
    assert header.marking["Words"] == 3
    assert [step.event for step in steps] == [
        "signal",
        "fire",
        "publish",
        *["transfer"] * 5,
        "take",
        "fire",
    ]
    signal, fire, publish, *_, take, _ = steps
    assert isinstance(signal, Signal)
    assert (signal.signal, signal.value, signal.node) == ("Button", True, "talker")
    assert isinstance(fire, Fire)
    assert (fire.transition, fire.node) == ("Say", "talker")
    assert isinstance(publish, Publish)
    assert (publish.channel, publish.place, publish.node) == ("Chatter", "Said", "talker")
    assert publish.text == "publisher queue of Said (topic chatter) takes a message"
    assert isinstance(take, Take)
    assert (take.place, take.node, take.change["Heard"]) == ("Heard", "listener", 1)
    # The changes lead from the header's marking to that of the net.
    marking = Counter(header.marking)
    for step in steps:
        assert isinstance(step, Step)
        assert step.transition in subject.transition_index
        marking.update(step.change)
    assert all(tokens >= 0 for tokens in marking.values())
    assert (marking["Noted"], marking["Words"]) == (1, 2)
    for record in (header, *steps):
        assert decode_record(encode_record(record)) == record


def test_a_loss_names_its_queue() -> None:
    model = talker()
    channel = model.channels[0]
    assert isinstance(channel, sym.TopicChannel)
    channel.subscribers[0].limit = 1
    subject = subject_of(model, "none")
    (drop,) = [
        name
        for name, role in step_roles(subject.links()).items()
        if role.kind is Drop and role.queue == "subscriber"
    ]
    answer = find_firing(subject.net, subject.transition_index[drop])
    assert answer.trace is not None
    *_, last = witness_records(witness_of(subject, answer.trace), source="")
    assert isinstance(last, Drop)
    assert (last.channel, last.queue, last.place, last.node) == ("Chatter", "subscriber", "Heard", "listener")
