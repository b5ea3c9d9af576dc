"""``dineros view``, and ``dineros convert`` into pictures."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from dineros.cli.outputs import PICTURES
from dineros.metamodel import pn
from dineros.metamodel.files import save
from dineros.views.nets import FORMATS
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use
from tests.support.systems.talker import talker

STARTS = {".svg": b"<svg ", ".png": b"\x89PNG", ".html": b"<!DOCTYPE html>"}


@pytest.mark.parametrize("command", ["view", "convert"])
@pytest.mark.parametrize("suffix", FORMATS)
def test_it_writes_pictures(run: Run, model: Path, tmp_path: Path, command: str, suffix: str) -> None:
    out = tmp_path / f"picture{suffix}"
    result = run(command, model, "-o", out)
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"{model} -> {out}\n", "")
    assert out.read_bytes().startswith(STARTS[suffix])


def test_the_command_line_knows_all_formats() -> None:
    assert PICTURES == FORMATS


def test_settings_change_the_picture(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "picture.svg"
    assert run("convert", model, "-o", out, "--set", "Words.tokens=77").exit_code == 0
    assert ">77<" in out.read_text(encoding="utf-8")


def test_only_the_neighbourhood(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "picture.svg"
    assert run("view", model, "--around", "Listen", "--steps", "1", "-o", out).exit_code == 0
    text = out.read_text(encoding="utf-8")
    assert 'data-id="Noted"' in text
    assert 'data-id="Chatter"' not in text


def test_collapsed_pages_badges_and_colours(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "picture.svg"
    result = run("view", model, "--collapse", "listener", "--badge", "Words=3", "--theme", "dark", "-o", out)
    assert result.exit_code == 0
    text = out.read_text(encoding="utf-8")
    assert 'class="box node collapsed" data-id="listener"' in text
    assert 'data-id="Heard"' not in text
    assert 'class="badge"' in text
    assert "#10161f" in text


@pytest.mark.parametrize("command", ["view", "convert"])
def test_large_models_are_shown_collapsed(run: Run, tmp_path: Path, command: str) -> None:
    model, out = tmp_path / "large.pnml", tmp_path / "picture.svg"
    large, small = pn.Page(id="large"), pn.Page(id="small", objects=[pn.Place(id="only")])
    large.objects.extend([pn.Place(id=f"p{number}") for number in range(151)])
    save(pn.Net(id="net", pages=[large, small]), model)
    assert run(command, model, "-o", out).exit_code == 0
    text = out.read_text(encoding="utf-8")
    assert 'data-id="large"' in text
    assert 'data-id="p1"' not in text
    assert 'data-id="only"' not in text
    if command == "view":
        assert run("view", model, "--expand", "small", "-o", out).exit_code == 0
        text = out.read_text(encoding="utf-8")
        assert 'data-id="only"' in text
        assert 'data-id="p1"' not in text
        assert run("view", model, "--expand", "all", "-o", out).exit_code == 0
        assert 'data-id="p1"' in out.read_text(encoding="utf-8")


def test_two_models(run: Run, model: Path, tmp_path: Path) -> None:
    other, out = tmp_path / "other.sym.xmi", tmp_path / "picture.svg"
    changed = talker()
    changed.pages[0].objects[0].tokens = 5  # type: ignore[attr-defined]
    save(changed, other)
    assert run("view", other, "--compare", model, "-o", out).exit_code == 0
    assert 'class="place changed" data-id="Words"' in out.read_text(encoding="utf-8")


def test_without_a_file_the_browser_opens(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    opened: list[str] = []

    def opener(address: str) -> bool:
        opened.append(address)
        return True

    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr("webbrowser.open", opener)
    result = run("view", model)
    assert result.exit_code == 0
    (page,) = tmp_path.glob("dineros-greeting-*.html")
    assert opened == [page.as_uri()]
    assert result.stdout == f"{model} -> {page}\n"
    monkeypatch.setattr("webbrowser.open", lambda address: False)
    assert "no browser found" in run("view", model).stdout


def test_nothing_is_left_when_drawing_fails(
    run: Run, model: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setitem(sys.modules, "resvg_py", None)
    before = sorted(tmp_path.iterdir())
    result = run("view", model, "-o", tmp_path / "picture.png")
    assert is_one_line_of_wrong_use(result, "PNG needs the package resvg-py (pip install 'dineros[view]')")
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "part"),
    [
        (["-o", "out.gif"], "known are .svg, .png, .html"),
        (["-o", "no/folder/out.svg"], "create the folder first"),
        (["-o", "out.svg", "--around", "Lsten"], "did you mean 'Listen'"),
        (["-o", "out.svg", "--collapse", "listner"], "did you mean 'listener'"),
        (["-o", "out.svg", "--badge", "Listen"], "is not ELEMENT=TEXT"),
        (["-o", "out.svg", "--badge", "nobody=1"], "shows no 'nobody'"),
        (["-o", "out.svg", "--steps", "-1"], "steps"),
        (["-o", "out.svg", "--compare", "nothing.xmi"], "nothing.xmi"),
    ],
)
def test_wrong_use(
    run: Run, model: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, arguments: list[str], part: str
) -> None:
    monkeypatch.chdir(tmp_path)
    assert is_one_line_of_wrong_use(run("view", model, *arguments), part)
    assert not (tmp_path / "out.svg").exists()


def test_pictures_for_paper(run: Run, model: Path, tmp_path: Path) -> None:
    out = tmp_path / "figure.svg"
    result = run("view", model, "--width", "400", "--aspect", "4:1", "-o", out)
    assert (result.exit_code, result.stdout, result.stderr) == (0, f"{model} -> {out}\n", "")
    assert 'width="400mm" height="100mm"' in out.read_text(encoding="utf-8")


def test_a_model_that_is_too_large_for_the_paper(run: Run, model: Path, tmp_path: Path) -> None:
    result = run("view", model, "--width", "90", "-o", tmp_path / "figure.svg")
    assert result.exit_code == 0
    assert "is too large for 90 mm" in result.stderr
    assert "drawn separately" in result.stderr
    assert (tmp_path / "figure-talker.svg").is_file()
    refused = run("view", model, "--width", "20", "-o", tmp_path / "small.svg")
    assert is_one_line_of_wrong_use(refused, "it needs")
    assert not list(tmp_path.glob("small*"))


@pytest.mark.parametrize(
    "options",
    [
        ("--aspect", "4:3"),
        ("--width", "90", "--aspect", "wide"),
        ("--width", "90", "--aspect", "1:0"),
        ("--width", "90", "--aspect", "99:1"),
        ("--width", "5"),
    ],
)
def test_wrong_sizes_of_paper(run: Run, model: Path, tmp_path: Path, options: tuple[str, ...]) -> None:
    assert run("view", model, *options, "-o", tmp_path / "x.svg").exit_code == 2
    assert not (tmp_path / "x.svg").exists()


def test_a_width_is_of_paper_only(run: Run, model: Path, tmp_path: Path) -> None:
    assert run("view", model, "--width", "90", "-o", tmp_path / "x.html").exit_code == 2
