"""Random models whose clauses speak of signals with values, and an interpreter of their meaning.

The interpreter evaluates clauses as they were drawn, not their normal form, and has a value for each signal.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step

Settings = dict[str, bool | str]
Meaning = Callable[[Settings], bool]
SIGNALS: dict[str, tuple[str, ...]] = {
    "Door": (),
    "Mode": ("idle", "moving", "broken"),
    "Lamp": ("red", "green"),
}


@dataclass
class Drawn:
    """A model, and by transition what it takes, puts, and what its clause means."""

    model: sym.SystemModel
    steps: dict[str, tuple[list[str], list[str]]] = field(default_factory=dict)
    clauses: dict[str, Meaning] = field(default_factory=dict)
    tokens: dict[str, int] = field(default_factory=dict)
    start: Settings = field(default_factory=dict)

    def settings(self, signal: str) -> tuple[bool | str, ...]:
        """Return what a signal can be."""
        return SIGNALS[signal] or (False, True)

    def used(self) -> set[str]:
        """Return the signals that the normal form of a clause has."""
        return {str(each.signal.id) for each in self.model.eAllContents() if isinstance(each, sym.Literal)}

    def users(self, signal: str) -> list[str]:
        """Return the transitions whose clause tests a signal."""
        return [
            str(each.disjunction.eContainer().transition.id)  # type: ignore[union-attr]
            for each in self.model.eAllContents()
            if isinstance(each, sym.Literal) and each.signal.id == signal
        ]

    def enabled(self, tokens: dict[str, int], settings: Settings) -> set[str]:
        """Return the transitions that may fire."""
        return {
            name
            for name, (taken, _) in self.steps.items()
            if all(tokens[each] for each in taken) and self.clauses[name](settings)
        }

    def states(self, variant: str) -> set[tuple[tuple[int, ...], tuple[bool | str, ...]]]:
        """Return all reachable tokens of places and values of used signals."""
        used = sorted(self.used())
        first = tuple(self.tokens.values()), tuple(self.start[each] for each in used)
        found, todo = {first}, [first]
        while todo:
            counts, values = todo.pop()
            tokens = dict(zip(self.tokens, counts, strict=True))
            settings = {**self.start, **dict(zip(used, values, strict=True))}
            for after in self._after(tokens, settings, used, variant):
                if after not in found:
                    found.add(after)
                    todo.append(after)
        return found

    def _after(
        self, tokens: dict[str, int], settings: Settings, used: list[str], variant: str
    ) -> Iterator[tuple[tuple[int, ...], tuple[bool | str, ...]]]:
        values = tuple(settings[each] for each in used)
        for name in self.enabled(tokens, settings):
            after = dict(tokens)
            for each in self.steps[name][0]:
                after[each] -= 1
            for each in self.steps[name][1]:
                after[each] += 1
            yield tuple(after.values()), values
        for number, signal in enumerate(used):
            if variant != "fully-enabled" and not any(
                all(tokens[each] for each in self.steps[user][0])
                or (variant == "io-enabled" and all(tokens[each] for each in self.steps[user][1]))
                for user in self.users(signal)
            ):
                continue
            for value in self.settings(signal):
                yield tuple(tokens.values()), (*values[:number], value, *values[number + 1 :])


def drawn(seed: int) -> Drawn:
    """Return a random model with one node."""
    dice = random.Random(seed)
    model = sym.SystemModel(id="drawn")
    node = node_net(model, "node", SIGNALS)
    found = Drawn(model)
    places = {}
    for number in range(3):
        tokens = dice.choice([0, 0, 1, 2])
        places[f"P{number}"] = place(node, f"P{number}", tokens=tokens)
        found.tokens[f"P{number}"] = tokens
    for number in range(4):
        taken, put = (dice.sample(sorted(places), 1) for _ in range(2))
        text, meaning = _clause(dice, 3)
        name = f"T{number}"
        step(node, name, [places[each] for each in taken], [places[each] for each in put], clause=text)
        found.steps[name], found.clauses[name] = (taken, put), meaning
    for signal in node.signals:
        values = SIGNALS[signal.id]
        found.start[signal.id] = dice.choice(found.settings(signal.id))
        if values:
            signal.start = str(found.start[signal.id])
        else:
            signal.initial = bool(found.start[signal.id])
    return found


def _clause(dice: random.Random, depth: int) -> tuple[str, Meaning]:
    if depth == 0 or dice.random() < 0.25:
        signal = dice.choice(sorted(SIGNALS))
        if not SIGNALS[signal]:
            return signal, lambda settings: settings[signal] is True
        value, sign = dice.choice(SIGNALS[signal]), dice.choice(["=", "<>"])
        return f"{signal} {sign} '{value}'", lambda settings: (settings[signal] == value) is (sign == "=")
    if dice.random() < 0.2:
        text, meaning = _clause(dice, depth - 1)
        return f"!({text})", lambda settings: not meaning(settings)
    (left, one), (right, other) = _clause(dice, depth - 1), _clause(dice, depth - 1)
    sign = dice.choice(["&", "|", "->", "<->"])
    meanings: dict[str, Meaning] = {
        "&": lambda settings: one(settings) and other(settings),
        "|": lambda settings: one(settings) or other(settings),
        "->": lambda settings: not one(settings) or other(settings),
        "<->": lambda settings: one(settings) == other(settings),
    }
    return f"({left}) {sign} ({right})", meanings[sign]
