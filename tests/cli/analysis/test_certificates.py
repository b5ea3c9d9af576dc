"""``--certificate`` of find, verify and check, and ``dineros certify``, through the command line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.cli.conftest import Run
from tests.support.programs.commands import is_one_line_of_wrong_use, lines, uses


@uses("cycle")
def test_a_certificate_is_written_and_checked(run: Run, net: Path, tmp_path: Path) -> None:
    file = tmp_path / "two.json"
    found = run("find", net, "--marking", "idle + busy >= 2", "--certificate", file)
    assert found.exit_code == 1
    assert lines(found) == [
        "unreachable: idle + busy >= 2 (by 1 weighting of places)",
        f"certificate: {file}",
    ]
    checked = run("certify", net, file)
    assert checked.exit_code == 0
    assert lines(checked) == [
        f"valid: idle + busy >= 2 is unreachable in {net}",
        "  1 weighting of places",
    ]


@uses("cycle")
def test_of_a_formula_and_as_json(run: Run, net: Path, tmp_path: Path) -> None:
    for number, (logic, formula, answer) in enumerate(
        [
            ("--ctl", "AG (idle + busy == 1)", "holds"),
            ("--ltl", "G !deadlock", "holds"),
            ("--ctl", "EF (busy >= 2)", "violated"),
        ]
    ):
        file = tmp_path / f"{number}.json"
        report = json.loads(run("verify", net, logic, formula, "--certificate", file, "--json").stdout)
        assert (report["status"], report["certificate"]) == (answer, str(file))
        checked = run("certify", net, file, "--json")
        report = json.loads(checked.stdout)
        assert (checked.exit_code, report["valid"], report["answer"]) == (0, True, answer)
        assert report["question"]["text"] == formula


@uses("ends")
def test_settings_are_part_of_a_certificate(run: Run, net: Path, tmp_path: Path) -> None:
    file = tmp_path / "five.json"
    arguments = ("find", net, "--set", "a.tokens=4", "--marking", "a + b >= 5", "--certificate", file)
    assert run(*arguments).exit_code == 1
    assert (
        lines(run("certify", net, file))[0] == f"valid: a + b >= 5 is unreachable in {net} --set a.tokens=4"
    )


@uses("cycle")
def test_what_rests_on_markings_or_a_run_has_no_certificate(run: Run, net: Path, tmp_path: Path) -> None:
    file = tmp_path / "none.json"
    found = run("find", net, "--enabled", "stop", "--certificate", file)
    assert (found.exit_code, file.exists()) == (0, False)
    assert f"{file} is not written: the answer depends on a run" in found.stderr
    held = run("verify", net, "--ctl", "AG EF (idle >= 1)", "--certificate", file)
    assert (held.exit_code, file.exists()) == (0, False)
    assert f"{file} is not written: the answer depends on all markings" in held.stderr


@uses("cycle")
def test_another_net_is_refuted(run: Run, net: Path, tmp_path: Path) -> None:
    file = tmp_path / "two.json"
    run("find", net, "--marking", "busy >= 2", "--certificate", file)
    net.write_text(net.read_text().replace("idle (1)", "idle (2)"))
    refused = run("certify", net, file)
    assert refused.exit_code == 1
    assert lines(refused) == [f"refuted: {file}: it belongs to another net"]


@uses("cycle")
@pytest.mark.parametrize(
    "text",
    ["", "{}", "[1]", '{"format": "dineros certificate 1"}', "[" * 100_000, '{"facts": 1e999}', "\0"],
)
def test_what_is_no_certificate_is_bad_input(run: Run, net: Path, tmp_path: Path, text: str) -> None:
    file = tmp_path / "bad.json"
    file.write_text(text)
    assert is_one_line_of_wrong_use(run("certify", net, file), "bad.json")


@uses("cycle")
def test_parts_of_a_wrong_shape_are_bad_input(run: Run, net: Path, tmp_path: Path) -> None:
    file = tmp_path / "two.json"
    run("find", net, "--marking", "busy >= 2", "--certificate", file)
    whole = json.loads(file.read_text())
    case = whole["never"][0]
    for name, wrong in (
        ("never", [{**case, "weights": {"busy": 0.5}}]),
        ("never", [{**case, "weights": {"busy": True}}]),
        ("never", [{**case, "factors": ["1"]}]),
        ("never", [{"rows": []}]),
        ("clauses", [[{"all": []}]]),
        ("clauses", "busy"),
        ("steps", 1_000),
        ("steps", True),
        ("signals", "loud"),
        ("settings", [1]),
        ("question", {"kind": "marking"}),
    ):
        file.write_text(json.dumps({**whole, name: wrong}))
        assert is_one_line_of_wrong_use(run("certify", net, file), "holds no certificate")


@uses("cycle")
def test_a_certificate_is_a_json_file_in_a_folder_that_is_there(run: Run, net: Path, tmp_path: Path) -> None:
    for file in (tmp_path / "a.txt", tmp_path / "no" / "a.json", tmp_path):
        found = run("find", net, "--marking", "busy >= 2", "--certificate", file)
        assert found.exit_code == 2


def test_of_a_system_model(run: Run, model: Path, tmp_path: Path) -> None:
    file = tmp_path / "noted.json"
    formula = "G Noted <= 3"
    held = run("verify", model, "--signals", "none", "--ltl", formula, "--certificate", file)
    assert (held.exit_code, file.exists()) == (0, True)
    assert lines(run("certify", model, file))[0] == (
        f"valid: {formula} holds in {model} --signals none --overflow weighted"
    )


@uses("cycle")
def test_of_a_check_one_file_or_one_for_each_answer(run: Run, net: Path, tmp_path: Path) -> None:
    folder, file = tmp_path / "all", tmp_path / "all.json"
    checked = run("check", net, "--certificate", folder)
    assert checked.exit_code == 0
    assert f"certificates: {folder}: 2" in checked.stdout + checked.stderr
    written = sorted(folder.iterdir())
    assert [one.name for one in written] == ["bounded.json", "no-deadlock.json"]
    assert run("check", net, "--certificate", file, "--json").exit_code == 0
    for one in (*written, file):
        assert run("certify", net, one).exit_code == 0
    text = json.loads(file.read_text())["question"]["text"]
    assert "deadlock" in text and "busy >= 2" in text


def test_of_a_check_of_a_system_model(run: Run, model: Path, tmp_path: Path) -> None:
    """What no reachable marking of the net without signals does; a queue that overflows is left out."""
    few = ("--set", "Chatter.subscriber.Heard.limit=2")
    assert run("check", model, *few, "--certificate", tmp_path / "all").exit_code == 1
    written = sorted(one.name for one in (tmp_path / "all").iterdir())
    assert "bounded.json" in written and len([name for name in written if "overflow" in name]) == 2
    for name in written:
        checked = run("certify", model, tmp_path / "all" / name)
        assert checked.exit_code == 0 and f"in {model} {few[0]} {few[1]} without signals" in lines(checked)[0]


@uses("cycle")
def test_of_a_property_file(run: Run, net: Path, tmp_path: Path) -> None:
    """What few markings decide has none: answers that rest on structure are asked of a net with many."""
    text = net.read_text().replace("idle (1)", "idle (40)") + "".join(
        f"pl a{n} (30)\ntr u{n} a{n} -> b{n}\ntr d{n} b{n} -> a{n}\n" for n in range(4)
    )
    net.write_text(text + "tr never idle*20 busy*21 -> idle\n")
    file, folder = tmp_path / "one.xml", tmp_path / "all"
    formula = "AG (idle + busy <= 40) & !EF (a0 >= 16 & b0 >= 15)"
    assert run("verify", net, "--ctl", formula, "--write-properties", file).exit_code == 0
    found = run("verify", net, "--properties", file, "--properties", "QuasiLiveness", "--certificate", folder)
    assert found.exit_code == 1, found.stderr
    written = sorted(one.name for one in folder.iterdir())
    assert len(written) == 2 and "QuasiLiveness.json" in written
    for name in written:
        assert run("certify", net, folder / name).exit_code == 0
    assert "enabled(never) is unreachable" in run("certify", net, folder / "QuasiLiveness.json").stdout
