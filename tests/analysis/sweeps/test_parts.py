"""Questions on the workers of a Dask cluster of processes here, one of which is killed."""

from __future__ import annotations

import importlib.util
import json
import os
import pickle
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from case_study.build import build
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.checks.check import check
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import Enabled, Exists, Finally, Name
from dineros.analysis.model.subject import base_subject, subject_of
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
from dineros.analysis.sweeps import cluster as clusters
from dineros.analysis.sweeps.cluster import cluster_answers
from dineros.analysis.sweeps.parts import (
    TOGETHER,
    Part,
    add_report,
    all_of,
    answer_part,
    check_parts,
    conjuncts,
    property_answers,
    property_parts,
    question_parts,
)
from dineros.analysis.sweeps.point import unanswered
from dineros.analysis.sweeps.workers import PointProcesses
from dineros.analysis.witnesses.findings import Report
from dineros.analysis.witnesses.witness import witness_of
from dineros.metamodel import pn
from dineros.metamodel.files import save
from dineros.metamodel.files.xmi import xmi_bytes
from dineros.metamodel.settings import apply
from tests.cli.conftest import Run, run
from tests.support.systems.talker import talker

if TYPE_CHECKING:
    from distributed import LocalCluster

__all__ = ["run"]

needs_cluster = pytest.mark.skipif(
    importlib.util.find_spec("distributed") is None and not os.environ.get("CI"),
    reason="dask.distributed is not installed",
)
NONE = {"signals": "none", "overflow": "weighted"}


@pytest.fixture(scope="module")
def cluster() -> Iterator[LocalCluster]:
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, host="127.0.0.1"
    ) as made:
        yield made


def text(model: pn.Net) -> str:
    return xmi_bytes(model).decode()


def asked(kind: str, what: str) -> dict[str, Any]:
    return {"kind": kind, "text": what, **NONE}


def rows(report: Report) -> Any:
    """Return what a report says, in one order."""
    made = report.to_dict("model")
    findings = sorted(made["findings"], key=lambda found: (found["rule"], found["message"]))
    return findings, sorted(made["proved"]), sorted(made["unknown"])


def with_overflow() -> pn.Net:
    model = talker()
    apply(model, "Chatter.subscriber.Heard.limit=1")
    return model


@pytest.mark.parametrize("model", [talker(), with_overflow()], ids=["fine", "overflow"])
def test_parts_of_a_check_say_together_what_it_says(model: pn.Net) -> None:
    report, subject = Report(), base_subject(model)
    for part in check_parts(text(model), False, None, "work"):
        assert pickle.loads(pickle.dumps(part)) == part
        add_report(report, subject, part, pickle.loads(pickle.dumps(answer_part(part))))
    assert rows(report) == rows(check(model))


def test_every_question_of_a_check_is_put_to_somebody() -> None:
    from dineros.analysis.checks.check import QUESTIONS

    names = [name for names in TOGETHER for name in names]
    assert sorted(names) == sorted(type(question).__name__ for question in QUESTIONS)


@pytest.mark.long
@pytest.mark.parametrize(
    ("kind", "what", "status"),
    [
        ("enabled", "TShowResult", "reachable"),
        ("marking", "Shown >= 1", "reachable"),
        ("marking", "Shown >= 9", "unreachable"),
        ("ctl", "AG EF (Shown >= 1)", "holds"),
        ("ctl", "EF (Shown >= 9)", "violated"),
        ("ltl", "G (Shown <= 1)", "holds"),
        ("ltl", "G (Shown == 0)", "violated"),
    ],
)
def test_whoever_is_asked_answers_the_same(kind: str, what: str, status: str) -> None:
    model = build()
    for color in ("Blue", "Green"):
        apply(model, f"{color}Objects.tokens=0")
    subject = subject_of(model, "none")
    parts = question_parts(text(model), asked(kind, what), None, None, "work")
    assert len(parts) == (1 if kind == "ltl" else 3)
    for part in parts:
        outcome = pickle.loads(pickle.dumps(answer_part(part)))
        assert outcome.status == status
        if status == "reachable":
            witness = witness_of(subject, outcome.stem)  # replayed
            assert kind != "enabled" or witness.steps[-1].transition == what


def test_properties_are_divided_and_answered_the_same() -> None:
    """Groups of transitions and global questions, too: each part is told all that it needs."""
    subject = subject_of(talker(), "none")
    names, net = GroupedNames(subject.names), subject.net
    group = names.group(net.transitions[:2])
    properties = [
        Property("a", "ctl", Exists(Finally(Enabled(Name(group))))),
        Property("b", "ltl", parse("G F deadlock")),
        Property("c", "bound", places=("Noted", "Said")),
        *(Property(name, "global", examination=name) for name in GLOBAL_PROPERTIES),
    ]
    told = {"signals": "none", "overflow": "weighted", "memory": None, "seconds": 20.0}
    parts = property_parts(text(talker()), told, properties, names, "work")
    assert len(parts) == len(properties)
    sent = [pickle.loads(pickle.dumps(part)) for part in parts]
    found = {one.id: one.value for part in sent for one in property_answers(part, answer_part(part))}
    assert found == {one.id: one.value for one in answer_properties(net, names, properties)}
    assert None not in found.values()


def test_a_conjunction_is_answered_by_its_formulas() -> None:
    assert conjuncts("ctl", "AG a >= 1 & EF (b >= 1 & c >= 1)") == [
        "AG (a >= 1)",
        "EF ((b >= 1) & (c >= 1))",
    ]
    assert conjuncts("marking", "a >= 1 & b >= 1") == ["a >= 1 & b >= 1"]
    yes, no, open_ = Outcome("holds", by="x"), Outcome("violated"), Outcome("unknown", reason="time")
    assert all_of({"f": yes}, ["f", "g"]) is None
    assert all_of({"f": no}, ["f", "g"]) == no
    assert all_of({"f": open_, "g": yes}, ["f", "g"]) == open_
    assert all_of({"f": open_, "g": no}, ["f", "g"]) == no
    assert all_of({"f": yes, "g": Outcome("holds", by="y")}, ["f", "g"]) == Outcome("holds", by="x, y")


def test_what_died_is_unknown() -> None:
    died = Outcome("unknown", reason="its workers died: KilledWorker")
    part = Part("", "properties", {"properties": [Property("a", "global")]})
    assert unanswered(part, died.reason) == died
    (answer,) = property_answers(part, died)
    assert (answer.id, answer.value, answer.reason) == ("a", None, died.reason)
    report, model = Report(), talker()
    for number, part in enumerate(check_parts(text(model), False, None, "work")):
        add_report(report, base_subject(model), part, died if number == 1 else answer_part(part))
    assert [str(unknown) for unknown in report.unknown] == [
        "deadlock, callbacks, goals: its workers died: KilledWorker"
    ]
    assert report.proved


def test_parts_that_nobody_waits_for_end() -> None:
    model = build()
    for color in ("Red", "Blue", "Green"):
        apply(model, f"{color}Objects.tokens=60")
    (part, *_) = question_parts(text(model), asked("ctl", "AG EF (Shown >= 180)"), None, None, "long")
    processes = PointProcesses()
    said: list[Outcome] = []
    thread = threading.Thread(target=lambda: said.append(processes.answer(part)))
    thread.start()
    while not processes._busy:
        time.sleep(0.01)
    processes.end_work("long")
    thread.join(60)
    assert not thread.is_alive() and "died" in said[0].reason
    assert "died" in processes.answer(part).reason  # nor is it begun again
    processes.reap()


@pytest.mark.long
@needs_cluster
def test_a_worker_that_is_killed_costs_its_part_only(
    cluster: LocalCluster, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The part of the killed worker is done again by another; the answers are those of one machine."""
    model = talker()
    parts = check_parts(text(model), False, None, "killed")
    victims = [worker.pid for worker in cluster.workers.values()]
    killed = []

    def kill_one() -> None:
        while not children_of(victims[0]):  # until it works on a part
            time.sleep(0.002)
        os.kill(victims[0], signal.SIGKILL)
        killed.append(victims[0])

    killer = threading.Thread(target=kill_one)
    killer.start()
    answers = {part.questions: answer for part, answer in cluster_answers(parts, cluster.scheduler_address)}
    killer.join(60)
    assert killed
    report = Report()
    for part in parts:
        add_report(report, base_subject(model), part, answers[part.questions])
    assert rows(report) == rows(check(model))


def children_of(pid: int) -> list[str]:
    found = []
    for thread in Path(f"/proc/{pid}/task").glob("*/children"):
        found += thread.read_text().split()
    return found


@needs_cluster
def test_the_first_who_knows_ends_the_others(cluster: LocalCluster) -> None:
    model = build()
    easy = question_parts(text(model), asked("marking", "Shown >= 4"), None, None, "first")[:1]
    for color in ("Red", "Blue", "Green"):
        apply(model, f"{color}Objects.tokens=60")
    hard = question_parts(text(model), asked("ctl", "AG EF (Shown >= 180)"), None, None, "first")[:1]
    with closing(cluster_answers([*hard, *easy], cluster.scheduler_address)) as answers:
        assert next(answers)[1].status == "unreachable"
    deadline = time.monotonic() + 60
    while any(clusters_busy(cluster)):
        assert time.monotonic() < deadline
        time.sleep(0.1)


def clusters_busy(cluster: LocalCluster) -> list[bool]:
    """Tell of each worker whether it still works on a part."""
    from distributed import Client

    with Client(cluster.scheduler_address, set_as_default=False) as client:
        return list(client.run(lambda: bool(clusters._processes()._busy)).values())


@pytest.mark.long
@needs_cluster
def test_the_commands_answer_as_without_workers(cluster: LocalCluster, run: Run, tmp_path: Path) -> None:
    model, address = tmp_path / "talker.sym.xmi", cluster.scheduler_address
    save(with_overflow(), model)
    for arguments in (
        ("check", model),
        ("verify", model, "--signals", "none", "--ctl", "AG EF Noted >= 1"),
        ("verify", model, "--signals", "none", "--ltl", "G Noted <= 3 & G F Noted >= 0"),
        ("verify", model, "--signals", "none", "--ctl", "AG Noted <= 3 & AG Noted <= 2"),
        ("find", model, "--signals", "none", "--marking", "Noted >= 3"),
        ("find", model, "--signals", "none", "--marking", "Noted >= 9"),
    ):
        here, there = run(*arguments), run(*arguments, "--scheduler", address)
        assert there.exit_code == here.exit_code, there.stderr
        assert there.stdout.split(":")[0] == here.stdout.split(":")[0]
    there = run("check", model, "--confirm", "--scheduler", address)
    assert "confirmed by explicit search" in there.stdout
    asked = ("--properties", "OneSafe", "--properties", "ReachabilityDeadlock", "--json")
    here, there = (run("verify", model, *asked, *more) for more in ((), ("--scheduler", address)))
    assert there.exit_code == here.exit_code == 1, there.stderr
    values = [[one["value"] for one in json.loads(run.stdout)["properties"]] for run in (here, there)]
    assert values[0] == values[1] == [False, True]
    wrong = run("verify", model, "--ctl", "AG Nothing >= 1", "--scheduler", address)
    assert wrong.exit_code == 2 and "Nothing" in wrong.stderr


def test_a_scheduler_that_is_not_there(run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.sweeps.cluster.PATIENCE", 0.5)
    model = tmp_path / "talker.sym.xmi"
    save(talker(), model)
    for arguments in (("check", model), ("find", model, "--marking", "Noted >= 1")):
        result = run(*arguments, "--scheduler", "tcp://127.0.0.1:9")
        assert result.exit_code == 2 and "no scheduler at" in result.stderr
