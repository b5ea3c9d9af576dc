"""A first run, which compiles the engines, says so in one line: also where nobody sits at a terminal."""

from __future__ import annotations

import click
import numba
import pytest

from dineros.cli.analysing import QUIET_COMPILATION, exploring
from dineros.cli.options import Invocation

LINE = "compiling the engines, once after an installation; this takes up to a minute\n"


def compile_two() -> None:
    for added in (1, 2):
        numba.njit(lambda number: number + added)(1)  # noqa: B023 - called at once


@pytest.mark.parametrize(("verbosity", "said"), [(0, LINE), (1, LINE), (-1, "")])
def test_it_is_said_once_when_something_is_compiled(
    verbosity: int, said: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv(QUIET_COMPILATION)
    with click.Context(click.Command("check"), obj=Invocation(verbosity=verbosity)):
        with exploring():
            pass
        assert capsys.readouterr().err == ""
        with exploring():
            compile_two()
        assert capsys.readouterr() == ("", said)


def test_who_compares_what_is_printed_can_do_without(capsys: pytest.CaptureFixture[str]) -> None:
    with exploring():
        compile_two()
    assert capsys.readouterr().err == ""
