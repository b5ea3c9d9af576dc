"""`--certificate` with `--time`, and `dineros certify`, through the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.cli.timed.test_find_and_verify import RACE
from tests.support.programs.commands import is_one_line_of_wrong_use, lines
from tests.support.systems.talker import talker


@pytest.fixture
def race(tmp_path: Path) -> Path:
    path = tmp_path / "race.net"
    path.write_text(RACE)
    return path


@pytest.mark.parametrize(
    ("question", "status", "backing"),
    [
        (("find", "--marking", "b >= 1"), 1, "state class"),
        (("find", "--marking", "a >= 1"), 0, "a schedule of 1 firing"),
        (("find", "--enabled", "slow"), 1, "state class"),
        (("find", "--enabled", "fast"), 0, "a schedule of 1 firing"),
        (("verify", "--ltl", "G !fired(slow)"), 0, "state class"),
        (("verify", "--ltl", "G (b = 0)"), 0, "state class"),
        (("verify", "--ctl", "AG (a = 0)"), 1, "a schedule of 1 firing"),
        (("verify", "--ctl", "EF (a >= 1)"), 0, "a schedule of 1 firing"),
    ],
)
def test_answers_have_certificates(
    run: Run, race: Path, tmp_path: Path, question: tuple[str, ...], status: int, backing: str
) -> None:
    file = tmp_path / "c.json"
    command, *asked = question
    answered = run(command, race, *asked, "--time", "--certificate", file)
    assert answered.exit_code == status
    assert f"certificate: {file}" in answered.stdout
    checked = run("certify", race, file)
    assert checked.exit_code == 0
    first, last = lines(checked)
    assert first.startswith("valid: ") and first.endswith(f"in {race} --time") and backing in last
    # Of a net that is a little different, it says nothing; nor does one that was changed.
    race.write_text(RACE.replace("[1,2]", "[1,3]"))
    assert lines(run("certify", race, file)) == [f"refuted: {file}: it belongs to another net"]
    race.write_text(RACE)
    file.write_text(file.read_text().replace('"answer": "', '"answer": "un'))
    assert run("certify", race, file).exit_code == 1


def test_what_is_about_several_moments_has_none(run: Run, race: Path, tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    result = run("verify", race, "--time", "--ltl", "F (a >= 1)", "--certificate", file)
    assert (result.exit_code, file.exists()) == (0, False)
    assert (
        f"{file} is not written: certificates cannot express properties of several moments of a run"
        in result.stderr
    )


def test_what_a_check_finds_never_to_happen(run: Run, race: Path, tmp_path: Path) -> None:
    folder, file = tmp_path / "proofs", tmp_path / "all.json"
    assert run("check", race, "--time", "--certificate", folder).exit_code == 1
    assert {one.name for one in folder.iterdir()} == {"bounded.json", "dead-slow.json"}
    for one in folder.iterdir():
        told = json.loads(run("certify", race, one, "--json").stdout)
        assert (told["valid"], told["time"], told["answer"]) == (True, True, "holds")
    assert "certificates: " in run("check", race, "--time", "--certificate", file).stdout
    assert run("certify", race, file).exit_code == 0
    # Without times, slow can fire: there is no such proof.
    run("check", race, "--certificate", tmp_path / "without")
    assert not (tmp_path / "without" / "dead-slow.json").exists()


def test_stored_properties(run: Run, tmp_path: Path) -> None:
    net = talker()
    find(net, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=1)
    net.properties.append(sym.Property(id="few", text="never Noted >= 9"))
    net.properties.append(sym.Property(id="some", text="Noted >= 1 is possible"))
    net.properties.append(sym.Property(id="ends", text="deadlock happens"))
    path, folder = tmp_path / "talker.sym.xmi", tmp_path / "proofs"
    save(net, path)
    run("check", path, "--time", "--certificate", folder)
    names = {one.name for one in folder.iterdir()}
    assert {"property-few.json", "property-some.json"} <= names and "property-ends.json" not in names
    for one in folder.iterdir():
        assert run("certify", path, one).exit_code == 0, one
    file = tmp_path / "few.json"
    result = run("verify", path, "few", "--time", "--certificate", file, "--confirm")
    assert result.exit_code == 0 and "confirmed by " in result.stdout
    assert run("certify", path, file).exit_code == 0


def test_parts_of_a_wrong_shape_are_bad_input(run: Run, race: Path, tmp_path: Path) -> None:
    file = tmp_path / "c.json"
    run("find", race, "--time", "--marking", "b >= 1", "--certificate", file)
    whole = json.loads(file.read_text())
    one = whole["classes"][0]
    for name, wrong in (
        ("classes", [{**one, "marking": {"p": 0.5}}]),
        ("classes", [{**one, "marking": {"p": True}}]),
        ("classes", [{**one, "times": {"fast": 1}}]),
        ("classes", [{"marking": {}}]),
        ("schedule", [{"fires": "fast", "at": 1}]),
        ("format", "dineros certificate 2"),
        ("never", []),
    ):
        file.write_text(json.dumps({**whole, name: wrong}))
        assert is_one_line_of_wrong_use(run("certify", race, file), "holds no certificate")
