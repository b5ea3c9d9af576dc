"""Rewriting and translation of LTL against its meaning on words, and against the automata of Spin."""

from __future__ import annotations

import itertools
import random
import re
import subprocess

import pytest

from dineros.analysis.logic.automata.automaton import Automaton, Edge
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import implies, negated, simplified
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import And, Atom, Formula, Not, Or
from tests.analysis.logic.generated import PROPOSITIONS, Letter, random_ltl, random_word
from tests.analysis.logic.reference_ltl import accepts_word
from tests.support.programs.system_packages import needs

TWO = PROPOSITIONS[:2]


def _is_true(atom: Atom, letter: Letter) -> bool:
    return atom in letter


def _short_words(atoms: list[Atom], stem: int, loop: int) -> list[tuple[list[Letter], list[Letter]]]:
    """All words up to a length."""
    alphabet = [
        frozenset(chosen) for k in range(len(atoms) + 1) for chosen in itertools.combinations(atoms, k)
    ]
    return [
        (list(first), list(again))
        for i in range(stem + 1)
        for j in range(1, loop + 1)
        for first in itertools.product(alphabet, repeat=i)
        for again in itertools.product(alphabet, repeat=j)
    ]


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_rewriting_keeps_the_meaning(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(400):
        formula = random_ltl(rng, rng.randrange(1, 14), PROPOSITIONS)
        small, opposite = simplified(formula), negated(formula)
        other = simplified(random_ltl(rng, rng.randrange(1, 6), PROPOSITIONS))
        for _ in range(20):
            stem, loop = random_word(rng, PROPOSITIONS)
            value = holds_on_lasso(formula, stem, loop, _is_true)
            assert holds_on_lasso(small, stem, loop, _is_true) == value, formula
            assert holds_on_lasso(opposite, stem, loop, _is_true) != value, formula
            if value and implies(small, other):
                assert holds_on_lasso(other, stem, loop, _is_true), (small, other)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_automata_accept_what_satisfies_the_formula(seed: int) -> None:
    rng = random.Random(seed)
    for _ in range(120):
        formula = random_ltl(rng, rng.randrange(1, 12), PROPOSITIONS)
        automaton, opposite = translate(formula), translate(Not(formula))
        for _ in range(15):
            stem, loop = random_word(rng, PROPOSITIONS)
            value = holds_on_lasso(formula, stem, loop, _is_true)
            assert accepts_word(automaton, stem, loop) == value, formula
            assert accepts_word(opposite, stem, loop) != value, formula


def test_automata_on_all_short_words() -> None:
    rng = random.Random(0)
    words = _short_words(TWO, 1, 2)
    for _ in range(40):
        formula = random_ltl(rng, rng.randrange(2, 8), TWO)
        automaton = translate(formula)
        for stem, loop in words:
            assert accepts_word(automaton, stem, loop) == holds_on_lasso(formula, stem, loop, _is_true), (
                formula
            )


@pytest.mark.parametrize(
    ("text", "states"),
    [
        ("G F a >= 1", 1),
        ("F G a >= 1", 2),
        ("F a >= 1", 2),
        ("a >= 1 U b >= 1", 2),
        ("G (a >= 1 -> F b >= 1)", 2),
        ("!G (a >= 1 -> F b >= 1)", 2),
        ("GF a >= 1 & GF b >= 1 & GF c >= 1", 1),
        ("(GF a >= 1 & GF b >= 1 -> GF c >= 1) & false", 1),
    ],
)
def test_common_formulas_have_small_automata(text: str, states: int) -> None:
    assert len(translate(parse(text)).edges) == states


def test_an_automaton_can_be_too_large() -> None:
    """What is due later is a set of eventualities, any of 2^61; that is said before memory runs out."""
    with pytest.raises(FormulaError, match="automaton of the formula is too large"):
        translate(parse(" & ".join(f"F p{i} >= 1" for i in range(61))))


def _spin_text(formula: Formula) -> str:
    names = {str(atom): str(atom)[0] for atom in PROPOSITIONS}
    text = str(formula)
    for printed, name in names.items():
        text = text.replace(printed, name)
    for ours, theirs in (("G", "[]"), ("F", "<>"), ("R", "V"), ("&", "&&"), ("|", "||")):
        text = text.replace(f"{ours} ", f"{theirs} ").replace(f"{ours}(", f"{theirs}(")
    return text


def _never_claim(formula: Formula) -> Automaton:
    """Spin's Buchi automaton; a state's acceptance stands on its outgoing edges here."""
    text = subprocess.run(
        ["spin", "-f", _spin_text(formula)], capture_output=True, text=True, check=True, timeout=60
    ).stdout
    bodies: list[list[tuple[str, str]]] = []
    position: dict[str, int] = {}
    accepting: set[int] = set()
    was_label = False
    for line in (raw.split("/*")[0].strip() for raw in text.splitlines()):
        if match := re.fullmatch(r"(\w+):", line):
            # Labels one after the other are names of one state.
            if not was_label:
                bodies.append([])
            position[match[1]] = len(bodies) - 1
            if match[1].startswith("accept"):
                accepting.add(len(bodies) - 1)
        elif match := re.fullmatch(r":: \((.*)\) -> goto (\w+)", line):
            bodies[-1].append((match[1], match[2]))
        elif match := re.fullmatch(r":: atomic \{ \((.*)\) -> assert\(.*\) \}", line):
            # Leaving the loop runs into the next state, which is accept_all.
            bodies[-1].append((match[1], "accept_all"))
        elif line == "skip":
            bodies[-1].append(("1", "accept_all"))
        else:
            assert line in ("do", "od;", "}", "false;", "") or line.startswith("never"), line
        was_label = match is not None and line.endswith(":")
    rows = tuple(
        tuple(
            Edge(positive, negative, int(state in accepting), position[target])
            for guard, target in body
            for positive, negative in _cubes(guard)
        )
        for state, body in enumerate(bodies)
    )
    return Automaton(tuple(PROPOSITIONS), 1, 0, rows)


def _cubes(guard: str) -> list[tuple[int, int]]:
    """Letters that satisfy a guard, each as a cube."""
    code = guard.replace("&&", " and ").replace("||", " or ").replace("!", " not ")
    found = []
    for letter in range(8):
        values = {name: bool(letter >> i & 1) for i, name in enumerate("abc")}
        if eval(code, {"__builtins__": {}}, {**values, "true": True, "false": False}):
            found.append((letter, 7 & ~letter))
    return found


def _intersection_is_empty(left: Automaton, right: Automaton) -> bool:
    """Whether no word is accepted by both; exact."""
    # Letters of `left` in the order of `right`'s atoms.
    rows: dict[tuple[int, int], list[Edge]] = {}
    index = {(left.initial, right.initial): 0}
    todo = [(left.initial, right.initial)]
    bit = [PROPOSITIONS.index(atom) for atom in left.atoms]

    def moved(bits: int) -> int:
        return sum(1 << bit[i] for i in range(len(bit)) if bits >> i & 1)

    while todo:
        pair = todo.pop()
        rows[pair] = []
        for one in left.edges[pair[0]]:
            for other in right.edges[pair[1]]:
                positive = moved(one.positive) | other.positive
                negative = moved(one.negative) | other.negative
                if positive & negative:
                    continue
                target = (one.target, other.target)
                if target not in index:
                    index[target] = len(index)
                    todo.append(target)
                marks = one.marks | other.marks << left.marks
                rows[pair].append(Edge(positive, negative, marks, index[target]))
    edges = tuple(tuple(rows[pair]) for pair in index)
    product = Automaton(right.atoms, left.marks + right.marks, 0, edges)
    for component in product.components():
        inside = set(component)
        found = [edge.marks for state in component for edge in edges[state] if edge.target in inside]
        union = 0
        for marks in found:
            union |= marks
        if found and union == product.all_marks:
            return False
    return True


@pytest.mark.long
@needs("spin")
@pytest.mark.parametrize("seed", range(4))
def test_automata_agree_with_spin(seed: int) -> None:
    # Debian's Spin knows no X. Ours for f and Spin's for !f share no word, and the other way round; what ours
    # for f might lack, words show.
    rng = random.Random(seed)
    for _ in range(60):
        formula = random_ltl(rng, rng.randrange(2, 9), PROPOSITIONS, with_next=False)
        plain = _without_weak_until(simplified(formula))
        if not any(isinstance(part, Atom) for part in plain.subformulas()) or len(str(plain)) < 8:
            continue
        ours, ours_not = translate(formula), translate(Not(formula))
        theirs, theirs_not = _never_claim(plain), _never_claim(Not(plain))
        assert _intersection_is_empty(ours, theirs_not), formula
        assert _intersection_is_empty(ours_not, theirs), formula
        for _ in range(10):
            stem, loop = random_word(rng, PROPOSITIONS)
            assert accepts_word(ours, stem, loop) == accepts_word(theirs, stem, loop), formula


def _without_weak_until(formula: Formula) -> Formula:
    """The same formula with binary conjunctions, as Spin's grammar has them."""
    parts = tuple(_without_weak_until(operand) for operand in formula.operands)
    if isinstance(formula, And | Or) and len(parts) > 2:
        result = parts[0]
        for part in parts[1:]:
            result = type(formula)((result, part))
        return result
    return formula.with_operands(parts)
