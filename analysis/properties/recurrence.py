"""Nets that always return to the initial marking, proved on a reduced net: they are live and reversible.

A transition that takes and puts back the initial marking changes nothing, and is enabled if each place has at
least its initial tokens. Let weights y > 0 of places, whose weighted sum no firing increases, bound them: a
marking m >= m0 has y . m <= y . m0, so m = m0. In a net with such bounds, the transition is live iff the net
is reversible. So both questions become one, whether a net is live, which structural reductions preserve. If
they leave a small net, its diagram answers even if the diagram of the original net would be too large.

References
----------
G. Berthelot, *Transformations and decompositions of nets*, Advances in Petri Nets 1986, LNCS 254, 1987. T.
Murata, *Petri nets: properties, analysis and applications*, Proc. IEEE 77(4), 1989, Sect. IV and V.
"""

from __future__ import annotations

from dataclasses import dataclass

from dineros.analysis.answers.budget import UNLIMITED, Budget, BudgetExceededError
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.properties.behaviour import TooMuchWorkError, behaviour
from dineros.analysis.reductions import PROOFS_OF_DEATH, Arcs, Change, MutableNet, Property, reduce
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.levels import LevelSizeError, UnknownBoundError
from dineros.analysis.symbolic.saturation import DiagramMemoryError

MOST_WORK = 1_500_000
"""Cache misses of saturation for the reduced net, twice: for its markings and for their analysis."""


@dataclass(frozen=True)
class Recurrence:
    """A net that is bounded and, without its dead transitions, live and reversible.

    So all its markings are home markings, none is a deadlock, and every other transition can fire.

    Attributes
    ----------
    bounds : tuple of int
        An upper bound of the tokens on each place.
    """

    bounds: tuple[int, ...]
    dead: frozenset[int]


def recurrence(net: CompiledNet, budget: Budget = UNLIMITED) -> Recurrence | None:
    """Prove that a net always returns to its initial marking; None: it does not, or there is no proof.

    Parameters
    ----------
    budget : Budget, optional
        Its time and memory; exhausting them gives no answer.

    Examples
    --------
    >>> net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"b": 1}), ("u", {"b": 1}, {"a": 1})])
    >>> recurrence(net)
    Recurrence(bounds=(1, 1), dead=frozenset())
    """
    budget = budget.begun()
    bounds = [bound.value for bound in place_bounds(net) if bound is not None]
    if len(bounds) < len(net.places):
        return None
    alive = reduce(net, {Property.DEADLOCKS}, rules=PROOFS_OF_DEATH, budget=budget).net
    if not alive.transitions:
        return None
    small = reduce(_with_return(alive), {Property.LIVENESS, Property.BOUNDEDNESS}, budget=budget).net
    if not _is_live(small, budget):
        return None
    left = set(alive.transitions)
    return Recurrence(
        tuple(bounds), frozenset(t for t, name in enumerate(net.transitions) if name not in left)
    )


def _with_return(net: CompiledNet) -> CompiledNet:
    """Return the net with a transition that takes and puts back the initial marking."""
    changed = MutableNet.of(net)
    initial = {place: tokens for place, tokens in changed.places.items() if tokens}
    name = changed.fresh_transition("return")
    changed.apply(Change(added_transitions={name: Arcs(initial, initial, {})}))
    return changed.compile()


def _is_live(net: CompiledNet, budget: Budget) -> bool:
    """Whether a net can be proved live with little work."""

    def check_work(spent: int) -> None:
        if spent > MOST_WORK:
            raise TooMuchWorkError

    try:
        space = symbolic_state_space(net, budget, between=check_work)
        return space.complete and not behaviour(space, budget, MOST_WORK).not_live
    except (UnknownBoundError, LevelSizeError, TooMuchWorkError, DiagramMemoryError, BudgetExceededError):
        return False
