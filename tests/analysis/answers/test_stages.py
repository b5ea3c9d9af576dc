"""Plans: order, shares, what ends them; and that only they divide time."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import pytest

import dineros.analysis
from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.answers.stages import Attempt, Share, Stage, fairly, first_result, run_stages

Work = Callable[["Seen", Budget], None]


@dataclass
class Seen:
    """What was run, and with which seconds."""

    names: list[str] = field(default_factory=list)
    seconds: list[float | None] = field(default_factory=list)


def notes(name: str, error: type[Exception] | None = None) -> Work:
    def work(seen: Seen, budget: Budget) -> None:
        seen.names.append(name)
        seen.seconds.append(budget.left)
        if error is not None:
            raise error(name)

    return work


def test_stages_run_in_order_with_parts_of_what_is_left() -> None:
    plan = [Stage(notes("a"), time=0.5), Stage(notes("b"), lambda seen: False), Stage(notes("c"))]
    seen = run_stages(Seen(), plan, Budget(seconds=100.0))
    assert seen.names == ["a", "c"]
    assert seen.seconds == [pytest.approx(50.0, abs=5.0), pytest.approx(100.0, abs=5.0)]


def test_a_stage_that_exceeds_its_share_does_not_end_the_plan() -> None:
    plan = [Stage(notes("a", BudgetExceededError)), Stage(notes("b"))]
    assert run_stages(Seen(), plan, Budget()).names == ["a", "b"]
    with pytest.raises(BudgetExceededError):
        run_stages(Seen(), plan, Budget(), given_up=())


def test_other_errors_end_the_plan() -> None:
    with pytest.raises(ZeroDivisionError):
        run_stages(Seen(), [Stage(notes("a", ZeroDivisionError)), Stage(notes("b"))], Budget())


def test_a_complete_record_ends_the_plan() -> None:
    plan = [Stage(notes(name)) for name in "abc"]
    assert run_stages(Seen(), plan, Budget(), lambda seen: len(seen.names) == 2).names == ["a", "b"]


def test_without_time_only_the_first_stage_runs() -> None:
    plan = [Stage(notes(name)) for name in "abc"]
    assert run_stages(Seen(), plan, Budget(seconds=0.0)).names == ["a"]


def test_stages_are_announced_by_name() -> None:
    told: list[str] = []
    run_stages(Seen(), [Stage(notes("a"), name="first"), Stage(notes("b"))], Budget(stages=told.append))
    assert told == ["first"]


def test_a_stage_for_much_memory_is_left_out_with_less() -> None:
    plan = [Stage(notes("a"), if_more_bytes=100), Stage(notes("b"), if_more_bytes=99)]
    assert run_stages(Seen(), plan, Budget(memory_bytes=100)).names == ["b"]


@pytest.mark.parametrize(
    ("share", "seconds", "left"),
    [
        (Share(time=0.25), 80.0, 20.0),
        (Share(time=0.25, most_seconds=5.0), 80.0, 5.0),
        (Share(time=0.25, most_seconds=5.0), None, 5.0),
        (Share(time=0.25, seconds_if_unlimited=7.0), None, 7.0),
        (Share(time=0.25, seconds_if_unlimited=7.0), 80.0, 20.0),
        (Share(time=0.25), None, None),
    ],
)
def test_a_share_of_the_time(share: Share, seconds: float | None, left: float | None) -> None:
    found = share.share(Budget(seconds=seconds)).left
    assert found == (None if left is None else pytest.approx(left, abs=1.0))


def test_a_share_of_memory_and_states() -> None:
    share = Share(memory=0.5, most_bytes=300, most_states=7).share(Budget(memory_bytes=1_000, states=9))
    assert (share.memory_bytes, share.states) == (300, 7)


def test_the_first_result_counts() -> None:
    asked: list[str] = []

    def gives(name: str, result: int | None) -> Attempt[int]:
        def work(budget: Budget) -> int | None:
            asked.append(name)
            return result

        return Attempt(work)

    assert first_result([gives("a", None), gives("b", 0), gives("c", 2)], Budget()) == 0
    assert asked == ["a", "b"]
    assert first_result([gives("d", None)], Budget()) is None


def test_time_is_divided_fairly() -> None:
    shares = [budget.left for _, budget in fairly("abcd", Budget(seconds=120.0))]
    assert shares == [pytest.approx(120.0 / n, abs=3.0) for n in (4, 3, 2, 1)]
    shares = [budget.left for _, budget in fairly("ab", Budget(seconds=120.0), kept=2)]
    assert shares == [pytest.approx(120.0 / n, abs=3.0) for n in (4, 3)]
    shares = [budget.left for _, budget in fairly("ab", Budget(seconds=120.0), factor=3.0)]
    assert shares == [pytest.approx(120.0, abs=3.0)] * 2


def test_only_this_module_divides_time() -> None:
    """Other code declares a `Share`, a plan or attempts, and lets this module compute the budgets."""
    folder = Path(dineros.analysis.__file__).parent
    own = folder / "answers"
    divides = re.compile(
        r"\.share\(\s*(time=|[\d(]|1 -|[A-Z_]+[,)])|\.(left|seconds) ?[*/]|[*/] ?\w+\.(left|seconds)\b"
    )
    found = [
        f"{path.relative_to(folder)}: {line.strip()}"
        for path in sorted(folder.rglob("*.py"))
        if own not in path.parents
        for line in path.read_text("utf-8").splitlines()
        if divides.search(line)
    ]
    assert not found
