"""The clock that budgets of tests have: what else a machine does, and compilation, costs nothing."""

from __future__ import annotations

import os
import time
from typing import Any

from numba import njit

from dineros.analysis.answers.budget import Budget
from tests.support.own_time import SLOWEST, of_budgets


def work(seconds: float) -> None:
    ends = time.process_time() + seconds
    while time.process_time() < ends:
        pass


def test_a_process_that_waits_spends_a_tenth_and_one_that_works_spends_it_all() -> None:
    with of_budgets():
        budget, began, worked = Budget(seconds=60).begun(), time.perf_counter(), time.process_time()
        time.sleep(0.5)
        waited = time.perf_counter() - began
        assert 0.5 * SLOWEST <= budget.spent <= waited
        assert budget.spent < 0.5
        work(0.3)
        assert 0.3 <= budget.spent <= time.perf_counter() - began
        assert budget.spent <= time.process_time() - worked + (time.perf_counter() - began) * SLOWEST


def test_what_is_compiled_costs_nothing_but_that_tenth() -> None:
    def plain(number: int) -> int:
        total = 0
        for one in range(number):
            for other in range(one):
                total += one ^ other
        return total

    with of_budgets():
        budget, began, worked = Budget(seconds=60).begun(), time.perf_counter(), time.process_time()
        compiled_loops: Any = njit(plain)
        assert compiled_loops(3) == plain(3)
        compiled = time.process_time() - worked
        assert compiled > 0.05
        assert budget.spent <= max(0.5 * compiled, 2 * SLOWEST * (time.perf_counter() - began))


def test_a_forked_process_continues_the_clock() -> None:
    with of_budgets():
        budget = Budget(seconds=60).begun()
        work(0.2)
        before = budget.spent
        child = os.fork()
        if not child:
            os._exit(0 if before <= budget.spent < before + 5 else 1)
        assert os.waitpid(child, 0)[1] == 0


def test_without_it_the_wall_counts() -> None:
    budget = Budget(seconds=60).begun()
    time.sleep(0.2)
    assert budget.spent >= 0.2
