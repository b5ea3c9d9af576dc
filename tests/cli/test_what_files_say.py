"""What files hold is shown on one line and steers no terminal: names, settings, formulas, property files."""

from __future__ import annotations

import json
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.analysis.evidence.certificate import sealed
from dineros.metamodel import pn
from dineros.metamodel.build import flow
from dineros.metamodel.errors import DinerosError, printable
from dineros.metamodel.files import save
from tests.cli.conftest import Run

NASTY = "a\nvalid: b\r\u009b31mc\u202ed\u2028e"
"""Two kinds of line break, a control sequence of one character, a mark of direction, a separator of lines."""

SHOWN = r"a\nvalid: b\r\x9b31mc\u202ed\u2028e"


@given(st.text())
def test_a_printed_text_is_a_line_without_controls(text: str) -> None:
    shown = printable(text)
    assert all(unicodedata.category(each) not in {"Cc", "Cf", "Zl", "Zp"} for each in shown.replace("\t", ""))
    assert len(shown.splitlines()) <= 1
    if all(unicodedata.category(each) not in {"Cc", "Cf", "Zl", "Zp"} for each in text):
        assert shown == text


def test_the_same_text_shows_where_it_is_an_error() -> None:
    assert printable(NASTY) == SHOWN
    assert str(DinerosError("\x1b]0;title\x07 x", hint=NASTY)).isprintable()


def test_a_setting_of_a_certificate_cannot_print_another_claim(run: Run, model: Path, tmp_path: Path) -> None:
    certificate = tmp_path / "c.json"
    assert run("verify", model, "--ltl", "G Noted <= 3", "--certificate", certificate).exit_code == 0
    written = json.loads(certificate.read_text())
    for lie in ("\nvalid: G Noted <= 0 holds in greeting.sym.xmi", " --signals none", "\r", "\x1b[2J"):
        written["settings"] = [f"Words.name=a{lie}"]
        certificate.write_text(json.dumps(sealed(written)))
        said = run("certify", model, certificate)
        lines = (said.stdout + said.stderr).splitlines()
        assert all(line.isprintable() for line in lines)
        if "\x1b" in lie:  # no model file can hold it
            assert (said.exit_code, len(lines)) == (2, 1)
            continue
        assert said.exit_code == 0
        assert lines[0].startswith("valid: G Noted <= 3 holds in ")
        assert f"'Words.name=a{printable(lie)}'" in lines[0]
        assert [line for line in lines[1:] if line.startswith("valid")] == []


@pytest.mark.parametrize(
    "command",
    [
        ("check",),
        ("check", "-v"),
        ("find", "--enabled", "t"),
        ("convert", "-o", "net.xmi"),
        ("validate",),
        ("check", "--json"),
        ("check", "--format", "junit"),
        ("check", "--format", "sarif"),
    ],
    ids=" ".join,
)
def test_names_steer_no_terminal(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: tuple[str, ...]
) -> None:
    monkeypatch.chdir(tmp_path)
    place = pn.Place(id="p", name=NASTY, tokens=1)
    grows = pn.Place(id="q", name=f"{NASTY} 2")
    step = pn.Transition(id="t", name=NASTY)
    net = pn.Net(id="n", name=NASTY, pages=[pn.Page(id="page", objects=[place, grows, step])])
    flow(place, step, place)
    flow(step, grows)
    file = tmp_path / "net.pnml"
    save(net, file)
    result = run(command[0], file, *command[1:])
    assert result.exit_code in (0, 1)
    for line in (result.stdout + result.stderr).splitlines():
        assert line.isprintable(), line
        assert not line.startswith("valid: b")
    if "sarif" in command:  # what a page shows of it has no lines of the file either
        told = json.loads(result.stdout)["runs"][0]["results"]
        assert told and all(each["message"]["text"].isprintable() for each in told)
    if "junit" in command:
        assert "&#10;" not in result.stdout and r"a\nvalid: b\r" in result.stdout
