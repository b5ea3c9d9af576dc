"""``--confirm`` through the command line."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.nets.compiled import CompiledNet
from tests.cli.conftest import Run
from tests.support.broken_engines import break_diagrams
from tests.support.programs.commands import uses


@uses("cycle")
def test_the_commands_say_who_confirmed(run: Run, net: Path) -> None:
    for arguments in (
        ("statespace", net, "--no-cache"),
        ("check", net, "--no-cache"),
        ("verify", net, "--no-cache", "--ctl", "AG EF idle >= 1"),
        ("verify", net, "--no-cache", "--ltl", "G idle + busy == 1"),
        ("find", net, "--marking", "busy >= 2"),
    ):
        plain, result = run(*arguments), run(*arguments, "--confirm")
        assert result.exit_code == plain.exit_code
        assert result.stdout.splitlines()[-1].startswith("confirmed by explicit search (")


def broken(net: CompiledNet, goal: object, *rest: Any, **more: Any) -> Outcome:
    """Stand for a search that finds nothing."""
    return Outcome("unreachable", states=1)


def test_the_commands_say_loudly_who_disagrees(
    run: Run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    net = tmp_path / "turns.net"
    net.write_text("net turns\npl a (2)\ntr t a -> b\ntr u b -> a\n")
    break_diagrams(monkeypatch)
    monkeypatch.setattr("dineros.analysis.portfolio.methods.explicit_search.find", broken)
    for arguments in (
        ("statespace", net, "--no-cache", "--engine", "symbolic"),
        ("statespace", net, "--no-cache", "--engine", "explicit"),
        ("check", net, "--no-cache"),
        ("verify", net, "--no-cache", "--ctl", "AG EF a >= 2"),
        ("find", net, "--marking", "b >= 2"),
    ):
        result = run(*arguments, "--confirm")
        assert result.exit_code == 3, arguments
        assert "ERROR: engines disagree: the answer: " in result.stderr
        assert "explicit search: " in result.stderr or "decision diagrams: " in result.stderr
        assert run(*arguments, "--confirm", "--json").exit_code == 3
        # Nobody asked, nobody knows: this is what the option is for.
        assert run(*arguments).exit_code != 3


@uses("ends")
def test_what_rests_on_a_run_needs_no_confirmation(run: Run, net: Path) -> None:
    result = run("find", net, "--enabled", "t", "--confirm", "-v")
    assert result.exit_code == 0 and "does not depend on all markings" in result.stderr
