"""``dineros convert``."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.metamodel import elements, pn
from dineros.metamodel.build import flow
from dineros.metamodel.files import load, save
from tests.cli.conftest import Run


def test_there_and_back_gives_the_same_file(run: Run, model: Path, tmp_path: Path) -> None:
    there, back = tmp_path / "there.pnml", tmp_path / "back.sym.xmi"
    result = run("convert", model, "-o", there)
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"{model} -> {there}\n", "")
    assert run("convert", there, "-o", back).exit_code == 0
    assert back.read_bytes() == model.read_bytes()


def test_quiet_prints_nothing(run: Run, model: Path, tmp_path: Path) -> None:
    result = run("convert", model, "-o", tmp_path / "out.pnml", "--quiet")
    assert (result.exit_code, result.stdout, result.stderr) == (0, "", "")


def test_settings_change_the_output_only(run: Run, model: Path, tmp_path: Path) -> None:
    before, out = model.read_bytes(), tmp_path / "out.sym.xmi"
    assert run("convert", model, "-o", out, "--set", "Words.tokens=7").exit_code == 0
    assert elements.find(load(out), "Words", pn.Place).tokens == 7
    assert model.read_bytes() == before


def test_a_file_can_be_converted_onto_itself(run: Run, model: Path) -> None:
    assert run("convert", model, "-o", model, "--set", "Words.tokens=7").exit_code == 0
    assert elements.find(load(model), "Words", pn.Place).tokens == 7


@pytest.mark.parametrize("formats", [("net", "pnml"), ("pnml", "net"), ("net", "xmi"), ("xmi", "net")])
def test_plain_nets(run: Run, tmp_path: Path, formats: tuple[str, str]) -> None:
    red, go = pn.Place(id="red", tokens=1), pn.Transition(id="go")
    page = pn.Page(id="page", objects=[red, go])
    flow(red, go, weight=2)
    source, target = (tmp_path / f"net.{suffix}" for suffix in formats)
    save(pn.Net(id="traffic", pages=[page]), source)
    assert run("convert", source, "-o", target).exit_code == 0
    net = load(target)
    assert [place.tokens for place in elements.places(net)] == [1]
    assert [arc.weight for arc in elements.arcs(net)] == [2]


def test_an_invalid_model_is_converted_with_a_warning(run: Run, broken: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.pnml"
    result = run("convert", broken, "-o", out)
    assert result.exit_code == 0
    assert result.stderr.startswith(f"{broken}: warning: the model has errors: 1 ")
    assert result.stderr.count("\n") == 1
    assert out.exists()


def test_settings_that_break_a_constraint_are_refused(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "out.pnml"
    result = run("convert", model, "-o", out, "--set", "Chatter.publisher.Said.limit=0")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"{model}: ")
    assert result.stderr.count("\n") == 1
    assert not out.exists()


def test_settings_are_not_blamed_for_what_was_wrong_before(run: Run, broken: Path, tmp_path: Path) -> None:
    assert run("convert", broken, "-o", tmp_path / "out.pnml", "--set", "Words.tokens=2").exit_code == 0


@pytest.mark.parametrize(
    ("name", "part"),
    [
        ("out.txt", "known are .xmi, "),
        ("out", "known are .xmi, "),
        ("folder.pnml", "is a directory"),
        ("no/such/folder/out.pnml", "create the folder first"),
    ],
)
def test_an_output_that_cannot_be_written(
    run: Run, model: Path, tmp_path: Path, name: str, part: str
) -> None:
    (tmp_path / "folder.pnml").mkdir()
    before = sorted(tmp_path.rglob("*"))
    result = run("convert", model, "-o", tmp_path / name)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(f"{tmp_path / name}: ")
    assert part in result.stderr
    assert result.stderr.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_format_that_cannot_hold_the_model_leaves_the_old_file(
    run: Run, model: Path, tmp_path: Path
) -> None:
    out = tmp_path / "out.net"
    out.write_text("old", encoding="utf-8")
    result = run("convert", model, "-o", out)
    assert result.exit_code == 2
    assert result.stderr.count("\n") == 1
    assert out.read_text(encoding="utf-8") == "old"
