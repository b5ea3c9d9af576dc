"""If only unfair runs violate a formula: finds the fairness with which it holds.

A run that violates the formula neglects some transitions forever. These are assumed to be fair, and the
formula is decided again, until a fair run violates it or no run does. Assumptions that the proof does not
need are removed.

References
----------
E. Clarke, O. Grumberg, S. Jha, Y. Lu, H. Veith, *Counterexample-guided abstraction refinement for symbolic
model checking*, JACM 50(5), 2003 (from each counterexample to what excludes it).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.answers.stages import Share
from dineros.analysis.logic.ltl.earlier import EarlierSearches
from dineros.analysis.model.fairness import unfairness
from dineros.analysis.model.subject import Subject
from dineros.analysis.questions.net_questions import Linear

MOST_ROUNDS = 12
"""Maximum number of runs from which assumptions are taken."""

SHARE = Share(time=0.2, most_seconds=10.0)
"""Share of this search."""


@dataclass(frozen=True)
class NeededFairness:
    """Fairness assumptions with which a formula holds; none is redundant, as far as time allowed.

    Attributes
    ----------
    weak, strong : tuple of str
        Names of the net's transitions that are not neglected if they are enabled forever, and if they are
        enabled infinitely often.
    """

    weak: tuple[str, ...]
    strong: tuple[str, ...]

    def __str__(self) -> str:
        kinds = (("weak", self.weak), ("strong", self.strong))
        return " and ".join(f"{kind} fairness of {', '.join(names)}" for kind, names in kinds if names)

    def to_dict(self) -> dict[str, list[str]]:
        """Return it for JSON."""
        return {"weak": list(self.weak), "strong": list(self.strong)}


def needed_fairness(
    subject: Subject, question: Linear, answer: Outcome, budget: Budget
) -> NeededFairness | None:
    """Return the fairness with which a violated formula holds; None: a fair run violates it, or unknown.

    Parameters
    ----------
    question : Linear
        A formula, with the fairness already assumed.
    answer : Outcome
        The answer ``violated``, with an infinite run.
    budget : Budget
        Budget, of which a share of the time is used.
    """
    if answer.status != "violated" or not answer.loop:
        return None
    share = SHARE.share(budget)
    rising = replace(question, earlier=EarlierSearches())
    names = subject.net.transitions
    weak: list[str] = []
    strong: list[str] = []
    for _ in range(MOST_ROUNDS):
        unfair = unfairness(subject, answer.stem, answer.loop)
        # Weak fairness is sufficient if it applies, and assumes less.
        more = [names[t] for t in unfair.weakly if names[t] not in weak]
        again = [names[t] for t in unfair.strongly if names[t] not in strong]
        if more:
            weak += more
        elif again:
            strong += again
        else:
            return None
        answer = _asked(rising, weak, strong, share)
        if answer.status == "holds":
            return _least(question, weak, strong, share)
        if answer.status != "violated" or not answer.loop:
            return None
    return None


def _asked(question: Linear, weak: list[str], strong: list[str], budget: Budget) -> Outcome:
    """Decide with more assumptions; of the strong ones, one is added at a time."""
    weakly = tuple(name for name in weak if name not in strong)
    return replace(question, weak=(*question.weak, *weakly), strong=(*question.strong, *strong)).decided(
        budget
    )


def _least(question: Linear, weak: list[str], strong: list[str], budget: Budget) -> NeededFairness:
    """Remove assumptions without which the formula still holds, strong ones first."""
    for kept in (strong, weak):
        for name in list(kept):
            if budget.is_over:
                break
            kept.remove(name)
            if _asked(question, weak, strong, budget).status != "holds":
                kept.append(name)
    return NeededFairness(tuple(name for name in weak if name not in strong), tuple(strong))
