"""Formulas of more atoms than a machine word has bits, and conditions with a lot of boolean structure."""

from __future__ import annotations

import random

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.logic.language.combining import Combination, combined
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import And, Atom, Finally, Fired, Formula, Not, Or
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.portfolio.branching_time import Engine, check_ctl

COUNT = 150
#: A ring of places with one token, and a place that is never marked beside each.
RING = CompiledNet.build(
    {**{f"p{i}": int(i == 0) for i in range(COUNT)}, **{f"q{i}": 0 for i in range(COUNT)}},
    [(f"t{i}", {f"p{i}": 1}, {f"p{(i + 1) % COUNT}": 1}) for i in range(COUNT)],
)

_ENGINES: tuple[Engine, ...] = ("explicit", "symbolic")


def both(formula: str) -> list[str]:
    ctl: list[str] = [
        check_ctl(RING, formula.replace("G ", "AG ").replace("F ", "AF "), engine=engine).status
        for engine in _ENGINES
    ]
    return [*ctl, verify_ltl(RING, formula).status]


@pytest.mark.long
@pytest.mark.parametrize("count", [60, 61, 62, 63, 64, 65, COUNT])
def test_as_many_atoms_as_are_asked(count: int) -> None:
    some = " | ".join(f"p{i} >= 1" for i in range(count))
    never = " & ".join(f"q{i} == 0" for i in range(count))
    complete = count == COUNT
    assert both(f"G ({some})") == ["holds" if complete else "violated"] * 3
    assert both(f"G ({never})") == ["holds"] * 3
    assert both(f"F ({some} & {never})") == ["holds"] * 3


@pytest.mark.long
def test_as_many_eventualities_as_are_asked() -> None:
    """One acceptance mark each, in several words."""
    every = " & ".join(f"G F p{i} >= 1" for i in range(70))
    assert verify_ltl(RING, every).status == "holds"
    verdict = verify_ltl(RING, f"{every} & G F q69 >= 1")
    assert verdict.status == "violated"


def test_as_many_steps_as_are_asked() -> None:
    fired = " | ".join(f"fired(t{i})" for i in range(COUNT))
    assert verify_ltl(RING, f"G ({fired})").status == "holds"
    assert verify_ltl(RING, f"G ({fired.replace('fired(t99)', 'false')})").status == "violated"


@pytest.mark.long
def test_a_marking_of_many_conditions_is_found() -> None:
    """More conjunctions than are searched for one by one, of more atoms than a word has bits."""
    pairs = " & ".join(f"(p{i} >= 1 | q{i} == 0)" for i in range(COUNT))
    answer = find_marking(RING, f"{pairs} & p70 >= 1", NetNames(RING), Budget(1 << 28))
    assert answer.status == "reachable"
    assert answer.trace == tuple(range(70))
    unreachable = " & ".join(f"(p{i} >= 1 | q{i} >= 1)" for i in range(COUNT))
    assert find_marking(RING, unreachable, NetNames(RING), Budget(1 << 28)).status == "unreachable"


def test_a_search_gives_up_in_time() -> None:
    grows = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"a": 1, "b": 1})])
    for condition in ("b >= 1 & a >= 2", " & ".join(f"(b >= {i} | a >= 2)" for i in range(9)) + " & a >= 2"):
        answer = find_marking(grows, condition, NetNames(grows), Budget(1 << 30, seconds=0.2))
        assert answer.status != "reachable"


def test_what_is_taken_together() -> None:
    many = " & ".join(f"p{i} >= 1" for i in range(9))
    formula = combined(parse(f"G (({many}) -> F (p1 >= 1 | p2 >= 1)) & fired(t1)"))
    atoms = [part for part in formula.subformulas() if isinstance(part, Atom)]
    assert [type(atom) for atom in atoms].count(Combination) == 1
    assert sum(isinstance(atom, Fired) for atom in atoms) == 1
    assert combined(parse(f"F !({many})")).operands == (Combination(parse(f"!({many})")),)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_taking_together_keeps_the_meaning(seed: int) -> None:
    """A combination's value by the definition is that of its formula."""
    rng = random.Random(seed)
    atoms = [parse(f"a{i} >= 1") for i in range(8)]

    def condition(depth: int) -> Formula:
        if depth == 0:
            return rng.choice(atoms)
        kind = rng.choice([And, Or, Not])
        return (
            Not(condition(depth - 1))
            if kind is Not
            else kind((condition(depth - 1), condition(depth - 1), rng.choice(atoms)))
        )

    for _ in range(100):
        formula = Or((Finally(condition(4)), condition(3), Not(Finally(condition(2)))))
        grouped = combined(formula)

        def value(atom: Atom, letter: frozenset[Formula]) -> bool:
            if isinstance(atom, Combination):
                return holds_on_lasso(atom.formula, [], [letter], value)
            return atom in letter

        for _ in range(10):
            letters = [frozenset(rng.sample(atoms, rng.randrange(8))) for _ in range(3)]
            assert holds_on_lasso(formula, letters[:2], letters[2:], value) == holds_on_lasso(
                grouped, letters[:2], letters[2:], value
            )


@pytest.mark.parametrize("seed", range(3))
def test_combinations_are_evaluated_as_they_stand(seed: int) -> None:
    """The kernels' value of a condition, against the symbolic engine, which knows no combinations."""
    rng = random.Random(seed)
    net = CompiledNet.build(
        {f"p{i}": 2 * (i == 0) for i in range(6)},
        [(f"t{i}", {f"p{i}": 1}, {f"p{(i + 1) % 6}": 1}) for i in range(6)],
    )

    def condition(depth: int) -> str:
        if depth == 0:
            kind = rng.randrange(4)
            place = rng.randrange(6)
            return [f"p{place} >= {rng.randrange(3)}", f"enabled(t{place})", "deadlock", "true"][
                kind if kind < 2 or rng.random() < 0.2 else 0
            ]
        operator = rng.choice(["&", "|", "->", "<->", "!"])
        if operator == "!":
            return f"!({condition(depth - 1)})"
        return f"(({condition(depth - 1)}) {operator} ({condition(depth - 1)}))"

    for _ in range(15):
        text = condition(4)
        wanted = check_ctl(net, f"AG {text}", engine="symbolic").status
        assert verify_ltl(net, f"G {text}").status == wanted, text
        found = find_marking(net, f"!{text}", NetNames(net), Budget(1 << 26)).status
        assert (found == "reachable") == (wanted == "violated"), text
