"""What a certificate is about, read without any engine: a model as a net by names, a formula as a condition.

Conditions are as certificates have them, in JSON: ``{"sum": {place: factor}, "least": number}``, or ``{"all":
[...]}`` or ``{"any": [...]}`` of conditions.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from dineros.analysis.logic.language import syntax
from dineros.analysis.logic.language.parser import parse
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import arcs, places, resolve, transitions
from dineros.metamodel.errors import DinerosError
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.traces import Link

Condition = dict[str, Any]
Marking = dict[str, int]

MOST_PARTS = 200_000
"""Parts that a formula may have: operators are counted as often as they are written out."""


@dataclass
class Net:
    """A net by names: initial tokens; by transition what it takes, puts, and has to find less than."""

    tokens: dict[str, int] = field(default_factory=dict)
    firings: dict[str, tuple[Marking, Marking, Marking]] = field(default_factory=dict)
    #: What names in formulas stand for.
    places: dict[str, list[str]] = field(default_factory=dict)
    transitions: dict[str, list[str]] = field(default_factory=dict)
    signals: dict[str, list[str]] = field(default_factory=dict)

    def change(self, name: str) -> Marking:
        """Return the tokens that each place gains by a firing."""
        takes, puts, _ = self.firings[name]
        return {p: puts.get(p, 0) - takes.get(p, 0) for p in takes | puts}

    def enabling(self, name: str) -> list[Condition]:
        """Return what enables a transition."""
        takes, _, below = self.firings[name]
        needed = [inequality({p: 1}, k) for p, k in takes.items()]
        return needed + [inequality({p: -1}, 1 - k) for p, k in below.items()]

    @property
    def digest(self) -> str:
        """Identify places, tokens, transitions and arcs."""
        return digest([self.tokens, self.firings])

    @classmethod
    def of(cls, model: pn.Net, signals: str, overflow: str) -> Net:
        """Read a model as a net; a system model is flattened first.

        Raises
        ------
        DinerosError
            Transitions have priorities, or a system model cannot be flattened.
        """
        net, links = cls(), []
        if isinstance(model, sym.SystemModel):
            flattened = flatten(model, signals, overflow)  # type: ignore[arg-type]
            model, links = flattened.net, flattened.trace.links
        net.tokens = {str(place.id): place.tokens for place in places(model)}
        for transition in transitions(model):
            if len(transition.overrides):
                raise DinerosError(
                    f"transition {transition.id} has priority over others", element=transition.id
                )
            net.firings[str(transition.id)] = ({}, {}, {})
        for arc in arcs(model):
            net._add_arc(resolve(arc.source), resolve(arc.target), arc.weight, arc.kind)
        if not links:
            net.places = net.signals = {place: [place] for place in net.tokens}
            net.transitions = {transition: [transition] for transition in net.firings}
        for link in links:
            net._add_names(link)
        return net

    def _add_arc(self, source: pn.Node, target: pn.Node, weight: int, kind: pn.ArcKind) -> None:
        """Parallel arcs add up; of parallel inhibitor arcs the smallest weight decides."""
        is_input = isinstance(source, pn.Place)
        place, transition = (source, target) if is_input else (target, source)
        name, (takes, puts, below) = str(place.id), self.firings[str(transition.id)]
        if kind == pn.ArcKind.inhibitor:
            below[name] = min(below.get(name, weight), weight)
            return
        if is_input:
            takes[name] = takes.get(name, 0) + weight
        if not is_input or kind == pn.ArcKind.read:
            puts[name] = puts.get(name, 0) + weight

    def _add_names(self, link: Link) -> None:
        """Elements that were kept, or made once for each instance, are named as in the model, too."""
        if isinstance(link.target, pn.Arc):
            return
        target, is_place = str(link.target.id), isinstance(link.target, pn.Place)
        kept = link.sources[:1] if link.role in ("place", "transition") else ()
        for name in {target, *(str(getattr(source, "id", "")) for source in kept)}:
            (self.places if is_place else self.transitions).setdefault(name, []).append(target)
        if is_place and link.meaning is not None and link.meaning.value:
            (signal,) = link.sources
            assert isinstance(signal, sym.InputSignal)
            self.signals[str(signal.id)] = [target]
            if signal.name:
                self.signals.setdefault(signal.name, [target])


def digest(value: object) -> str:
    """Identify a value of JSON."""
    return hashlib.sha256(json.dumps(value, sort_keys=True).encode()).hexdigest()


def excluded(net: Net, kind: str, text: str, answer: str) -> Condition:
    """Return what no reachable marking may fulfil for an answer to be right.

    Raises
    ------
    DinerosError
        The formula cannot be read, or asks for more than markings that are never reached.
    """
    reader = _Reader(net)
    match kind, answer:
        case "enabled", "unreachable":
            return reader.condition(syntax.Enabled(syntax.Name(text)))
        case "marking", "unreachable":
            return reader.condition(parse(text, "state"))
        case ("ltl", "holds") | ("ctl", "holds" | "violated"):
            return reader.against(parse(text, kind), answer == "holds")
    raise DinerosError(f"no certificate says '{answer}' of {kind}")


class _Reader:
    def __init__(self, net: Net) -> None:
        self.net, self.parts = net, 0

    def against(self, formula: syntax.Formula, value: bool) -> Condition:
        match formula:
            case syntax.Not(operand):
                return self.against(operand, not value)
            case syntax.And(operands) if value:
                return {"any": [self.against(operand, value) for operand in operands]}
            case syntax.Or(operands) if not value:
                return {"any": [self.against(operand, value) for operand in operands]}
            case syntax.ForAll(syntax.Globally(operand)) | syntax.Globally(operand) if value:
                return negated(self.condition(operand))
            case syntax.Exists(syntax.Finally(operand)) | syntax.Finally(operand) if not value:
                return self.condition(operand)
        raise DinerosError(f"no certificate can say of this that it is {str(value).lower()}: {formula}")

    def condition(self, formula: syntax.Formula) -> Condition:
        self.parts += 1
        if self.parts > MOST_PARTS:
            raise DinerosError(f"the formula has more than {MOST_PARTS} parts")
        match formula:
            case syntax.Constant(value):
                return {"all" if value else "any": []}
            case syntax.Not(operand):
                return negated(self.condition(operand))
            case syntax.And(operands) | syntax.Or(operands):
                key = "all" if isinstance(formula, syntax.And) else "any"
                return {key: [self.condition(operand) for operand in operands]}
            case syntax.Implies(left, right):
                return {"any": [negated(self.condition(left)), self.condition(right)]}
            case syntax.Equivalent(left, right):
                same = [self.condition(left), self.condition(right)]
                return {"any": [{"all": same}, {"all": [negated(part) for part in same]}]}
            case syntax.Comparison(terms, symbol, bound):
                return self._comparison(terms, symbol, bound)
            case syntax.SignalTrue(name):
                return inequality({self._known(self.net.signals, name)[0]: 1}, 1)
            case syntax.Enabled(name):
                chosen: Sequence[str] = self._known(self.net.transitions, name)
                return {"any": [{"all": self.net.enabling(t)} for t in chosen]}
            case syntax.Deadlock():
                return negated({"any": [{"all": self.net.enabling(t)} for t in self.net.firings]})
        raise DinerosError(f"no condition on markings: {formula}")

    def _comparison(self, terms: Sequence[tuple[int, syntax.Name]], symbol: str, bound: int) -> Condition:
        weights: Marking = {}
        for factor, name in terms:
            for place in self._known(self.net.places, name):
                weights[place] = weights.get(place, 0) + factor
        least = {">=": bound, ">": bound + 1, "<": bound, "<=": bound + 1}
        if symbol in least:
            row = inequality(weights, least[symbol])
            return row if symbol in (">=", ">") else negated(row)
        equal = {"all": [inequality(weights, bound), negated(inequality(weights, bound + 1))]}
        return equal if symbol == "==" else negated(equal)

    @staticmethod
    def _known(names: Mapping[str, list[str]], name: syntax.Name) -> list[str]:
        if name.text not in names:
            raise DinerosError(f"the net has nothing that is named {name.text!r}")
        return names[name.text]


def inequality(weights: Mapping[str, int], least: int) -> Condition:
    """Return the condition that a weighted sum of tokens is at least a number."""
    return {"sum": dict(weights), "least": least}


def negated(condition: Condition) -> Condition:
    """Return the condition that holds where another does not."""
    if "sum" in condition:
        return inequality({p: -k for p, k in condition["sum"].items()}, 1 - condition["least"])
    ((key, parts),) = condition.items()
    return {"any" if key == "all" else "all": [negated(part) for part in parts]}
