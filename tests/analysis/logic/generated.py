"""Generated formulas, words and nets for differential tests."""

from __future__ import annotations

import random

from dineros.analysis.logic.language.syntax import (
    FALSE,
    TRUE,
    And,
    Atom,
    Comparison,
    Deadlock,
    Enabled,
    Equivalent,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Implies,
    Name,
    Next,
    Not,
    Or,
    Release,
    Until,
    WeakUntil,
)
from dineros.analysis.nets.compiled import CompiledNet, Transition

PROPOSITIONS: list[Atom] = [Comparison(((1, Name(letter)),), ">=", 1) for letter in "abc"]
UNARY = [Not, Finally, Globally, Next]
BINARY = [Until, Release, WeakUntil, And, Or, Implies, Equivalent]

Letter = frozenset[Atom]


def random_ltl(rng: random.Random, size: int, atoms: list[Atom], with_next: bool = True) -> Formula:
    """An LTL formula of about `size` operators and atoms."""
    if size <= 1:
        return rng.choice([TRUE, FALSE]) if rng.random() < 0.05 else rng.choice(atoms)
    operator = rng.choice([*UNARY[: 4 if with_next else 3], *BINARY])
    if operator in UNARY:
        return operator(random_ltl(rng, size - 1, atoms, with_next))
    left = rng.randrange(1, size)
    parts = (
        random_ltl(rng, left, atoms, with_next),
        random_ltl(rng, max(1, size - 1 - left), atoms, with_next),
    )
    return operator(parts) if operator in (And, Or) else operator(*parts)


def random_ctl(rng: random.Random, size: int, atoms: list[Atom]) -> Formula:
    """A CTL formula of about `size` operators and atoms."""
    if size <= 1:
        return rng.choice([TRUE, FALSE]) if rng.random() < 0.05 else rng.choice(atoms)
    operator = rng.choice([*UNARY, *BINARY])
    quantifier = rng.choice([ForAll, Exists])
    if operator is Not:
        return Not(random_ctl(rng, size - 1, atoms))
    if operator in UNARY:
        return quantifier(operator(random_ctl(rng, size - 1, atoms)))
    left = rng.randrange(1, size)
    parts = (random_ctl(rng, left, atoms), random_ctl(rng, max(1, size - 1 - left), atoms))
    if operator in (And, Or):
        return operator(parts)
    formula = operator(*parts)
    return formula if operator in (Implies, Equivalent) else quantifier(formula)


def random_word(rng: random.Random, atoms: list[Atom]) -> tuple[list[Letter], list[Letter]]:
    """Stem and loop of a word."""

    def letters(count: int) -> list[Letter]:
        return [frozenset(atom for atom in atoms if rng.random() < 0.5) for _ in range(count)]

    return letters(rng.randrange(0, 4)), letters(rng.randrange(1, 4))


def random_net(rng: random.Random, inhibitors: bool = True) -> CompiledNet:
    """A small net with weights, read and inhibitor arcs; it may be unbounded."""
    places = {f"p{i}": rng.choice([0, 0, 1, 1, 2]) for i in range(rng.randrange(2, 6))}
    names = list(places)

    def arcs(most: int) -> dict[str, int]:
        chosen = rng.sample(names, min(len(names), rng.randrange(0, most + 1)))
        return {name: rng.choice([1, 1, 1, 2]) for name in chosen}

    transitions = []
    for i in range(rng.randrange(1, 7)):
        inputs, outputs = arcs(2), arcs(2)
        if sum(outputs.values()) > sum(inputs.values()) and rng.random() < 0.8:
            inputs, outputs = outputs, inputs
        blocked = arcs(1) if inhibitors and rng.random() < 0.3 else {}
        reads = arcs(1) if rng.random() < 0.2 else {}
        transitions.append(Transition(f"t{i}", inputs, outputs, blocked, reads))
    return CompiledNet.build(places, transitions)


def atoms_of(rng: random.Random, net: CompiledNet, with_fired: bool) -> list[Atom]:
    """A few atoms about a net."""
    atoms: list[Atom] = [Deadlock()]
    for _ in range(3):
        terms = tuple(
            (rng.choice([1, 1, 2, -1]), Name(p)) for p in rng.sample(net.places, rng.randrange(1, 3))
        )
        atoms.append(Comparison(terms, rng.choice(["<=", ">=", "==", "!=", "<", ">"]), rng.randrange(0, 3)))
    kinds = [Enabled, Fired] if with_fired else [Enabled]
    atoms += [rng.choice(kinds)(Name(rng.choice(net.transitions))) for _ in range(3)]
    return atoms
