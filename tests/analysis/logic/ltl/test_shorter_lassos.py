"""Shorter counterexamples: only the part of the product in which a shorter run can be is searched."""

from __future__ import annotations

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.graphs.product import Product
from dineros.analysis.logic.language.atoms import BoundAtoms
from dineros.analysis.logic.language.combining import combined, condition_of
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.ltl.lassos import ProductRun
from dineros.analysis.logic.ltl.shorter_lassos import shortened
from dineros.analysis.nets.compiled import CompiledNet

SWITCHES = 14


def product_of_switches(text: str) -> Product:
    """Return the product of switches, which have 2^14 markings, with the negation of a formula."""
    places = {"never": 0}
    transitions: list[tuple[object, ...]] = []
    for k in range(SWITCHES):
        places |= {f"off{k}": 1, f"on{k}": 0}
        transitions.append((f"up{k}", {f"off{k}": 1}, {f"on{k}": 1}))
        transitions.append((f"down{k}", {f"on{k}": 1}, {f"off{k}": 1}))
    net = CompiledNet.build(places, transitions)
    tree = parse(text)
    atoms = BoundAtoms(net, tree, NetNames(net))
    automaton = translate(negated(combined(tree)))
    conditions = [condition_of(atom, atoms.conditions) for atom in automaton.atoms]
    return Product(net, automaton, conditions, (), (), Budget(1 << 26))


def test_what_is_farther_away_than_the_run_is_long_is_not_searched() -> None:
    product = product_of_switches("F never >= 1")
    # All switches but one go up and down.
    ups = tuple(range(0, 6, 2))
    found = shortened(ProductRun((), (*ups, *(t + 1 for t in ups))), product, 20_000)
    assert (len(found.stem), len(found.loop)) == (0, 2)
    assert product.states < 1 << SWITCHES
    near = product_of_switches("F never >= 1")
    shortened(ProductRun((), (0, 1)), near, 20_000)
    assert near.states < 2_000


def test_a_shorter_run_is_found_at_each_distance() -> None:
    for ups in range(1, 5):
        text = f"F never >= 1 | F G !({' & '.join(f'on{k} = 1' for k in range(ups))})"
        loop = tuple(2 * k for k in range(ups + 2))
        given = ProductRun((), (*loop, *(t + 1 for t in loop)))
        found = shortened(given, product_of_switches(text), 20_000)
        assert found.stem == ()
        assert sorted(found.loop) == list(range(2 * ups))
