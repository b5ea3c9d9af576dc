"""Small files that ask for much: refused in one line, or ended within the memory allowed, in a short time."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from dineros.metamodel.files import save
from tests.cli.conftest import Run
from tests.support.broken.small import system as small_system
from tests.support.programs.commands import is_one_line_of_wrong_use, uses
from tests.support.programs.processes import Ended, run_apart

MIB = 1 << 20
NUMBER = 2**31 - 1
#: What may be touched between two looks at the memory.
MARGIN = 32 * MIB


@pytest.fixture
def system(tmp_path: Path) -> Path:
    """Return the file of a system model with a service."""
    path = tmp_path / "small.sym.xmi"
    save(small_system().net, path)
    return path


def is_one_line_of_too_little_memory(ended: Ended) -> bool:
    return (
        ended.exit_code == 3
        and ended.stdout == ""
        and ended.stderr.count("\n") == 1
        and "memory ran out" in ended.stderr
    )


def test_a_limit_is_raised_by_the_option_that_the_error_names(run: Run, system: Path) -> None:
    many = ("--set", "ask.instances=1500")
    assert is_one_line_of_wrong_use(
        run("check", system, *many), "instances 1500, more than the limit of 1000"
    )
    result = run("validate", system, *many)
    assert result.exit_code == 1
    assert "--limit instances=1500" in result.output
    assert run("validate", system, *many, "--limit", "instances=1500").exit_code == 0
    assert run("validate", system, *many).exit_code == 1  # it held for one command


def test_a_wrong_limit_is_one_line(run: Run, system: Path) -> None:
    result = run("validate", system, "--limit", "tokens=many")
    assert is_one_line_of_wrong_use(
        result, "'tokens=many' is not a limit of a size (for example tokens=5000)"
    )


@pytest.mark.parametrize("command", ["statespace", "flatten"])
def test_what_the_rules_would_make_is_counted_first(run: Run, system: Path, command: str) -> None:
    many = ("--set", f"ask.instances={NUMBER}", "--limit", f"instances={NUMBER}")
    output = ("-o", system.with_name("flat.pnm")) if command == "flatten" else ()
    result = run(command, system, *many, *output)
    assert is_one_line_of_wrong_use(result, "with S4, the rules create more than 200000 elements")


@pytest.mark.long
def test_flattening_stays_within_the_memory(system: Path) -> None:
    many = ("--set", f"ask.instances={NUMBER}", "--limit", f"instances={NUMBER}")
    ended = run_apart("statespace", system, *many, "--limit", "elements=999999999999", "--memory", "321M")
    assert is_one_line_of_too_little_memory(ended), ended
    assert "the process may use 321 MiB" in ended.stderr
    assert ended.peak_bytes < 321 * MIB + MARGIN


@pytest.mark.long
@uses("cycle")
@pytest.mark.parametrize("engine", ["symbolic", "auto"])
def test_places_with_many_tokens_stay_within_the_memory(net: Path, engine: str) -> None:
    ended = run_apart(
        "statespace", net, "--set", f"idle.tokens={NUMBER}", "--memory", "364M", "--engine", engine
    )
    assert ended.exit_code == 3, ended
    assert ended.peak_bytes < 300 * MIB + MARGIN
    if engine == "symbolic":
        assert ended.stderr == ""
        assert "reason                 memory ran out" in ended.stdout
        assert "may hold 2147483647 tokens" in ended.stdout


@uses("cycle")
def test_places_with_many_tokens_are_no_matter_where_a_smaller_net_answers(run: Run, net: Path) -> None:
    result = run("check", net, "--set", f"idle.tokens={NUMBER}", "--json")
    report = json.loads(result.stdout)
    assert (result.exit_code, report["unknown"]) == (0, [])
    assert any("no place ever holds more than 2147483647 tokens" in text for text in report["proved"])


@uses("large")
def test_a_check_of_places_with_many_tokens_leaves_it_unknown(run: Run, net: Path) -> None:
    result = run("check", net, "--set", f"a.tokens={NUMBER}")
    assert result.exit_code == 3
    assert "unknown: all questions on the state space: memory ran out" in result.stdout


@pytest.mark.parametrize("command", ["statespace", "check", "find", "verify", "sweep"])
@uses("ends")
def test_less_than_the_program_needs_is_refused_with_that_figure(
    run: Run, net: Path, command: str, tmp_path: Path
) -> None:
    needed: dict[str, tuple[object, ...]] = {
        "find": ("--enabled", "t"),
        "verify": ("--ltl", "true"),
        "sweep": ("--vary", "a.tokens=1", "-o", tmp_path / "table.csv"),
    }
    result = run(command, net, *needed.get(command, ()), "--memory", "320M")
    assert is_one_line_of_wrong_use(result, "the program itself needs 320 MiB: give 321M or more")


@pytest.mark.long
@pytest.mark.parametrize("engine", ["symbolic", "explicit"])
@uses("ends")
def test_a_limit_of_the_address_space_is_respected(net: Path, engine: str) -> None:
    ended = run_apart("statespace", net, "--engine", engine, limits={"RLIMIT_AS": 2048 * MIB})
    assert (ended.exit_code, ended.stderr) == (0, ""), ended


# Where the growth of the table falls differs from machine to machine: one of several limits is too little.
@pytest.mark.long
@pytest.mark.parametrize("most", [560, 640, 700])
@uses("large")
def test_a_limit_below_the_memory_allowed_ends_a_search(net: Path, most: int) -> None:
    limits = {"RLIMIT_AS": most * MIB}
    arguments = ("--set", "a.tokens=500", "--engine", "explicit", "--memory", "64G")
    ended = run_apart("statespace", net, *arguments, limits=limits)
    assert (ended.exit_code, ended.stderr) == (3, ""), ended
    assert "reason                 memory ran out" in ended.stdout
    assert ended.peak_bytes < limits["RLIMIT_AS"]


@uses("ends")
def test_a_limit_below_what_the_program_needs_is_said(net: Path) -> None:
    ended = run_apart("statespace", net, limits={"RLIMIT_AS": 320 * MIB})
    assert (ended.exit_code, ended.stdout, ended.stderr.count("\n")) == (3, "", 1), ended
    assert "the program itself needs 400 MiB" in ended.stderr


@pytest.mark.parametrize(("command", "status"), [("statespace", 3), ("validate", 3)])
@uses("ends")
def test_memory_that_the_system_does_not_give_is_one_line(
    run: Run, net: Path, command: str, status: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    def nothing(*_: object) -> None:
        raise MemoryError

    monkeypatch.setattr("dineros.metamodel.files.load", nothing)
    result = run(command, net)
    assert (result.exit_code, result.stdout, result.stderr.count("\n")) == (status, "", 1)
    assert result.stderr.startswith("dineros: memory ran out: the system gives this process no more")


def test_the_marking_of_a_node_is_counted_before_it_is_made(system: Path) -> None:
    many = ("--set", f"Idle.tokens={NUMBER}", "--limit", f"tokens={NUMBER}")
    ended = run_apart("run", system, "--simulate", "--timeout", "1", *many)
    assert (ended.exit_code, ended.stderr.count("\n")) == (2, 1), ended
    assert "values, more than the limit of 10000000" in ended.stderr
    assert ended.peak_bytes < 200 * MIB
