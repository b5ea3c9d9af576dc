"""The plain firing rule, slow and obvious, on the flattened net: what the engine is compared with.

It shares nothing with the engine: arcs come from the flattened net, clauses from the texts of the model.
"""

from __future__ import annotations

from collections import Counter

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.clauses import And, Constant, Equivalent, Expression, Implies, Not, Or, Signal, parse
from dineros.metamodel.elements import arcs, label, places, transitions
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.split import split


class ReferenceNet:
    """The part of a flattened net that one node runs."""

    def __init__(self, model: sym.SystemModel, node: rtm.RuntimeModel) -> None:
        flat = flatten(model, signals="none").net
        prefixes = [
            (
                f"{port.channel}[{number}].",
                {part.id for part in port.page.eAllContents() if hasattr(part, "id")},
            )
            for place in places(node)
            for port in place.ports  # type: ignore[attr-defined]
            if isinstance(port, rtm.ServerPort)
            for number in range(1, port.instances + 1)
        ]
        prototypes = {id for _, ids in prefixes for id in ids}
        own = {each.id: each.id for each in (*places(node), *transitions(node)) if each.id not in prototypes}
        for prefix, ids in prefixes:
            own |= {prefix + id: id for id in ids}
        tokens = {place.id: place.tokens for place in places(flat)}
        self.marking = Counter({id: tokens[id] for id in tokens if id in own})
        self.names = {t.id: own[t.id] for t in transitions(flat) if t.id in own}
        self.takes: dict[str, Counter[str]] = {t: Counter() for t in self.names}
        self.puts: dict[str, Counter[str]] = {t: Counter() for t in self.names}
        self.inhibitors: dict[str, list[tuple[str, int]]] = {t: [] for t in self.names}
        for arc in arcs(flat):
            source, target = arc.source.id, arc.target.id
            if target in self.names:
                if arc.kind == pn.ArcKind.inhibitor:
                    self.inhibitors[target].append((source, arc.weight))
                    continue
                self.takes[target][source] += arc.weight
                if arc.kind == pn.ArcKind.read:
                    self.puts[target][source] += arc.weight
            elif source in self.names:
                self.puts[source][target] += arc.weight
        # What else the node's transitions touch is the free room of its places.
        touched = {id for table in (self.takes, self.puts) for ends in table.values() for id in ends}
        touched -= set(own)
        sums = [{term.place.id for term in invariant.terms} for invariant in flat.certificate]
        self.room_of = {
            place: room
            for terms in sums
            if len(terms) == 2
            for place, room in (tuple(terms), tuple(terms)[::-1])
            if place in own and room not in own and tokens[place] + tokens[room] >= 1
            if room in touched or room == f"{place}.free"
        }
        assert touched <= set(self.room_of.values())
        self.room = Counter({room: tokens[room] for room in self.room_of.values()})
        self.overridden: dict[str, list[str]] = {t: [] for t in self.names}
        direct = {above.id: {below.id for below in above.overrides} for above in transitions(flat)}
        for _ in direct:  # what has priority over something has priority over what that overrides, too
            direct = {above: under.union(*(direct[low] for low in under)) for above, under in direct.items()}
        for above, under in direct.items():
            for low in sorted(under & self.names.keys()):
                self.overridden[low].append(above)
        self.clauses = {
            t.id: parse(t.clause.text)
            for t in transitions(node)
            if isinstance(t, sym.Transition) and t.clause is not None
        }
        self.signal_labels = {signal.id: label(signal) for signal in node.node.signals}
        self.signals = {signal.id: bool(signal.initial) for signal in node.node.signals}

    def is_enabled(self, transition: str) -> bool:
        values = {self.signal_labels[id]: value for id, value in self.signals.items()}
        clause = self.clauses.get(self.names[transition])
        held = self.marking + self.room
        return (
            all(held[place] >= weight for place, weight in self.takes[transition].items())
            and all(self.marking[place] < limit for place, limit in self.inhibitors[transition])
            and (clause is None or holds(clause, values))
        )

    def allowed(self) -> set[str]:
        enabled = {transition for transition in self.names if self.is_enabled(transition)}
        return {t for t in enabled if not enabled.intersection(self.overridden[t])}

    def fire(self, transition: str) -> None:
        assert transition in self.allowed()
        for table, sign in ((self.takes, -1), (self.puts, 1)):
            for place, weight in table[transition].items():
                (self.room if place in self.room else self.marking)[place] += sign * weight

    def arrive(self, place: str, tokens: int) -> None:
        """Let tokens come to a place, or, below 0, leave it."""
        self.marking[place] += tokens
        if place in self.room_of:
            self.room[self.room_of[place]] -= tokens

    def has_room(self, place: str) -> bool:
        return place not in self.room_of or self.room[self.room_of[place]] > 0


def holds(expression: Expression, values: dict[str, bool]) -> bool:
    match expression:
        case Signal(name=name):
            return values[name]
        case Constant(value=value):
            return value
        case Not(operand=operand):
            return not holds(operand, values)
        case And(parts=parts):
            return all(holds(part, values) for part in parts)
        case Or(parts=parts):
            return any(holds(part, values) for part in parts)
        case Implies(premise=premise, conclusion=conclusion):
            return not holds(premise, values) or holds(conclusion, values)
        case Equivalent(left=left, right=right):
            return holds(left, values) == holds(right, values)
    raise TypeError(expression)


def references(model: sym.SystemModel) -> list[tuple[rtm.RuntimeModel, ReferenceNet]]:
    return [(node, ReferenceNet(model, node)) for node in split(model)]
