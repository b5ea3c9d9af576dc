"""Times of goals that are canceled, against a plain program."""

from __future__ import annotations

import os
from random import Random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.bounded import read_bounded
from dineros.analysis.timed.durations.bounded_response import decide_bounded
from dineros.analysis.timed.nets import TimedNet
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import sym
from dineros.metamodel.build import place
from dineros.metamodel.elements import channels, find
from tests.support.timed_systems.goals.cancels import Explorer, GoalCancels

pytestmark = pytest.mark.usefixtures("own_time")

SEEDS = 100 * int(os.environ.get("DINEROS_EXAMPLES", "1"))
SENT = 'fired("Act.client.sender0.send")'
RESULTS = {
    "succeeded": 'fired("Act.client.sender0.result.There")',
    "canceled": 'fired("Act.client.sender0.result.Back")',
}
ANY = f"({' | '.join(RESULTS.values())})"


def holds(net: TimedNet, text: str) -> bool:
    formula = read_bounded(text)
    assert formula is not None
    answer = decide_bounded(net, formula, budget=Budget(seconds=60))
    assert answer.status in ("holds", "violated"), answer.reason
    return answer.status == "holds"


def require_safe(system: GoalCancels) -> None:
    """Require that nothing is proved which a run of the plain program shows to be wrong.

    Latencies have no least time in the net, so other things can happen there, too; without them, nothing can.
    """
    facts, net = Explorer(system, 30_000), timed_base_subject(system.model()).timed
    is_exact = system.latency == (0, 0)
    most = max(greatest for _, greatest in facts.times.values())
    assert most == 0 or not holds(net, f"G ({SENT} -> F[<={most - 1}] {ANY})"), system
    assert not is_exact or holds(net, f"G ({SENT} -> F[<={most}] {ANY})"), system
    for outcome, result in RESULTS.items():
        if outcome in facts.times:
            least, _ = facts.times[outcome]
            assert not holds(net, f"G ({SENT} -> G[<={least}] !{result})"), (system, outcome)
        elif is_exact:
            assert holds(net, f"G ({SENT} -> G[<=60] !{result})"), (system, outcome)


@pytest.mark.parametrize(
    "system",
    [
        GoalCancels(2, 0, (1, 1), (3, 4), (0, 0), 2, (0, 0)),
        GoalCancels(1, 0, (3, 4), (2, 3), (1, 1), 1, (0, 1)),
        GoalCancels(2, 0, (1, 1), (2, 3), (0, 0), 1, (1, 1)),
    ],
)
def test_a_goal_ends_by_itself_or_is_canceled(system: GoalCancels) -> None:
    require_safe(system)


@pytest.mark.parametrize("knows", [False, True])
def test_a_client_cancels_a_goal_once_it_knows_that_it_is_accepted(knows: bool) -> None:
    """The goal, the acceptance, the request to cancel and the result each take up to 1; then it is over."""
    system = GoalCancels(1, 0, (1, 1), (9, 9), (0, 0), 1, (0, 1))
    assert Explorer(system, 30_000).times == {"canceled": (1, 4)}
    model = system.model()
    if knows:
        (action,) = channels(model, sym.ActionChannel)
        (client,) = action.clients
        client.accepted = place(find(model, "sender0", sym.NodeNet), "Accepted0")
    net = timed_base_subject(model).timed
    assert not holds(net, f"G ({SENT} -> F[<=3] {ANY})")
    assert holds(net, f"G ({SENT} -> F[<=4] {ANY})") or not knows


@pytest.mark.long
def test_random_systems() -> None:
    for seed in range(SEEDS):
        require_safe(GoalCancels.drawn(Random(seed)))
