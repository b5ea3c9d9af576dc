"""A first run, which compiles the engines, says so in one line: also where nobody sits at a terminal."""

from __future__ import annotations

import click
import numba
import pytest

from dineros.cli.options import Invocation
from dineros.cli.searching import QUIET_COMPILATION, Limits, Search

LINE = "compiling the engines, once after an installation; this takes up to a minute\n"

NO_LIMITS = Limits(0.0, None, None)


def compile_two() -> None:
    for added in (1, 2):
        numba.njit(lambda number: number + added)(1)  # noqa: B023 - called at once


@pytest.mark.parametrize(("verbosity", "said"), [(0, LINE), (1, LINE), (-1, "")])
def test_it_is_said_once_when_something_is_compiled(
    verbosity: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(QUIET_COMPILATION)
    with click.Context(click.Command("check"), obj=Invocation(verbosity=verbosity)):
        with Search(NO_LIMITS) as search:
            search.budget()
        assert capsys.readouterr().err == ""
        with Search(NO_LIMITS) as search:
            search.budget()
            compile_two()
        assert capsys.readouterr() == ("", said)


def test_who_compares_what_is_printed_can_do_without(capsys: pytest.CaptureFixture[str]) -> None:
    with Search(NO_LIMITS) as search:
        search.budget()
        compile_two()
    assert capsys.readouterr().err == ""


def test_compiling_is_a_stage_of_its_own_between_two_parts_of_another() -> None:
    told: list[tuple[str, object]] = []
    with Search(NO_LIMITS, told.append) as search:
        budget = search.budget()
        budget.stage("saturation")
        compile_two()
    assert [value for kind, value in told if kind == "stage"] == [
        "saturation",
        *["compiling the engines", "saturation"] * 2,
    ]
