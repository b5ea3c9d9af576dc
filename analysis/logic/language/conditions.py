"""Conditions on the marking of a running application, such as ``Shown >= 4 & !signal(Danger)``.

The engines bind a formula to the indices of a compiled net; a running application has no such net, only
tokens by place id. Names have the same meaning as in the engines: the name of a replicated element is the sum
over its instances, ``Pick[2].PickRun`` belongs to server instance 2.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from functools import partial

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.names import look_up, resolved
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.syntax import (
    OPERATORS,
    And,
    Comparison,
    Constant,
    Equivalent,
    Formula,
    Implies,
    Name,
    Not,
    Or,
    SignalTrue,
)
from dineros.metamodel.clauses import SignalSetting

_INSTANCE = re.compile(r".+\[\d+\]\.(.+)")

Predicate = Callable[[Mapping[str, int], Mapping[str, SignalSetting]], bool]


class Condition:
    """A condition on tokens and signals.

    Parameters
    ----------
    places, signals : iterable of str
        Known ids, those of replicated places with their instance.

    Raises
    ------
    FormulaError
        The text is not a condition on a marking and signals, or has an unknown name.

    Examples
    --------
    >>> ready = Condition("Run >= 2 & !signal(Danger)", ["Pick[1].Run", "Pick[2].Run"], ["Danger"])
    >>> ready({"Pick[1].Run": 1, "Pick[2].Run": 1}, {"Danger": False})
    True
    """

    def __init__(self, text: str, places: Iterable[str], signals: Iterable[str]) -> None:
        self.text = text
        self._places: dict[str, list[str]] = {}
        for place in places:
            self._places.setdefault(place, []).append(place)
            instance = _INSTANCE.fullmatch(place)
            if instance:
                self._places.setdefault(instance[1], []).append(place)
        self._signals = {signal: signal for signal in signals}
        self._holds = self._compiled(parse(text, "state"))

    def __call__(self, marking: Mapping[str, int], signals: Mapping[str, SignalSetting]) -> bool:
        """Say whether the condition holds; a place that is not mentioned holds no token."""
        return self._holds(marking, signals)

    def _compiled(self, formula: Formula) -> Predicate:
        if isinstance(formula, Constant):
            value = formula.value
            return lambda marking, signals: value
        if isinstance(formula, Comparison):
            return self._comparison(formula)
        if isinstance(formula, SignalTrue):
            signal = self._signal(formula.name)
            id, _, wanted = signal.rpartition(".")
            return lambda marking, signals: signals.get(signal) is True or signals.get(id) == wanted
        parts = [self._compiled(operand) for operand in formula.operands]
        if isinstance(formula, Not):
            return lambda marking, signals: not parts[0](marking, signals)
        if isinstance(formula, And):
            return lambda marking, signals: all(part(marking, signals) for part in parts)
        if isinstance(formula, Or):
            return lambda marking, signals: any(part(marking, signals) for part in parts)
        if isinstance(formula, Implies):
            return lambda marking, signals: not parts[0](marking, signals) or parts[1](marking, signals)
        if isinstance(formula, Equivalent):
            return lambda marking, signals: parts[0](marking, signals) == parts[1](marking, signals)
        raise FormulaError(
            f"{formula} cannot be observed while an application runs",
            hint="compare places, or use signals",
        )

    def _comparison(self, formula: Comparison) -> Predicate:
        terms = [(factor, place) for factor, name in formula.terms for place in self._named(name)]
        compare, bound = OPERATORS[formula.operator], formula.bound
        return lambda marking, signals: compare(
            sum(factor * marking.get(place, 0) for factor, place in terms), bound
        )

    def _named(self, name: Name) -> list[str]:
        return resolved(partial(look_up, self._places, "place"), name)

    def _signal(self, name: Name) -> str:
        return resolved(partial(look_up, self._signals, "signal"), name)
