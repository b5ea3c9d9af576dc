"""Conditions that must hold in all markings of a replayed run."""

from __future__ import annotations

from collections.abc import Sequence

from dineros.analysis.logic.language.conditions import Condition
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet
from dineros.metamodel import sym
from dineros.metamodel.clauses import formula_names
from dineros.metamodel.elements import node_nets


class Invariant:
    """A condition on markings of the flattened net and on signals.

    Raises
    ------
    FormulaError
        The text is not such a condition.
    """

    def __init__(self, text: str, subject: Subject) -> None:
        assert isinstance(subject.model, sym.SystemModel)
        self.text = text
        self._net: CompiledNet = subject.net
        used = {
            literal.signal.id for literal in subject.model.eAllContents() if isinstance(literal, sym.Literal)
        }
        names = [
            name
            for node in node_nets(subject.model)
            for signal in node.signals
            if signal.id in used
            for name in formula_names(signal)
        ]
        self._signals = {name: subject.net.places[subject.names.signal(name)] for name in names}
        self._condition = Condition(text, subject.net.places, self._signals)

    def first_violation(self, transitions: Sequence[str]) -> int | None:
        """Return the number of firings after which it is first violated; None: it always holds."""
        net = self._net
        index = {name: number for number, name in enumerate(net.transitions)}
        marking = {name: int(tokens) for name, tokens in zip(net.places, net.initial, strict=True)}
        for done in range(len(transitions) + 1):
            signals = {id: marking[place] > 0 for id, place in self._signals.items()}
            if not self._condition(marking, signals):
                return done
            if done < len(transitions):
                for place, change in net.delta[index[transitions[done]]].items():
                    marking[net.places[place]] += change
        return None
