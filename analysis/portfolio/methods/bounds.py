"""Bounds of places, by their invariants and by linear programs."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.portfolio.known import Known
from dineros.analysis.portfolio.method import Method
from dineros.analysis.portfolio.sheet import Sheet


class PlaceBounds(Method):
    """Apply bounds of places: to constant atoms, to upper bounds of sums, to the whole net."""

    def answer_all(self, sheet: Sheet, known: Known, budget: Budget) -> None:
        """Apply the bounds, and the coverability tree if it is small."""
        proved = place_bounds(known.net)
        bounds = [None if bound is None else bound.value for bound in proved]
        sheet.whole.by_bounds(bounds)
        sheet.always.update(sheet.constants(proved))
        for limits in sheet.open_limits().values():
            parts = [bounds[place] for place in limits.factors]
            if None not in parts:
                factors = limits.factors.values()
                limits.most = sum(k * part for k, part in zip(factors, parts, strict=True) if part)
        sheet.settle("structure")
        if sheet.open_globals():
            sheet.whole.by_coverability()
