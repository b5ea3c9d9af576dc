"""The plans: the order of methods, and their shares of the budget. New methods are entered here."""

from __future__ import annotations

from dineros.analysis.answers.turns import HEAD_START
from dineros.analysis.logic.language.rewriting import simplified
from dineros.analysis.portfolio.known import known_of
from dineros.analysis.portfolio.methods.counting import CountByDiagrams, CountBySearch, CountByTina
from dineros.analysis.portfolio.methods.diagrams import DecisionDiagrams, DiagramAtHand, LedByDiagram
from dineros.analysis.portfolio.methods.directed_search import DirectedSearch
from dineros.analysis.portfolio.methods.explicit_search import QUICK, ExplicitSearch
from dineros.analysis.portfolio.methods.induction import Induction
from dineros.analysis.portfolio.methods.limits import NetWithLimits
from dineros.analysis.portfolio.methods.parts import PartsOfNet
from dineros.analysis.portfolio.methods.reduced_net import ReducedNet
from dineros.analysis.portfolio.methods.state_equation import StateEquationAndTraps
from dineros.analysis.portfolio.methods.walks import Walks
from dineros.analysis.portfolio.reach import Reach
from dineros.analysis.portfolio.satisfies import Question
from dineros.analysis.portfolio.scheduler import Plan, Side, SoFar, Together, Turn

NEAR_STATES, NEAR_IF_SHORTEST = 20_000, 2_000_000
"""Number of markings searched before anything else; more if a shortest trace is required."""

FIRST_WORK = 3_000_000
"""Cache misses of saturation, about a second, for a net with limits before other methods."""


def wants_any_way(question: Question, so_far: SoFar) -> bool:
    """Whether any trace suffices, and goals can be searched for one by one."""
    return isinstance(question, Reach) and not question.is_shortest and question.goals is not None


def _takes_any_way(question: Question, so_far: SoFar) -> bool:
    return isinstance(question, Reach) and not question.is_shortest


def _has_no_way(question: Question, so_far: SoFar) -> bool:
    return isinstance(question, Reach) and question.is_shortest and so_far.way is None


def _knows_no_way(question: Question, so_far: SoFar) -> bool:
    return so_far.way is None


def _has_long_way(question: Question, so_far: SoFar) -> bool:
    return isinstance(question, Reach) and question.is_shortest and so_far.way is not None


def has_diagram(question: Question, so_far: SoFar) -> bool:
    """Whether all markings of the net are there as a diagram, and any trace suffices."""
    if isinstance(question, Reach) and question.is_shortest:
        return False
    return known_of(question.net).space is not None


def _is_irreducible(question: Question, so_far: SoFar) -> bool:
    if not isinstance(question, Reach) or question.transition is not None:
        return False
    return known_of(question.net).reduced(simplified(question.condition), question.names) is None


_SOLVER = Side((Turn(Induction()),))
_EXPLICIT = (
    Turn(ExplicitSearch(), most_bytes=QUICK),
    Turn(ReducedNet((Turn(ExplicitSearch()),)), if_more_bytes=QUICK),
    Turn(ExplicitSearch(), _is_irreducible, if_more_bytes=QUICK),
)
_DIAGRAMS = Side((Turn(NetWithLimits()), Turn(DecisionDiagrams())))

NEAR: Plan = (Turn(ExplicitSearch(is_near=True), most_bytes=QUICK, most_states=NEAR_STATES),)
"""The near markings: all markings of a small net."""

KNOWN_DIAGRAM = Turn(DiagramAtHand(), has_diagram, time=0.3)
"""The diagram of all markings, if another question has made it: most formulas then take little."""

FIND: Plan = (
    *NEAR,
    KNOWN_DIAGRAM,
    Turn(StateEquationAndTraps(), time=0.1, most_seconds=2.0),
    Turn(Walks()),
    Turn(PartsOfNet(), _knows_no_way, time=0.2, most_seconds=5.0),
    Turn(ExplicitSearch(), _has_no_way, most_bytes=QUICK, most_states=NEAR_IF_SHORTEST),
    Turn(ExplicitSearch(), _has_long_way, time=0.3, most_seconds=20.0, most_bytes=QUICK),
    Turn(NetWithLimits(FIRST_WORK), wants_any_way, time=0.6),
    # Goals that are fulfilled in many distant markings are found at once.
    Turn(ExplicitSearch(order="depth-first"), wants_any_way, most_states=NEAR_STATES),
    Together((Side(_EXPLICIT), _DIAGRAMS, _SOLVER), _takes_any_way),
    Together((Side(_EXPLICIT, head_start=HEAD_START), _DIAGRAMS, _SOLVER), when=_has_no_way),
)
"""A trace to a marking, or a proof that there is none."""

PROVE: Plan = (Turn(StateEquationAndTraps(), time=0.5), Turn(Induction()))
"""A proof without a state space, for which a certificate can be written."""

FIRE: Plan = (
    Turn(ExplicitSearch(), most_bytes=QUICK),
    Turn(ReducedNet((Turn(ExplicitSearch()),)), _has_no_way),
)
"""A trace to a firing: a shortest one, unless only the reduced net is small enough."""

NEAR_BYTES = 64 << 20
"""Memory for the search for a shortest trace to a fault, in bytes."""

WITNESS: Plan = (
    Turn(ExplicitSearch(), most_bytes=NEAR_BYTES),
    Turn(ReducedNet((Turn(ExplicitSearch()),)), _has_no_way, most_bytes=NEAR_BYTES),
    Turn(DirectedSearch(), _has_no_way),
    Turn(LedByDiagram(), _has_no_way),
)
"""A trace to a firing that is known to be possible, if there is a diagram of all markings."""

MARKING_BYTES = 16
"""Bytes that explicit search needs at least for a marking: one word, and one slot of its table."""

COUNT: dict[str, Plan] = {
    "auto": (
        Together(
            (
                Side((Turn(CountByDiagrams(only_if_possible=True)),), head_start=HEAD_START),
                Side((Turn(CountBySearch()),), marking_bytes=MARKING_BYTES),
            ),
            alone=HEAD_START,
        ),
    ),
    "explicit": (Turn(CountBySearch()),),
    "symbolic": (Turn(CountByDiagrams()),),
    "tina": (Turn(CountByTina()),),
}
"""The number of states, by the name of the engine: the value of ``--engine``."""
