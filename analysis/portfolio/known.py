"""The known facts about a net, found once and used by all methods and questions about it."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.covering.directed import Directed
    from dineros.analysis.explicit.layout import Layout
    from dineros.analysis.portfolio.walker import Walker
    from dineros.analysis.proofs.encoding import Sums
    from dineros.analysis.proofs.state_equation import StateEquation
    from dineros.analysis.properties.part_of_graph import PartOfGraph
    from dineros.analysis.properties.reduced import Reduced
    from dineros.analysis.reductions import Reduction
    from dineros.analysis.symbolic.engine import SymbolicStateSpace

# Slow imports are made at their first use: most questions need few of them.


class Known:
    """The record of a net.

    Attributes
    ----------
    graph : PartOfGraph or None
        Markings stored with their successors, as far as a budget allowed.
    space : SymbolicStateSpace or None
        All markings as a decision diagram.
    cells : Layout or None
        The layout of stored markings, which takes time to compute.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self.graph: PartOfGraph | None = None
        self.space: SymbolicStateSpace | None = None
        self.cells: Layout | None = None
        self._reduced: dict[Formula, Reduced | None] = {}
        self._reductions: dict[str, Reduction] = {}

    @cached_property
    def equation(self) -> StateEquation:
        """The state equation."""
        from dineros.analysis.proofs.state_equation import StateEquation

        return StateEquation(self.net)

    @cached_property
    def sums(self) -> Sums | None:
        """Bounds and invariants for solvers; None: places are not proved to have few tokens."""
        from dineros.analysis.proofs.induction import sums_of

        return sums_of(self.net)

    @cached_property
    def walker(self) -> Walker:
        """Random walks, which continue from one question to the next."""
        from dineros.analysis.portfolio.walker import Walker

        return Walker(self.net)

    @property
    def has_all_markings(self) -> bool:
        """Whether all markings are stored one by one."""
        return self.graph is not None and self.graph.is_complete

    def forget(self) -> None:
        """Release data that takes much memory."""
        self.graph = self.space = None

    @cached_property
    def transition_index(self) -> dict[str, int]:
        """Numbers of the transitions, by name."""
        return {name: number for number, name in enumerate(self.net.transitions)}

    @cached_property
    def directed(self) -> Directed:
        """Searches for distant firings, guided by the state equation."""
        from dineros.analysis.covering.directed import Directed

        return Directed(self.net)

    def reduced_for_firing(self, transition: str) -> Reduction:
        """Return the net reduced for the question whether a transition ever fires (LTL without next)."""
        from dineros.analysis.reductions import Property, reduce

        if transition not in self._reductions:
            kept = {Property.LTL_WITHOUT_NEXT}
            self._reductions[transition] = reduce(self.net, kept, observed_transitions=[transition])
        return self._reductions[transition]

    def reduced(self, condition: Formula, names: Names) -> Reduced | None:
        """Return the net reduced for a condition or a formula; None: it cannot be reduced for it."""
        from dineros.analysis.properties.reduced import reduced

        if condition not in self._reduced:
            self._reduced[condition] = reduced(self.net, condition, names)
        return self._reduced[condition]


def known_of(net: CompiledNet) -> Known:
    """Return the record of a net."""
    return net.once(Known)
