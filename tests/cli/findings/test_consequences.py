"""Consequences in every format of a report; only causes count."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from dineros.metamodel import pn, sym
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.analysis.consequences.test_together import lamps
from tests.cli.conftest import Run
from tests.support.ros2_systems.waiting_models import awaiting_result

CAUSE = (
    "deadlock in node boss: timer callback OnTimer blocks for the result of action /act; the result needs "
    "the default callback group and the only thread, which OnTimer itself holds"
)
DEAD = "transition Go of node net boss can never fire"
LOST = "no client fetches the result if a goal of client boss of action /act ends as succeeded"


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Return the file of a model in which a callback waits for a result that needs its thread."""
    save(awaiting_result(), tmp_path / "act.sym.xmi")
    return tmp_path / "act.sym.xmi"


def test_text(run: Run, path: Path) -> None:
    result = run("check", path)
    assert result.exit_code == 1
    assert result.stdout.splitlines() == [
        f"error: {CAUSE} [6 steps] [callback-deadlock]",
        f"    consequence: {DEAD} [dead-transition]",
        f"    consequence: {LOST} [result-not-fetched]",
        f"{path}: 1 found (2 consequences), 3 proved, 0 unknown",
    ]


def test_json(run: Run, path: Path) -> None:
    findings = json.loads(run("check", path, "--json").stdout)["findings"]
    (finding,) = [each for each in findings if each["severity"] != "note"]
    assert [each["message"] for each in finding["consequences"]] == [DEAD, LOST]
    assert finding["consequences"][0]["elements"] == ["Go"]


def test_sarif_and_junit(run: Run, path: Path) -> None:
    (log,) = json.loads(run("check", path, "--format", "sarif").stdout)["runs"]
    (result,) = [each for each in log["results"] if each["level"] != "note"]
    related = [each for each in result["relatedLocations"] if "message" in each]
    assert [each["message"]["text"] for each in related] == [
        f"consequence: {DEAD} [dead-transition]",
        f"consequence: {LOST} [result-not-fetched]",
    ]
    assert related[0]["physicalLocation"]["region"]["startLine"] > 1
    suite = etree.fromstring(run("check", path, "--format", "junit").stdout.encode())
    assert suite.get("failures") == "1"
    assert f"consequence: {DEAD} [dead-transition]" in str(suite.findtext(".//failure"))


@pytest.mark.long
def test_a_report_folds_them(run: Run, path: Path) -> None:
    run("check", path, "-o", path.with_name("report.html"))
    page = path.with_name("report.html").read_text(encoding="utf-8")
    assert "<summary>2 consequences: they are gone if this is fixed</summary>" in page
    assert DEAD in page


def test_a_baseline_knows_them(run: Run, path: Path) -> None:
    """Where a cause is fixed by half, what was a consequence is not a new finding."""
    baseline = path.with_name("known.json")
    assert run("check", path, "--write-baseline", baseline).exit_code == 0
    rules = {each["rule"] for each in json.loads(baseline.read_text(encoding="utf-8"))["findings"]}
    assert {"callback-deadlock", "dead-transition", "result-not-fetched"} <= rules
    assert run("check", path, "--baseline", baseline).exit_code == 0


@pytest.mark.parametrize("format", ["json", "sarif"])
def test_a_report_as_a_baseline_knows_them(run: Run, path: Path, format: str) -> None:
    baseline = path.with_name(f"known.{format}")
    baseline.write_text(run("check", path, "--format", format).stdout, encoding="utf-8")
    assert run("check", path, "--baseline", baseline).exit_code == 0


def test_a_known_cause_hides_no_new_consequence(run: Run, path: Path) -> None:
    """What a baseline does not have is new, also if it follows from what the baseline has."""
    baseline = path.with_name("known.json")
    run("check", path, "--write-baseline", baseline)
    content = json.loads(baseline.read_text(encoding="utf-8"))
    content["findings"] = [each for each in content["findings"] if each["rule"] != "dead-transition"]
    baseline.write_text(json.dumps(content), encoding="utf-8")
    result = run("check", "-q", path, "--baseline", baseline)
    assert result.exit_code == 1
    assert [line for line in result.stdout.splitlines() if "note:" not in line] == [
        f"warning: {DEAD} [dead-transition]"
    ]


def test_consequences_of_a_suppressed_cause_count(run: Run, path: Path) -> None:
    """A suppression accepts findings of its rule, not all that follows from them."""
    model = awaiting_result()
    model.suppressions.append(pn.Suppression(rule="callback-deadlock", reason="known"))
    model.suppressions.append(pn.Suppression(rule="result-not-fetched", reason="known"))
    save(model, path)
    result = run("check", "-q", path)
    assert result.exit_code == 1
    assert f"warning: {DEAD} [dead-transition]" in result.stdout
    assert result.stdout.count("suppressed:") == 2


def test_a_suppressed_consequence_is_in_use(run: Run, path: Path) -> None:
    model = awaiting_result()
    find(model, "Go", sym.Transition).suppressions.append(
        pn.Suppression(rule="dead-transition", reason="known")
    )
    save(model, path)
    assert "suppresses nothing" not in run("check", path).stdout


def test_consequences_of_several_causes_name_the_others(run: Run, tmp_path: Path) -> None:
    path = tmp_path / "lamps.sym.xmi"
    save(lamps(2), path)
    lines = run("check", path).stdout.splitlines()
    first, second = (line.split(" can never")[0].removeprefix("error: ") for line in lines if line[0] == "e")
    place = lines.index(next(line for line in lines if "together with" in line))
    assert lines[place].startswith(f"    together with: {second}")
    assert (
        "        consequence: transition Shine1 of node net lamp1 can never fire [dead-transition]" in lines
    )
    assert lines.index(next(line for line in lines if line.startswith(f"error: {first}"))) < place
    cause = json.loads(run("check", path, "--json").stdout)["findings"][0]
    (shine,) = [each for each in cause["consequences"] if each["elements"] == ["Shine1"]]
    (other,) = shine["together"]
    assert other["rule"] == "unsatisfiable-clause"
    assert {cause["elements"][0], other["elements"][0]} == {"Dark1_1", "Dark1_2"}
    (log,) = json.loads(run("check", path, "--format", "sarif").stdout)["runs"]
    texts = [each["message"]["text"] for each in log["results"][0]["relatedLocations"] if "message" in each]
    name = other["elements"][0]
    assert [each for each in texts if "Shine1" in each] == [
        "consequence: transition Shine1 of node net lamp1 can never fire "
        f"(together with unsatisfiable-clause of {name}) [dead-transition]"
    ]
