"""A count that ends while arcs are counted still has all states."""

from __future__ import annotations

from dataclasses import replace

from dineros.analysis.answers.budget import Budget, BudgetExceededError
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.questions.state_space import state_space


def _over(stage: str) -> None:
    if stage.startswith("counting arcs"):
        raise BudgetExceededError("time ran out")


def test_states_are_known_where_the_rest_is_not() -> None:
    places = {f"{side}{number}": int(side == "a") for number in range(12) for side in "ab"}
    moves = [(f"go{n}", {f"a{n}": 1}, {f"b{n}": 1}) for n in range(12)]
    net = CompiledNet.build(places, moves)
    whole = state_space(net, "symbolic")
    assert (whole.states, whole.complete) == (2**12, True)
    part = state_space(net, "symbolic", replace(Budget(1 << 28), stages=_over))
    assert (part.states, part.arcs, part.deadlocks, part.complete) == (2**12, None, None, False)
    assert part.reason == "time ran out; these are all states, and the rest is not counted"
