"""`verify --properties`: the contest's files, its global questions, and writing."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.evidence import confirmation
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines, uses

QUESTIONS = """<property-set xmlns="http://mcc.lip6.fr/">
  <property><id>ends-UpperBounds-00</id><formula><place-bound><place>b</place></place-bound></formula></property>
  <property><id>ends-CTLFireability-00</id><formula>
    <exists-path><finally><is-fireable><transition>u</transition></is-fireable></finally></exists-path>
  </formula></property>
</property-set>
"""


@pytest.fixture
def questions(tmp_path: Path) -> Path:
    path = tmp_path / "questions.xml"
    path.write_text(QUESTIONS)
    return path


@uses("ends")
def test_files_and_global_questions(run: Run, net: Path, questions: Path) -> None:
    asked = ["--properties", questions, "--properties", "ReachabilityDeadlock", "--timeout", "2"]
    result = run("verify", net, *asked)
    assert result.exit_code == 1
    assert sorted(line.split(";")[0] for line in lines(result)) == [
        "3: ends-UpperBounds-00",
        "holds: ReachabilityDeadlock",
        "violated: ends-CTLFireability-00",
    ]
    report = json.loads(run("verify", net, *asked, "--json").stdout)
    assert list(report) == ["model", "properties"]
    assert [(one["id"], one["status"], one["value"]) for one in report["properties"]] == [
        ("ends-UpperBounds-00", "bound", 3),
        ("ends-CTLFireability-00", "violated", False),
        ("ReachabilityDeadlock", "holds", True),
    ]


@uses("grows")
def test_what_stays_open_is_unknown(run: Run, net: Path, tmp_path: Path) -> None:
    bound = "<property><id>b</id><formula><place-bound><place>b</place></place-bound></formula></property>"
    (tmp_path / "bound.xml").write_text(f'<property-set xmlns="http://mcc.lip6.fr/">{bound}</property-set>')
    result = run("verify", net, "--properties", tmp_path / "bound.xml", "--timeout", "0.2")
    assert (result.exit_code, result.stdout.split(";")[0]) == (3, "unknown: b")


@uses("ends")
def test_questions_are_written_and_read_back(run: Run, net: Path, questions: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.xml"
    result = run("verify", net, "--properties", questions, "--write-properties", again)
    assert (result.exit_code, lines(result)) == (0, [f"{again}: 2 properties"])
    assert run("verify", net, "--properties", again, "--timeout", "1").exit_code == 1
    assert run("verify", net, "--ltl", "F deadlock", "--write-properties", again).exit_code == 0
    assert lines(run("verify", net, "--properties", again))[0].startswith("holds: ends-LTL-00; ")


@uses("ends")
def test_what_rests_on_all_markings_is_confirmed(run: Run, net: Path, questions: Path) -> None:
    asked = ["--properties", questions, "--properties", "ReachabilityDeadlock", "--confirm", "--json"]
    rows = json.loads(run("verify", net, *asked).stdout)["properties"]
    assert any(row["confirmation"] for row in rows)
    shown = ("structure", "state equation", "initial marking", "random walk")
    for row in rows:
        assert (row["confirmation"] is None) == (row["technique"] in shown)
        assert row["confirmation"] is None or row["confirmation"]["agrees"]


@uses("ends")
def test_engines_that_disagree_leave_a_property_unknown(
    run: Run, net: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run("verify", net, "--ctl", "AG EF deadlock", "--write-properties", tmp_path / "q.xml")
    asked = ("verify", net, "--properties", tmp_path / "q.xml", "--confirm")
    assert run(*asked).exit_code == 0
    monkeypatch.setattr(confirmation, "check_ctl", lambda *_, **__: Outcome("violated"))
    result = run(*asked)
    assert (result.exit_code, result.stderr.count("please report it")) == (3, 1)
    assert lines(result)[-1].startswith("unknown: ends-CTL-00; engines disagree: ")


@uses("ends")
def test_wrong_use(run: Run, net: Path, questions: Path, tmp_path: Path) -> None:
    with_formula = run("verify", net, "--properties", questions, "--ctl", "EF deadlock")
    assert is_one_line_of_wrong_use(with_formula, "--properties cannot be combined with")
    twice = run("verify", net, "--properties", "Liveness", "--properties", "Liveness")
    assert is_one_line_of_wrong_use(twice, "'Liveness' is given twice")
    assert is_one_line_of_wrong_use(run("verify", net, "--properties", net), "is not well-formed XML")
    missing = run("verify", net, "--properties", tmp_path / "missing.xml")
    assert is_one_line_of_wrong_use(missing, "cannot be read")
    fired = run("verify", net, "--ltl", "F fired(t)", "--write-properties", tmp_path / "w.xml")
    assert is_one_line_of_wrong_use(fired, "it refers to steps")
    assert not (tmp_path / "w.xml").exists()


def test_high_level_nets_are_refused(run: Run, questions: Path, tmp_path: Path) -> None:
    kind = "http://www.pnml.org/version-2009/grammar/highlevelnet"
    head = '<pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml">'
    (tmp_path / "net.pnml").write_text(f'{head}<net id="n" type="{kind}"><page id="p"/></net></pnml>')
    result = run("verify", tmp_path / "net.pnml", "--properties", questions)
    assert is_one_line_of_wrong_use(result, "highlevelnet' is not supported")
