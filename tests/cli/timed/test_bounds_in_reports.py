"""Stored bounds of times in `check --time`: every format has the counterexample with its schedule."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.systems.talker import talker

TEXTS = {
    "soon": ("words", "fired(Say) leads to Noted >= 1 within 0.5"),
    "always": ("ltl", "G (fired(Say) -> F[<=0.5] Noted >= 1)"),
    "early": ("words", "never Noted >= 1 within 0.9"),
    "later": ("words", "never Noted >= 1 within 1"),
    "silent": ("ltl", "F[<=9] fired(Say)"),
}
VIOLATED = ("soon", "always", "later", "silent")
SHOWN = "Say, at 1 (from 1 to any time later)"
WORDS = "Noted &gt;= 1 does not come in [&lt;=1/2], counted from 1"


@pytest.fixture
def model(tmp_path: Path) -> Path:
    net = talker()
    find(net, "Say", sym.Transition).interval = pn.TimeInterval(earliest=1, latest=2)
    for id, (language, text) in TEXTS.items():
        net.properties.append(sym.Property(id=id, text=text, language=language))
    path = tmp_path / "talker.sym.xmi"
    save(net, path)
    return path


def test_text(run: Run, model: Path) -> None:
    shown = run("check", model, "--time", "--witnesses").stdout
    for id in TEXTS:
        assert (f"error: property {id} does not hold" in shown) == (id in VIOLATED)
    assert SHOWN in shown and "Noted >= 1 does not come in [<=1/2], counted from 1" in shown
    # Nothing fires in the run that violates it, so words show it.
    assert "F[<=9] fired(Say); fired(Say) does not come in [<=9]" in shown


def test_json(run: Run, model: Path) -> None:
    told = json.loads(run("check", model, "--time", "--json").stdout)
    found = {each["elements"][0]: each for each in told["findings"] if each["rule"] == "property-violated"}
    assert tuple(found) == VIOLATED
    for id in ("soon", "always"):
        last = found[id]["witness"]["steps"][-1]
        assert (last["transition"], last["time"]) == ("Say", {"at": 1.0, "earliest": 1.0, "latest": None})
    assert all(step["time"]["at"] <= 1 for step in found["later"]["witness"]["steps"])
    assert any(line.startswith("property early holds") for line in told["proved"])


def test_formats_of_other_tools(run: Run, model: Path) -> None:
    (log,) = json.loads(run("check", model, "--time", "--format", "sarif").stdout)["runs"]
    flows = [
        one["codeFlows"]
        for one in log["results"]
        if one["ruleId"] == "property-violated" and "codeFlows" in one
    ]
    assert len(flows) == 3 and SHOWN in json.dumps(flows)
    root = etree.fromstring(run("check", model, "--time", "--format", "junit").stdout.encode())
    text = etree.tostring(root, encoding="unicode")
    assert SHOWN in text and WORDS in text


@pytest.mark.long
def test_page(run: Run, model: Path, tmp_path: Path) -> None:
    page = tmp_path / "report.html"
    assert run("check", model, "--time", "-o", page).exit_code == 1
    text = page.read_text()
    assert "at 1 (from 1 to any time later)" in text and WORDS in text


def test_without_time_they_are_unknown(run: Run, model: Path) -> None:
    told = json.loads(run("check", model, "--json").stdout)
    open = [line for line in told["unknown"] if "which requires --time" in line]
    assert len(open) == len(TEXTS)
