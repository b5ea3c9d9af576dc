"""Reports of checks as pages."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from pathlib import Path

from dineros.metamodel.files import load
from dineros.views.reports.check_report import CheckContent, FindingEntry, check_page
from dineros.views.traces.coding import TraceCoder
from tests.views.browser import Visit
from tests.views.samples import CASE_STUDY, lasso
from tests.views.traces.test_building import built

NewVisit = Callable[..., Visit]


@cache
def report() -> str:
    builder = built(lasso())
    findings = [
        FindingEntry(
            "error",
            "queue-overflow",
            "queue <b>overflows</b>",
            ("LeftCellObjects", "ReqControlL"),
            TraceCoder(builder, "queue-overflow").snapshot(),
            [step.text for step in builder.steps],
            7,
        ),
        FindingEntry("warning", "deadlock", "one marking has no enabled transition", ("sorting",)),
    ]
    space = {
        "signals": "none",
        "places": 149,
        "transitions": 127,
        "states": 330112,
        "arcs": 1349704,
        "deadlocks": 0,
        "seconds": 1.25,
        "peak_memory_bytes": 130 << 20,
        "complete": True,
        "error": "",
    }
    given_up = {**space, "signals": "io-enabled", "states": None, "complete": False, "error": "time"}
    content = CheckContent(
        "sorting",
        "sorting.sym.xmi",
        findings,
        ["every clause can be true"],
        ["liveness: memory"],
        [space, given_up],
        ["RedObjects.tokens=2"],
    )
    page, failure = check_page(content, load(CASE_STUDY))
    assert failure is None
    return page


def test_a_report_shows_verdicts_pictures_and_figures(tmp_path: Path, visit: NewVisit) -> None:
    file = tmp_path / "report.html"
    file.write_text(report(), encoding="utf-8")
    one = visit(offline=True, color_scheme="light")
    one.page.goto(file.as_uri())
    assert one.requested == [file.as_uri()]
    said = one.page.inner_text("body")
    for text in (
        "✗ 1 error",
        "▲ 1 warning",
        "✓ 1 proved",
        "? 1 unknown",
        "queue <b>overflows</b>",
        "liveness: memory",
        "330,112",
        "1,349,704",
        "unknown: time",
        "--set RedObjects.tokens=2",
    ):
        assert text in said, text
    finding = one.page.locator("article.error")
    assert finding.locator(".net .on-light [data-id=ReqControlL].marked").is_visible()
    assert finding.locator(".trace .on-light g.lane").count() > 4
    assert not finding.locator(".trace .on-dark").is_visible()
    paper = "element => getComputedStyle(element).fill"  # each theme has its own style, though both are there
    colours = [finding.locator(f".net .on-{theme} .paper").evaluate(paper) for theme in ("light", "dark")]
    assert colours[0] == "rgb(255, 255, 255)" != colours[1]
    frames = finding.locator(".trace .on-light svg svg").all()  # of lanes: as wide as the picture says
    assert frames and all(
        frame.evaluate("frame => !getComputedStyle(frame).minWidth.includes('800')") for frame in frames
    )
    one.page.emulate_media(color_scheme="dark")
    assert finding.locator(".trace .on-dark").is_visible()
    one.page.click("summary")
    assert finding.locator("ol li").count() == 9
    assert "Steps 8 to 9 repeat forever" in finding.inner_text()


def test_pictures_of_both_themes_and_of_all_findings_keep_apart(tmp_path: Path, visit: NewVisit) -> None:
    file = tmp_path / "report.html"
    file.write_text(report(), encoding="utf-8")
    page = visit().page
    page.goto(file.as_uri())
    ids = page.eval_on_selector_all("[id]", "found => found.map((one) => one.id)")
    assert len(ids) == len(set(ids))
    assert page.locator("svg [id]").count() == 0  # what other pictures could refer to
    styles = page.eval_on_selector_all("svg style", "found => found.map((one) => one.textContent)")
    for style in styles:
        rules = [rule.partition("{")[0] for rule in style.split("}") if rule]
        theme = rules[0].split()[0]
        assert all(part.strip().startswith(theme) for rule in rules for part in rule.split(",")), rules
    assert {style.split()[0] for style in styles} == {".net-light", ".net-dark"}


def test_a_finding_about_the_whole_model_has_no_picture_of_a_part() -> None:
    assert report().count('class="net"><figcaption>') == 1


def test_steps_that_repeat_are_listed_once() -> None:
    steps = ["begin", *["ask", "answer"] * 6, "end", *["wait"] * 5]
    rounds = FindingEntry("error", "rule", "message", steps=steps, loop=14).rounds
    assert [each[:5] for each in rounds] == [
        (1, 1, ["begin"], 1, False),
        (2, 13, ["ask", "answer"], 6, False),
        (14, 14, ["end"], 1, False),
        (15, 19, ["wait"], 5, True),
    ]
    listed = [step for each in rounds for step in each.steps * each.times]
    assert listed == steps
    entry = FindingEntry("error", "rule", "message", steps=steps, loop=14)
    page, _ = check_page(CheckContent("m", "m.sym.xmi", [entry], [], []))
    text = re.sub("<[^>]*>", "", page)
    assert text.count("answer") == 1 and "The next 2 steps 6 times, up to step 13:" in text
    assert '<ol start="14">' in page and "Steps 15 to 19 repeat forever." in page
