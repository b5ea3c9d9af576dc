"""Suppressions and baselines on the command line, in every format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from lxml import etree

from dineros.metamodel import sym
from dineros.metamodel.build import suppress
from dineros.metamodel.elements import find
from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines
from tests.support.systems.talker import talker

REASON = "the listener is <only> a logger"


def greeting(path: Path, until: str | None = None, limit: int = 1, accept: bool = True) -> Path:
    """Write a model with an overflow and a deadlock, the overflow accepted."""
    model = talker()
    (channel,) = model.channels
    assert isinstance(channel, sym.TopicChannel)
    channel.subscribers[0].limit = limit
    if accept:
        suppress(find(model, "Heard"), "queue-overflow", REASON, until)
        suppress(model, "deadlock", "the pool runs empty")
    save(model, path)
    return path


@pytest.fixture
def accepted(tmp_path: Path) -> Path:
    return greeting(tmp_path / "accepted.sym.xmi", "2999-12-31")


@pytest.fixture
def faulty(tmp_path: Path) -> Path:
    return greeting(tmp_path / "faulty.sym.xmi", accept=False)


def test_text_lists_what_is_suppressed_with_its_reason(run: Run, accepted: Path) -> None:
    result = run("check", accepted)
    assert result.exit_code == 0, result.output
    (overflow,) = [line for line in lines(result) if "[queue-overflow]" in line]
    assert overflow.startswith("suppressed: ")
    assert overflow.endswith(f"{REASON} (until 2999-12-31)")
    assert lines(result)[-1].endswith("0 unknown, 2 suppressed")


def test_after_the_last_day_it_counts_again(run: Run, tmp_path: Path) -> None:
    result = run("check", greeting(tmp_path / "late.sym.xmi", "2020-02-29"))
    assert result.exit_code == 1
    assert any(line.startswith("error:") and "[queue-overflow]" in line for line in lines(result))
    assert any("expired on 2020-02-29" in line and REASON in line for line in lines(result))


def test_one_that_suppresses_nothing_is_named(run: Run, tmp_path: Path) -> None:
    result = run("check", greeting(tmp_path / "large.sym.xmi", limit=10))
    assert result.exit_code == 0, result.output
    (named,) = [line for line in lines(result) if "[suppression-unused]" in line]
    assert "place 'Heard'" in named


def test_a_wrong_day_is_refused_with_its_line(run: Run, tmp_path: Path) -> None:
    path = greeting(tmp_path / "wrong.sym.xmi", "next week")
    result = run("check", path)
    number = next(n for n, line in enumerate(path.read_text().splitlines(), 1) if "next week" in line)
    assert result.exit_code == 2
    assert f"{path}:{number}: " in result.output
    assert "'next week', which is not a date" in result.output


def test_json_sarif_junit_and_html_have_them(run: Run, accepted: Path, tmp_path: Path) -> None:
    said = json.loads(run("check", accepted, "--json").stdout)
    assert "queue-overflow" not in [each["rule"] for each in said["findings"]]
    (overflow,) = [each for each in said["suppressed"] if each["rule"] == "queue-overflow"]
    assert overflow["suppression"] == {"element": "Heard", "reason": REASON, "until": "2999-12-31"}
    assert overflow["witness"]["steps"]

    (log,) = json.loads(run("check", accepted, "--format", "sarif").stdout)["runs"]
    (shown,) = [each for each in log["results"] if each["ruleId"] == "queue-overflow"]
    (suppression,) = shown["suppressions"]
    assert (suppression["kind"], suppression["status"]) == ("inSource", "accepted")
    assert suppression["justification"].startswith(REASON)
    assert suppression["location"]["physicalLocation"]["region"]["startLine"] > 1
    assert "baselineState" not in shown
    assert [each.get("suppressions") for each in log["results"] if each["level"] != "note"].count(None) == 0

    (suite,) = etree.fromstring(run("check", accepted, "--format", "junit").stdout.encode())
    (case,) = [each for each in suite if each.get("classname") == "dineros.queue-overflow"]
    assert case[0].tag == "skipped"
    assert REASON in case[0].get("message", "")
    assert (suite.get("failures"), suite.get("skipped")) == ("0", "2")

    page = tmp_path / "report.html"
    assert run("check", accepted, "-o", page).exit_code == 0
    assert "suppressed: the listener is &lt;only&gt; a logger (until 2999-12-31)" in page.read_text()


@pytest.mark.parametrize("format", ["baseline", "json", "sarif"])
def test_only_what_is_new_counts(run: Run, faulty: Path, tmp_path: Path, format: str) -> None:
    known = tmp_path / "known.json"
    if format == "baseline":
        first = run("check", faulty, "--write-baseline", known)
        assert first.exit_code == 0, first.output
        assert lines(first)[-1].endswith("known")
    else:
        first = run("check", faulty, "--format", format)
        assert first.exit_code == 1
        known.write_text(first.stdout)
    renamed = tmp_path / "renamed.sym.xmi"
    faulty.rename(renamed)
    again = run("check", renamed, "--baseline", known)
    assert again.exit_code == 0, again.output
    assert [line for line in lines(again) if line.startswith(("error", "warning"))] == []
    fuller = run("check", renamed, "--baseline", known, "--set", "Chatter.publisher.Said.limit=1")
    assert fuller.exit_code == 1
    (new,) = [line for line in lines(fuller) if line.startswith(("error", "warning"))]
    assert new.startswith("error: publisher queue of Said")


def test_what_is_no_longer_found_is_counted(run: Run, faulty: Path, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    run("check", faulty, "--write-baseline", known)
    fixed = run("check", faulty, "--baseline", known, "--set", "Chatter.subscriber.Heard.limit=9")
    assert fixed.exit_code == 0
    assert "1 finding of the baseline no longer found" in lines(fixed)[-1]


def test_json_and_sarif_say_what_is_new_and_known(run: Run, faulty: Path, tmp_path: Path) -> None:
    known = tmp_path / "known.json"
    run("check", faulty, "--write-baseline", known)
    change = ("--baseline", known, "--set", "Chatter.publisher.Said.limit=1")
    said = json.loads(run("check", faulty, *change, "--json").stdout)
    assert [each["elements"] for each in said["findings"]] == [["Chatter", "Said"]]
    assert {"queue-overflow", "deadlock"} <= {each["rule"] for each in said["known"]}
    (log,) = json.loads(run("check", faulty, *change, "--format", "sarif").stdout)["runs"]
    states = {(each["ruleId"], each["locations"][0]["logicalLocations"][-1]["name"]): each["baselineState"]
              for each in log["results"]}  # fmt: skip
    assert states["queue-overflow", "Said"] == "new"
    assert states["queue-overflow", "Heard"] == "unchanged"
    assert set(states.values()) == {"new", "unchanged"}


@pytest.mark.parametrize("content", ["", "[", "7", "{}", '{"findings": [{"rule": 5}]}', '{"runs": [3]}'])
def test_no_baseline_is_one_line(run: Run, faulty: Path, tmp_path: Path, content: str) -> None:
    (known := tmp_path / "known.json").write_text(content)
    assert is_one_line_of_wrong_use(run("check", faulty, "--baseline", known), "known.json")


def test_wrong_use_of_baselines(run: Run, faulty: Path, tmp_path: Path) -> None:
    for option, file, words in (
        ("--baseline", tmp_path / "none.json", "none.json"),
        ("--write-baseline", tmp_path / "none" / "known.json", "there is no folder"),
        ("--write-baseline", faulty, "not a format of a baseline"),
    ):
        before = faulty.read_bytes()
        assert is_one_line_of_wrong_use(run("check", faulty, option, file), words)
        assert faulty.read_bytes() == before
    assert run("check", faulty, "--suggest-capacities", "--baseline", faulty).exit_code == 2
