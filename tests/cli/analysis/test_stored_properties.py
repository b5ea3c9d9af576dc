"""Properties that a model stores, on the command line: one verified, all written, others taken in."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel import sym
from dineros.metamodel.files import load, save
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines
from tests.support.systems.door import ask, door


@pytest.fixture
def model(tmp_path: Path) -> Path:
    net = door()
    ask(net, "never Jammed >= 1", name="no jam")
    ask(net, "never Jammed >= 1", expected=False)
    ask(net, "fired(Close) only after fired(Open)")
    ask(net, "Jammed >= 1 is possible")
    ask(net, "never Jamed >= 1")
    save(net, path := tmp_path / "door.sym.xmi")
    return path


def test_the_status_says_whether_it_is_as_expected(run: Run, model: Path) -> None:
    result = run("verify", model, "no jam")
    assert (result.exit_code, lines(result)[0].split(";")[0]) == (1, "violated: property0: never Jammed >= 1")
    assert [line.split()[1] for line in lines(result)[1:3]] == ["Open", "Jam"]
    result = run("verify", model, "property1")
    assert result.exit_code == 0
    assert lines(result)[0].startswith("violated: property1: never Jammed >= 1; expected not to hold")
    assert run("verify", model, "property2").exit_code == 0


def test_as_json(run: Run, model: Path) -> None:
    result = run("verify", model, "property3", "--json")
    said = json.loads(result.stdout)
    assert (result.exit_code, said["property"], said["status"], said["expected"]) == (
        0,
        "property3",
        "holds",
        True,
    )
    assert said["formula"] == "G !(Jammed >= 1)"
    assert said["witness"]["steps"]


def test_a_witness_is_written(run: Run, model: Path, tmp_path: Path) -> None:
    output = tmp_path / "jam.json"
    assert run("verify", model, "no jam", "-o", output).exit_code == 1
    assert output.read_text().strip()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["nothing"], "stores no property 'nothing'"),
        (["property4"], "property property4, column 7: no place is named 'Jamed' (did you mean 'Jammed'?)"),
        (["no jam", "--engine", "tina", "--ltl", "true"], "cannot be combined with --ltl"),
    ],
)
def test_wrong_use(run: Run, model: Path, arguments: list[str], message: str) -> None:
    result = run("verify", model, *arguments)
    assert result.exit_code == 2 and message in result.stderr and "Traceback" not in result.stderr


def test_property_files_go_both_ways(run: Run, model: Path, tmp_path: Path) -> None:
    written, more = tmp_path / "door.xml", tmp_path / "more.sym.xmi"
    result = run("verify", model, "--write-properties", written)
    assert result.exit_code == 0
    left_out = [line for line in result.stderr.splitlines() if "is left out" in line]
    assert [line.split()[2] for line in left_out] == ["property2", "property4"]
    assert is_one_line_of_wrong_use(
        run("convert", model, "-o", more, "--properties", written), "an element 'property0' already"
    )
    assert not more.exists()
    written.write_text(written.read_text().replace("<id>", "<id>Again"))
    assert run("convert", model, "-o", more, "--properties", written).exit_code == 0
    net = load(more)
    assert isinstance(net, sym.SystemModel)
    assert [str(each.id) for each in net.properties][5:] == [
        "Againproperty0",
        "Againproperty1",
        "Againproperty3",
    ]
    assert [run("verify", more, f"Againproperty{number}").exit_code for number in (0, 1, 3)] == [1, 1, 0]


def test_what_cannot_store_or_write_any(run: Run, tmp_path: Path, model: Path) -> None:
    net, written = tmp_path / "net.net", tmp_path / "questions.xml"
    net.write_text("net ends\npl a (3)\ntr t a -> b\n")
    assert is_one_line_of_wrong_use(
        run("verify", net, "--write-properties", written), "stores no property that can be written"
    )
    run("verify", net, "--ctl", "EF b >= 1", "--write-properties", written)
    assert is_one_line_of_wrong_use(
        run("convert", net, "-o", tmp_path / "out.pnml", "--properties", written), "only a system model"
    )


def test_all_files_hold_them(model: Path, tmp_path: Path) -> None:
    net = load(model)
    assert isinstance(net, sym.SystemModel)
    net.assumptions.append(sym.Fairness(id="fair", of="all-but:Jam", strong=True))
    signals = net.pages[0].signals  # type: ignore[attr-defined]
    net.assumptions.append(sym.ExclusiveSignals(id="apart", signals=list(signals)))
    ask(net, "AG EF Closed >= 1", language="ctl", signals="ioEnabled")
    save(net, tmp_path / "first.sym.xmi")
    save(load(tmp_path / "first.sym.xmi"), tmp_path / "door.pnml")
    save(load(tmp_path / "door.pnml"), tmp_path / "second.sym.xmi")
    assert (tmp_path / "first.sym.xmi").read_bytes() == (tmp_path / "second.sym.xmi").read_bytes()
