"""What is known of a net, found once and used by every method and every question about the net."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING

from dineros.analysis.logic.language.names import Names
from dineros.analysis.logic.language.syntax import Formula
from dineros.analysis.nets.compiled import CompiledNet

if TYPE_CHECKING:
    from dineros.analysis.proofs.encoding import Sums
    from dineros.analysis.proofs.state_equation import StateEquation
    from dineros.analysis.properties.reduced import Reduced

# What costs an import is imported where it is first asked for: most questions need little of it.


class Known:
    """The record of a net. What stands in it depends on the net alone, never on a budget.

    Parameters
    ----------
    net : CompiledNet
        The net.
    """

    def __init__(self, net: CompiledNet) -> None:
        self.net = net
        self._reduced: dict[Formula, Reduced | None] = {}

    @cached_property
    def equation(self) -> StateEquation:
        """The state equation."""
        from dineros.analysis.proofs.state_equation import StateEquation

        return StateEquation(self.net)

    @cached_property
    def sums(self) -> Sums | None:
        """Bounds and invariants for solvers; None where places are not proved to hold few tokens."""
        from dineros.analysis.proofs.induction import sums_of

        return sums_of(self.net)

    @cached_property
    def transition_index(self) -> dict[str, int]:
        """Numbers of the transitions by their names."""
        return {name: number for number, name in enumerate(self.net.transitions)}

    def reduced(self, condition: Formula, names: Names) -> Reduced | None:
        """Return the net reduced for a condition or a formula; None where it cannot be reduced for it."""
        from dineros.analysis.properties.reduced import reduced

        if condition not in self._reduced:
            self._reduced[condition] = reduced(self.net, condition, names)
        return self._reduced[condition]


def known_of(net: CompiledNet) -> Known:
    """Return the record of a net."""
    return net.once(Known)
