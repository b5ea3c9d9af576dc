"""The commands `find`, `verify` and `reduce`: text, JSON and exit statuses."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.analysis.answers.budget import BudgetExceededError
from dineros.metamodel.files import load
from dineros.metamodel.records import Fire, Header, read_records
from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines, uses
from tests.support.programs.processes import run_apart

SORTING = Path(__file__).resolve().parents[3] / "case_study/sorting.sym.xmi"


class TestFind:
    def test_a_transition(self, run: Run, model: Path) -> None:
        result = run("find", model, "--enabled", "Listen")
        assert result.exit_code == 0
        assert lines(result)[0].startswith("reachable: enabled(Listen)")
        assert "signal Button becomes true" in result.stdout
        assert lines(result)[-1].endswith("  Listen")

    @uses("ends")
    def test_a_shortest_way_to_a_marking(self, run: Run, net: Path) -> None:
        result = run("find", net, "--marking", "b >= 2 & a >= 1")
        assert (result.exit_code, lines(result)[1:]) == (0, ["    1  t", "    2  t"])

    @uses("ends")
    def test_any_condition(self, run: Run, net: Path) -> None:
        result = run("find", net, "--marking", "deadlock | a == 0", "--json")
        assert result.exit_code == 0
        report = json.loads(result.stdout)
        assert list(report) == ["model", "goal", "status", "reason", "by", "states", "witness"]
        assert [step["transition"] for step in report["witness"]["steps"]] == ["t", "t", "t"]
        assert report["witness"]["steps"][0]["change"] == {"a": -1, "b": 1}

    @pytest.mark.parametrize("goal", [("--marking", "b >= 4"), ("--enabled", "u")])
    @uses("ends")
    def test_unreachable(self, run: Run, net: Path, goal: tuple[str, str], tmp_path: Path) -> None:
        output = tmp_path / "trace.json"
        result = run("find", net, *goal, "-o", output)
        assert result.exit_code == 1
        assert result.stdout.startswith("unreachable: ")
        assert not output.exists()

    @uses("large")
    def test_memory_leaves_it_unknown(self, net: Path) -> None:
        # Halves of tokens would do, so that no weighting of the places excludes it.
        many = ("--set", "a.tokens=400")
        result = run_apart("find", net, *many, "--marking", "2*a - 2*b == 1", "--memory", "322M")
        assert result.exit_code == 3
        assert result.stdout.startswith("unknown: 2*a - 2*b == 1 (memory")

    @pytest.mark.parametrize(
        ("goal", "steps"),
        [
            ("a == 0 | b >= 2", 2),
            ("!(a >= 1) | deadlock", 3),
            ("!(a >= 1 & b <= 1)", 2),
            ("enabled(t) & b >= 1", 1),
            ("!enabled(t)", 3),
            ("!deadlock", 0),
        ],
    )
    @uses("ends")
    def test_conditions_are_searched_for_in_order_of_distance(
        self, run: Run, net: Path, goal: str, steps: int
    ) -> None:
        result = run("find", net, "--marking", goal, "--json")
        assert len(json.loads(result.stdout)["witness"]["steps"]) == steps

    @uses("grows")
    def test_a_disjunction_in_an_unbounded_net(self, run: Run, net: Path) -> None:
        result = run("find", net, "--marking", "b >= 20 | a == 0")
        _, *shown = lines(result)
        assert (result.exit_code, shown) == (0, ["  the next step 20 times, up to step 20:", "    1  t"])

    @uses("grows")
    def test_what_no_marking_of_an_unbounded_net_can_hold(self, net: Path) -> None:
        result = run_apart("find", net, "--marking", "a >= 2 | a - b >= 2", "--memory", "322M")
        assert result.exit_code == 1
        assert result.stdout.startswith("unreachable: ")

    @uses("grows")
    def test_what_structure_excludes_in_an_unbounded_net(self, net: Path) -> None:
        result = run_apart("-v", "find", net, "--marking", "a + b < 1", "--memory", "322M")
        assert result.exit_code == 1
        assert result.stdout.startswith("unreachable: ")
        assert "answered by: state equation; 1 weighting" in result.stderr

    @pytest.mark.long
    @uses("grows")
    def test_what_stays_unknown_in_an_unbounded_net(self, net: Path) -> None:
        result = run_apart("find", net, "--marking", "2*b - 2*a == 1", "--memory", "322M")
        assert result.exit_code == 3
        assert "(the net is unbounded, and memory ran out)" in result.stdout

    @pytest.mark.parametrize("goal", [("--marking", "b >= 2"), ("--enabled", "t"), ("--marking", "deadlock")])
    @uses("ends")
    def test_depth_first_finds_the_same(self, run: Run, net: Path, goal: tuple[str, str]) -> None:
        shown = [
            lines(run("find", net, *goal, "--search", order)) for order in ("depth-first", "breadth-first")
        ]
        assert shown[0] == shown[1]

    @uses("ends")
    def test_the_trace_goes_to_a_file(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "trace.jsonl"
        result = run("find", net, "--enabled", "t", "-o", output)
        assert (result.exit_code, lines(result)[1:]) == (0, [f"{net} -> {output}: 1 step"])
        header, step = read_records(output)
        assert isinstance(header, Header)
        assert (header.kind, header.property, header.verdict) == ("witness", "enabled(t)", "reachable")
        assert (header.marking, header.signals, header.source) == ({"a": 3}, None, str(net))
        assert isinstance(step, Fire)
        assert (step.transition, step.change, step.text) == ("t", {"a": -1, "b": 1}, "t")

    @pytest.mark.parametrize(
        ("arguments", "says"),
        [
            ([], "give either --enabled or --marking"),
            (["--enabled", "t", "--marking", "b >= 1"], "give either --enabled or --marking"),
            (["--enabled", "nix"], "--enabled: no transition is named 'nix'"),
            (["--marking", "a >= 1 & nix >= 1"], "--marking, column 10: no place is named 'nix'"),
            (["--marking", "F b >= 1"], "--marking, column 1: the temporal operator F is not allowed here"),
            (["--marking", "b >="], "--marking, column 5: the formula ends too early"),
        ],
    )
    @uses("ends")
    def test_wrong_use(self, run: Run, net: Path, arguments: list[str], says: str) -> None:
        assert is_one_line_of_wrong_use(run("find", net, *arguments), says)


class TestVerify:
    @pytest.mark.parametrize(("logic", "formula"), [("--ltl", "F b >= 3"), ("--ctl", "AF (b >= 3)")])
    @uses("ends")
    def test_holds(self, run: Run, net: Path, logic: str, formula: str) -> None:
        result = run("verify", net, logic, formula)
        assert result.exit_code == 0
        assert result.stdout.startswith(f"holds: {formula}; 4 states, ")

    @uses("cycle")
    def test_a_violation_is_a_run_for_ever(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G F fired(stop)")
        assert result.exit_code == 1
        assert lines(result)[-4] == "  forever:"
        assert lines(result)[-3].endswith("  wait")
        assert lines(result)[-2] == "  enabled forever, never fired (--fair leaves such runs out): start"
        assert lines(result)[-1] == "  only unfair runs violate it: it holds with --fair start"
        result = run("verify", net, "--ltl", "G F fired(stop)", "--json")
        assert json.loads(result.stdout)["holds_if_fair"] == {"weak": ["start"], "strong": []}

    @uses("cycle")
    def test_a_run_up_to_the_fault(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G (busy = 0)")
        assert (result.exit_code, lines(result)[1:]) == (1, ["    1  start"])

    @uses("cycle")
    def test_groups_of_fair_transitions(self, run: Run, net: Path) -> None:
        assert run("verify", net, "--ltl", "G F fired(stop)", "--fair", "all").exit_code == 0
        result = run("verify", net, "--ltl", "G F fired(stop)", "--fair", "all-but:start", "--json")
        assert result.exit_code == 1
        assert json.loads(result.stdout)["unfair"] == {"weakly": ["start"], "strongly": []}

    @uses("ends")
    def test_a_run_that_ends_stays_there(self, run: Run, net: Path) -> None:
        result = run("verify", net, "--ltl", "G F fired(t)")
        assert result.exit_code == 1
        assert lines(result)[-4:] == [
            "    1  t",
            "    2  t",
            "    3  t",
            "  then no transition is enabled",
        ]

    @pytest.mark.parametrize("option", ["--fair", "--strongly-fair"])
    @uses("cycle")
    def test_fairness(self, run: Run, net: Path, option: str) -> None:
        assert run("verify", net, "--ltl", "G F fired(stop)", option, "start").exit_code == 0

    @uses("ends")
    def test_json_and_a_trace(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "trace.jsonl"
        result = run("verify", net, "--ctl", "AG b <= 1", "--json", "-o", output)
        assert result.exit_code == 1
        report = json.loads(result.stdout)
        keys = ["model", "formula", "status", "reason", "by", "states", "seconds", "witness", "unfair"]
        assert list(report) == keys
        assert (report["status"], report["formula"]) == ("violated", "AG b <= 1")
        assert [step["transition"] for step in report["witness"]["steps"]] == ["t", "t"]
        records = list(read_records(output))
        assert [record.sequence for record in records] == [0, 1, 2]
        assert all(isinstance(record, Fire) for record in records[1:])

    @uses("cycle")
    def test_the_loop_of_a_trace(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "trace.jsonl"
        assert run("verify", net, "--ltl", "G F fired(stop)", "-o", output).exit_code == 1
        header, *steps = read_records(output)
        assert isinstance(header, Header)
        assert header.loop is not None
        assert [step.transition for step in steps if step.sequence >= header.loop] == ["wait"]  # type: ignore[attr-defined]

    @pytest.mark.long
    @pytest.mark.parametrize(
        "limit",
        [("--memory", "322M", "--set", "a.tokens=400"), ("--timeout", "5", "--set", "a.tokens=100000")],
    )
    @pytest.mark.parametrize("formula", [("--ltl", "G 2*a - 2*b != 1"), ("--ctl", "AG EF (a + c <= 100)")])
    @uses("large")
    def test_limits_leave_it_unknown(
        self, net: Path, limit: tuple[str, ...], formula: tuple[str, str]
    ) -> None:
        result = run_apart("verify", net, *formula, *limit)
        assert result.exit_code == 3
        assert result.stdout.startswith("unknown: ")
        assert f"({'memory' if limit[0] == '--memory' else 'time'} ran out" in result.stdout

    @pytest.mark.parametrize(
        ("formula", "status"), [("AG b <= 1", "violated"), ("EF b >= 2", "holds")], ids=["AG", "EF"]
    )
    @uses("ends")
    def test_an_answer_stands_without_a_run(
        self, run: Run, net: Path, formula: str, status: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        def path(*_: object) -> None:
            raise BudgetExceededError("time ran out")

        monkeypatch.setattr("dineros.analysis.logic.ctl.explicit_sets.ExplicitSets.path", path)
        output = tmp_path / "trace.jsonl"
        result = run("verify", net, "--ctl", formula, "-o", output)
        reason = "no run that shows it was found: time ran out"
        assert result.exit_code == (1 if status == "violated" else 0)
        assert result.stdout.startswith(f"{status}: {formula} ({reason}); 4 states, ")
        assert (len(lines(result)), result.stderr) == (
            1,
            f"{output} is not written: there is no run to show\n",
        )
        assert not output.exists()
        report = json.loads(run("verify", net, "--ctl", formula, "--json").stdout)
        assert (report["status"], report["reason"], report["witness"]) == (status, reason, None)

    @pytest.mark.parametrize(
        ("arguments", "says"),
        [
            ([], "give either --ltl or --ctl"),
            (["--ltl", "G a >= 0", "--ctl", "AG a >= 0"], "give either --ltl or --ctl"),
            (["--ctl", "AG a >= 0", "--fair", "t"], "--fair requires --ltl"),
            (["--ltl", "G a >= 0", "--fair", "nix"], "--fair: no transition is named 'nix'"),
            (["--ltl", "G (a >= 0"], "--ltl, column 10: the formula ends too early"),
            (["--ltl", "G a"], "--ltl, column"),
            (["--ltl", "AG a >= 0"], "--ltl, column 1: the quantifier A belongs to CTL (use --ctl)"),
            (["--ctl", "AG fired(t)"], "--ctl, column 10: fired(t) is about a step"),
            (["--ltl", "G nix >= 0"], "--ltl, column 3: no place is named 'nix'"),
            (["--ltl", "G a >= 0", "--timeout", "0"], "--timeout"),
        ],
    )
    @uses("ends")
    def test_wrong_use(self, run: Run, net: Path, arguments: list[str], says: str) -> None:
        assert is_one_line_of_wrong_use(run("verify", net, *arguments), says)

    def test_names_are_those_of_the_system_model(self, run: Run, model: Path) -> None:
        fair = ["--strongly-fair", "Say"]
        assert run("verify", model, "--ltl", "F G !enabled(Say)", *fair).exit_code == 0
        assert run("verify", model, "--ltl", "G !signal(Button)").exit_code == 1

    @pytest.mark.long
    def test_scenario_4_of_the_paper(self, run: Run) -> None:
        none = ["--signals", "none"]
        assert run("verify", SORTING, *none, "--ctl", "AG EF (Shown >= 3)").exit_code == 0
        result = run("verify", SORTING, *none, "--ltl", "G (PickReqL >= 1 -> F PickResL >= 1)")
        assert result.exit_code == 1
        loop = result.stdout.partition("  forever:\n")[2].partition("  enabled forever")[0]
        assert "TSense" in loop
        assert "Pick" not in loop


class TestReduce:
    @pytest.mark.parametrize("suffix", ["net", "pnml", "xmi"])
    def test_the_smaller_net_loads_again(self, run: Run, model: Path, tmp_path: Path, suffix: str) -> None:
        output = tmp_path / f"small.{suffix}"
        result = run("reduce", model, "--signals", "none", "-o", output)
        assert result.exit_code == 0
        assert lines(result)[-1].startswith(f"{model} -> {output}: ")
        assert load(output).pages
        small, whole = (
            json.loads(run("statespace", file, "--signals", "none", "--reduce", "--json").stdout)["states"]
            for file in (output, model)
        )
        assert small == whole

    @uses("ends")
    def test_json_names_the_steps(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "small.net"
        result = run("reduce", net, "-o", output, "--json", "--preserve", "deadlocks")
        assert result.exit_code == 0
        report = json.loads(result.stdout)
        assert list(report) == ["model", "places", "transitions", "steps", "reason"]
        assert report["places"][0] == 3
        assert report["places"][1] < 3
        assert {"rule": "DeadTransition", "elements": ["u"]}.items() <= report["steps"][0].items()
        assert all("deadlocks" in step["preserves"] for step in report["steps"])

    @uses("ends")
    def test_markings_say_what_they_stand_for(self, run: Run, net: Path, tmp_path: Path) -> None:
        states = json.loads(run("statespace", net, "--json").stdout)["states"]
        arguments = ("reduce", net, "-o", tmp_path / "small.net", "--preserve", "markings")
        stand_for = json.loads(run(*arguments, "--json").stdout)["markings"]
        assert stand_for["factor"] == 1
        ((place, parts),) = stand_for["merged"].items()
        assert (place, parts, states) == ("a+b", 2, 4)  # three tokens
        assert "   2 places: a+b" in lines(run(*arguments))

    @uses("ends")
    def test_what_is_kept_stays(self, run: Run, net: Path, tmp_path: Path) -> None:
        output = tmp_path / "small.net"
        assert run("reduce", net, "-o", output).exit_code == 0
        assert "pl b" not in output.read_text("utf-8")
        assert run("reduce", net, "-o", output, "--keep", "b", "--keep", "t").exit_code == 0
        text = output.read_text("utf-8")
        assert "b" in text.split()
        assert "tr t " in text

    @pytest.mark.parametrize(
        ("arguments", "says"),
        [
            (["--keep", "bb"], "--keep: no place or transition is named 'bb' (did you mean 'b'?)"),
            (["--preserve", "colours"], "--preserve"),
        ],
    )
    @uses("ends")
    def test_wrong_use(self, run: Run, net: Path, tmp_path: Path, arguments: list[str], says: str) -> None:
        output = tmp_path / "small.net"
        assert is_one_line_of_wrong_use(run("reduce", net, "-o", output, *arguments), says)
        assert not output.exists()
