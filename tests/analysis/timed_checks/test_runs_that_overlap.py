"""A callback whose runs overlap is always running, but each run ends: this is not an endless wait."""

from __future__ import annotations

from typing import Any

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds import losses
from dineros.analysis.timed_checks.timed_check import check_timed
from dineros.metamodel import sym
from dineros.metamodel.build import flow, place
from dineros.metamodel.elements import find
from tests.support.timed_systems.models import model_of

ENDS = "every callback that has begun ends"


def scanning(group: str = "reentrant", work: tuple[int, int] = (25, 30)) -> sym.SystemModel:
    """Return a scan each 20 ms, and three threads that work on each for longer."""

    def called(name: str, node: str, *script: list[Any], **more: Any) -> dict[str, Any]:
        return {"name": name, "node": node, "group": "default", "script": list(script), **more}

    callbacks = [
        called("sense", "s", ["work", 0, 0], ["publish", "scan"], period=20, offset=0),
        called("locate", "n", ["work", *work], topic="scan", depth=2) | {"group": group},
        called("watch", "n", ["work", 0, 1], period=10, offset=0) | {"group": group},
    ]
    nodes = {"s": {"threads": 1}, "n": {"threads": 3}}
    return model_of(
        {"nodes": nodes, "latency": {"scan": (0, 2)}, "chains": [], "callbacks": callbacks}, 0.001
    )


def rules(model: sym.SystemModel, budget: Budget | None = None) -> tuple[set[str], list[str], list[str]]:
    report = check_timed(model, budget or Budget(seconds=100))
    return {each.rule for each in report.findings}, report.proved, list(map(str, report.unknown))


@pytest.mark.parametrize("work", [(25, 30), (20, 20), (24, 24)])
def test_runs_end_although_one_is_always_there(work: tuple[int, int]) -> None:
    found, proved, unknown = rules(scanning(work=work))
    assert found == set() and ENDS in proved and not unknown


def test_without_bounds_it_is_open_and_no_fault(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(losses, "always_ending", lambda subject, pages: set())
    found, proved, unknown = rules(scanning())
    assert found == set() and ENDS not in proved
    assert [each for each in unknown if "callbacks can wait forever" in each]


def test_runs_that_wait_for_a_token_are_found() -> None:
    model = scanning()
    page = find(model, "locate", sym.CallbackPage)
    flow(place(page, "key"), find(model, "locate.do", sym.Transition))
    found, proved, _ = rules(model)
    assert "callback-never-ends" in found and ENDS not in proved


def test_bounds_prove_it_where_the_search_does_not_end() -> None:
    _, proved, unknown = rules(scanning(), Budget(memory_bytes=1))
    assert ENDS in proved and not [each for each in unknown if "callbacks can wait forever" in each]
