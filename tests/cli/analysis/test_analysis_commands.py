"""The commands `statespace` and `check`: what they print, as text and as JSON, and their exit statuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.symbolic.saturation import DiagramMemoryError
from tests.cli.conftest import Run
from tests.support.programs.commands import NETS, is_one_line_of_wrong_use, lines, uses
from tests.support.programs.processes import run_apart

SORTING = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"
KEYS = [
    "model",
    "signals",
    "overflow",
    "reduced",
    "places",
    "transitions",
    "states",
    "arcs",
    "deadlocks",
    "max_tokens_in_place",
    "max_tokens_in_marking",
    "engine",
    "complete",
    "reason",
    "seconds",
    "peak_memory_bytes",
]


class TestStatespace:
    def test_json_has_the_keys_of_the_contract(self, run: Run, model: Path) -> None:
        result = run("statespace", model, "--signals", "none", "--json")
        assert (result.exit_code, result.stderr) == (0, "")
        report = json.loads(result.stdout)
        assert list(report) == KEYS
        assert report["model"] == str(model)
        assert (report["signals"], report["overflow"], report["reduced"]) == ("none", "weighted", False)
        assert report["complete"] is True
        assert report["reason"] == ""
        assert report["seconds"] > 0
        assert report["peak_memory_bytes"] > 1 << 20

    @pytest.mark.parametrize("engine", ["explicit", "symbolic"])
    @uses("ends")
    def test_engines_count(self, run: Run, net: Path, engine: str) -> None:
        report = json.loads(run("statespace", net, "--engine", engine, "--json").stdout)
        counts = [report[key] for key in ("places", "transitions", "states", "arcs", "deadlocks")]
        assert counts == [3, 2, 4, 3, 1]
        assert [report[key] for key in KEYS[9:13]] == [3, 3, engine, True]
        assert (report["signals"], report["overflow"]) == (None, None)

    def test_text_has_a_line_for_each_figure(self, run: Run, model: Path) -> None:
        result = run("statespace", model, "--signals", "none", "--overflow", "inhibitor")
        assert result.exit_code == 0
        shown = {line[:22].strip(): line[23:] for line in lines(result)}
        assert (shown["overflow"], shown["complete"]) == ("inhibitor", "yes")
        assert shown["peak memory bytes"].endswith(" MiB")

    def test_signals_free_to_change_double_the_markings(self, run: Run, model: Path) -> None:
        none, fully = (
            json.loads(run("statespace", model, "--signals", signals, "--json").stdout)["states"]
            for signals in ("none", "fully-enabled")
        )
        assert fully == 2 * none

    def test_reduced_nets_of_both_are_the_same_size(self, run: Run, model: Path) -> None:
        whole = run("statespace", model, "--signals", "fully-enabled", "--json")
        reduced = [
            run("statespace", model, "--signals", signals, "--reduce", "--json")
            for signals in ("none", "fully-enabled")
        ]
        none, fully = (json.loads(result.stdout) for result in reduced)
        unreduced = json.loads(whole.stdout)
        assert none["reduced_states"] == fully["reduced_states"] < unreduced["states"]
        for figure in ("states", "deadlocks"):
            assert fully[figure] == unreduced[figure]
        assert [fully[key] for key in ("arcs", "max_tokens_in_place", "max_tokens_in_marking")] == [None] * 3
        text = run("statespace", model, "--signals", "fully-enabled", "--reduce").stdout
        assert f"states                 {unreduced['states']:,}\n" in text
        assert f"places                 {fully['places']} (of the reduced net)\n" in text
        assert "arcs" not in text

    @pytest.mark.parametrize("engine", ["auto", "explicit", "symbolic"])
    @uses("grows")
    def test_an_unbounded_net_is_incomplete(self, run: Run, net: Path, engine: str) -> None:
        result = run("statespace", net, "--engine", engine, "--json")
        assert result.exit_code == 3
        report = json.loads(result.stdout)
        assert report["complete"] is False
        assert "bound" in report["reason"]
        assert (report["states"], report["arcs"]) == (None, None)

    @uses("grows")
    def test_an_unbounded_net_shows_what_grows(self, run: Run, net: Path) -> None:
        result = run("statespace", net)
        assert result.exit_code == 3
        assert "unbounded: b can grow forever" in result.stdout
        found = lines(result)
        at = found.index("  forever:")
        assert found[at + 1 : at + 4] == [
            "    1  t",
            "without places that no transition takes from (b):",
            "  states                1",
        ]
        assert "states" not in "".join(found[:at])
        report = json.loads(run("statespace", net, "--json").stdout)
        assert (report["pumping"]["loop"], len(report["pumping"]["steps"])) == (0, 1)
        assert (report["rest"]["without"], report["rest"]["states"]) == (["b"], 1)

    @uses("ends")
    def test_depth_first_counts_the_same(self, run: Run, net: Path) -> None:
        orders = [["--search", order] for order in ("breadth-first", "depth-first")]
        reports = [
            json.loads(run("statespace", net, "--engine", "explicit", *order, "--json").stdout)
            for order in orders
        ]
        assert [[report[key] for key in KEYS[4:13]] for report in reports[:1]] == [
            [report[key] for key in KEYS[4:13]] for report in reports[1:]
        ]
        assert is_one_line_of_wrong_use(run("statespace", net, *orders[1]), "requires --engine explicit")

    @uses("ends")
    def test_without_tina_it_says_so(self, run: Run, net: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("PATH", "")
        result = run("statespace", net, "--engine", "tina")
        assert is_one_line_of_wrong_use(result, "tina is not on the PATH")

    @uses("large")
    def test_memory_ends_the_count(self, net: Path) -> None:
        result = run_apart("statespace", net, "--engine", "explicit", "--memory", "322M", "--json")
        assert result.exit_code == 3
        report = json.loads(result.stdout)
        assert not report["complete"] and report["reason"].startswith("memory ran out after ")
        assert 0 < report["states"] < 1_373_701

    def test_an_invalid_model_is_refused(self, run: Run, broken: Path) -> None:
        assert is_one_line_of_wrong_use(run("statespace", broken), "is not valid")


class TestMemory:
    @pytest.mark.parametrize(
        ("value", "says"),
        [
            ("much", "is not an amount"),
            ("2X", "is not an amount"),
            ("0", "too little"),
            ("-1G", "too little"),
        ],
    )
    def test_what_is_no_amount_is_refused(self, run: Run, model: Path, value: str, says: str) -> None:
        assert is_one_line_of_wrong_use(run("statespace", model, f"--memory={value}"), says)

    @pytest.mark.long
    @pytest.mark.parametrize("value", ["1G", "1GiB", "0.5g", "700MB", "1073741824"])
    @uses("ends")
    def test_amounts_are_read(self, net: Path, value: str) -> None:
        assert run_apart("statespace", net, "--memory", value).exit_code == 0  # what pytest needs counts too


class TestCheck:
    @uses("cycle")
    def test_nothing_wrong(self, run: Run, net: Path) -> None:
        result = run("check", net)
        assert (result.exit_code, result.stdout) == (0, f"{net}: 0 found, 8 proved, 0 unknown\n")
        assert run("check", net, "-q").stdout == ""
        told = run("check", net, "-v").stderr
        assert "proved: no deadlock\n" in told
        assert "answered by: decision diagrams: all markings, made once for all questions\n" in told

    @uses("cycle")
    def test_behaviour(self, run: Run, net: Path) -> None:
        report = json.loads(run("check", net, "--json").stdout)
        assert any("is live" in text for text in report["proved"])
        assert any("is reversible" in text for text in report["proved"])

    @uses("cycle")
    def test_what_takes_too_long_is_unknown_in_every_format(
        self, run: Run, net: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setattr("dineros.analysis.checks.check.CHEAP", -1)
        monkeypatch.setattr("dineros.analysis.properties.recurrence.recurrence", lambda *_: None)
        left = "not decided, because it takes more work than a check may cost (--behaviour decides it)"
        unknown = f"liveness, reversibility, home markings: {left}"
        result = run("check", net)
        # At worst the answer would be a note, which does not change the status either.
        assert (result.exit_code, result.stdout) == (
            0,
            f"unknown: {unknown}\n{net}: 0 found, 5 proved, 1 unknown\n",
        )
        assert run("check", net, "-q").stdout == f"unknown: {unknown}\n"
        assert json.loads(run("check", net, "--json").stdout)["unknown"] == [unknown]
        for format in ("sarif", "junit"):
            result = run("check", net, "--format", format)
            assert (result.exit_code, unknown in result.stdout) == (0, True)
        run("check", net, "-o", tmp_path / "report.html")
        assert unknown in (tmp_path / "report.html").read_text(encoding="utf-8")
        result = run("check", net, "--behaviour")
        assert (result.exit_code, result.stdout) == (0, f"{net}: 0 found, 8 proved, 0 unknown\n")

    @uses("cycle")
    def test_what_was_asked_for_and_stays_unknown_gives_exit_status_3(
        self, run: Run, net: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def behaviour(*_: object) -> None:
            raise DiagramMemoryError("memory ran out")

        monkeypatch.setattr("dineros.analysis.properties.behaviour.behaviour", behaviour)
        for asked, status in (([], 0), (["--behaviour"], 3)):
            result = run("check", net, *asked)
            assert result.exit_code == status
            assert lines(result)[0] == "unknown: liveness, reversibility, home markings: memory ran out"

    @uses("ends")
    def test_notes_do_not_change_the_status(self, run: Run, net: Path) -> None:
        net.write_text(NETS["cycle"] + "pl once (1)\ntr leave once ->\n", encoding="utf-8")
        result = run("check", net, "-v")
        assert result.exit_code == 0
        notes = [line for line in result.stderr.splitlines() if line.startswith("note: ")]
        assert [line.rpartition("[")[2] for line in notes] == ["not-live]", "not-reversible]"]
        assert "0 found" in result.stdout

    @uses("ends")
    def test_dead_transition_and_deadlock(self, run: Run, net: Path) -> None:
        result = run("check", net)
        assert result.exit_code == 1
        assert lines(result)[0] == "warning: transition u can never fire [dead-transition]"
        assert "one marking has no enabled transition" in lines(result)[1]

    @uses("grows")
    def test_an_unbounded_net(self, run: Run, net: Path) -> None:
        result = run("check", net, "--witnesses")
        assert result.exit_code == 1
        assert lines(result)[:3] == [
            "error: tokens grow without bound: b [1 step] [unbounded]",
            "  forever:",
            "    1  t",
        ]

    def test_a_queue_that_overflows(self, run: Run, model: Path) -> None:
        result = run("check", model, "--set", "Chatter.subscriber.Heard.limit=2", "--json")
        assert result.exit_code == 1
        report = json.loads(result.stdout)
        assert list(report) == ["model", "findings", "proved", "unknown"]
        (finding,) = (found for found in report["findings"] if found["rule"] == "queue-overflow")
        assert list(finding) == ["rule", "severity", "elements", "message", "witness"]
        assert finding["elements"] == ["Chatter", "Heard"]
        assert finding["message"].startswith("subscriber queue of Heard (topic chatter) can overflow")
        last = finding["witness"]["steps"][-1]
        assert last["text"] == "subscriber queue of Heard (topic chatter) loses a message"
        assert finding["witness"]["loop"] is None
        assert "publisher queue of Said (topic chatter) never overflows" in report["proved"]

    def test_json_by_either_option(self, run: Run, model: Path) -> None:
        assert run("check", model, "--json").stdout == run("check", model, "--format", "json").stdout

    @pytest.mark.parametrize(("format", "start"), [("sarif", "{"), ("junit", "<?xml")])
    def test_formats_for_programs(self, run: Run, model: Path, format: str, start: str) -> None:
        result = run("check", model, "--format", format)
        assert (result.exit_code, result.stderr) == (0, "")  # the application finishes, which is a note
        assert result.stdout.startswith(start)
        assert "deadlock" in result.stdout

    def test_the_case_study_has_no_fault(self, run: Run) -> None:
        result = run("check", SORTING)
        assert (result.exit_code, result.stdout) == (0, f"{SORTING}: 0 found, 16 proved, 0 unknown\n")

    def test_scenario_2_of_the_paper(self, run: Run) -> None:
        result = run("check", SORTING, "--set", "TSense.clause=Sensor & !Sensor", "--json")
        assert result.exit_code == 1
        causes = json.loads(result.stdout)["findings"]
        assert ("unsatisfiable-clause", "TSense") in {(item["rule"], item["elements"][0]) for item in causes}
        consequences = [each for item in causes for each in item.get("consequences", [])]
        assert {(item["rule"], item["elements"][0]) for item in [*causes, *consequences]} >= {
            ("service-never-returns", "SensorService"),
            ("service-never-returns", "Pick"),
            ("service-never-called", "Place"),
            ("service-never-called", "EndControl"),
            ("unused-topic", "UITopic"),
        }

    @pytest.mark.parametrize(("limit", "overflows"), [(3, []), (2, [["UITopic", "Feedback"]])])
    def test_more_results_than_a_subscriber_keeps(
        self, run: Run, limit: int, overflows: list[list[str]]
    ) -> None:
        result = run("check", SORTING, "--set", f"UITopic.subscriber.Feedback.limit={limit}", "--json")
        findings = json.loads(result.stdout)["findings"]
        assert [item["elements"] for item in findings if item["rule"] == "queue-overflow"] == overflows
        assert result.exit_code == (1 if overflows else 0)


class TestCapacities:
    def test_text(self, run: Run, model: Path) -> None:
        result = run("check", model, "--suggest-capacities")
        assert (result.exit_code, lines(result)) == (
            0,
            [
                "publisher queue of Said (topic chatter): has 10, needs 3",
                "dispatcher queue of listener (topic chatter): has 16, needs 3",
                "subscriber queue of Heard (topic chatter): has 10, needs 3",
                f"{model}: 3 queues",
            ],
        )

    def test_a_queue_that_is_too_short(self, run: Run, model: Path) -> None:
        limit = "Chatter.subscriber.Heard.limit=2"
        result = run("check", model, "--set", limit, "--suggest-capacities", "--json")
        assert result.exit_code == 1
        (row,) = (
            row for row in json.loads(result.stdout)["capacities"] if row["elements"] == ["Chatter", "Heard"]
        )
        assert (row["limit"], row["needed"]) == (2, 3)
        assert row["witness"]["steps"][-1]["text"].endswith("loses a message")

    def test_witnesses(self, run: Run, model: Path) -> None:
        text = run("check", model, "--suggest-capacities", "--witnesses").stdout
        assert text.count(" loses a message\n") == 3

    @uses("ends")
    def test_a_plain_net_has_no_queues(self, run: Run, net: Path) -> None:
        assert is_one_line_of_wrong_use(run("check", net, "--suggest-capacities"), "has no queues")

    def test_only_text_and_json(self, run: Run, model: Path) -> None:
        result = run("check", model, "--suggest-capacities", "--format", "sarif")
        assert is_one_line_of_wrong_use(result, "with --format sarif")
