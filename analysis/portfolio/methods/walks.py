"""Walks: at random, and along solutions of the state equation; they meet what is far away, but not rare."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.covering.goals import with_goals
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.walks.first_round import first_round

WALKS = "walks"


class Walks(Method):
    """Walk to one of the goals."""

    def answer(self, question: Reach, known: Known, budget: Budget) -> Outcome | None:
        """Return a way that was walked; that none was proves nothing."""
        goals = question.goals
        asked = None if goals is None else with_goals(question.net, goals)
        if goals is None or asked is None:
            return None
        found = first_round(asked.net, budget, asked.transitions, any(goal.is_deadlock for goal in goals))
        ways = [asked.way(found.ways[t][:-1]) for t in asked.transitions if t in found.ways]
        if found.deadlock is not None:
            way = asked.way(found.deadlock)
            ways += [way] if question.holds(replay(question.net, way)[-1]) else []
        return question.reached(min(ways, key=len), WALKS) if ways else None
