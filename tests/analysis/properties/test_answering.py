"""Many properties of one net: every answer is that of an engine that looks at all markings."""

from __future__ import annotations

import random
from collections import Counter

import numpy as np
import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import explore
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.syntax import And, Exists, Finally, ForAll, Formula, Globally, Not, Or
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.portfolio import answering
from dineros.analysis.portfolio.answering import answer_properties
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.walker import Walker
from dineros.analysis.properties.property import GLOBAL_PROPERTIES, GroupedNames, Property
from tests.analysis.logic.generated import atoms_of, random_ctl, random_ltl, random_net

FEW = Budget(states=3_000)


def small_nets(rng: random.Random, count: int) -> list[CompiledNet]:
    """Nets without a transition that nothing stops: of which all markings can be seen."""
    found: list[CompiledNet] = []
    while len(found) < count:
        net = random_net(rng)
        if explore(net, Budget(states=2_000), workers=1).complete:
            found.append(net)
    return found


def goal(rng: random.Random, net: CompiledNet) -> Formula:
    atoms = atoms_of(rng, net, with_fired=False)
    one, other, third = (rng.choice(atoms) for _ in range(3))
    condition = rng.choice(
        [And((one, Not(other))), Or((And((one, third)), other)), And((Or((one, other)), third))]
    )
    return rng.choice([Exists(Finally(condition)), ForAll(Globally(Not(condition)))])


@pytest.mark.long
@pytest.mark.parametrize("few", [2, 20_000])
@pytest.mark.parametrize("seed", range(3))
def test_answers_are_those_of_one_engine(monkeypatch: pytest.MonkeyPatch, seed: int, few: int) -> None:
    monkeypatch.setattr(answering, "FEW_STATES", few)
    rng = random.Random(seed)
    techniques: Counter[str] = Counter()
    for net in small_nets(rng, 8):
        expected: dict[str, bool] = {}
        asked: list[Property] = []
        for number in range(6):
            atoms = atoms_of(rng, net, with_fired=False)
            trees: list[tuple[str, Formula]] = [
                ("ctl", random_ctl(rng, rng.randrange(2, 9), atoms)),
                ("ctl", goal(rng, net)),
                ("ltl", random_ltl(rng, rng.randrange(2, 8), atoms)),
            ]
            for kind, tree in trees:
                one = Property(f"{number}-{len(asked)}", "ltl" if kind == "ltl" else "ctl", tree)
                verdict = (
                    verify_ltl(net, tree, budget=FEW)
                    if kind == "ltl"
                    else check_ctl(net, tree, budget=FEW, engine="explicit")
                )
                assert verdict.status != "unknown"
                asked.append(one)
                expected[one.id] = verdict.status == "holds"
        answers = answer_properties(net, GroupedNames(NetNames(net)), asked, seconds=10.0, memory=1 << 28)
        for one, answer in zip(asked, answers, strict=True):
            assert answer.id == one.id
            assert answer.value in (None, expected[one.id]), (net, str(one.formula), answer)
            techniques[answer.technique] += 1
    assert techniques[""] <= 3, "nets this small leave nothing open"


@pytest.mark.long
@pytest.mark.parametrize("few", [2, 20_000])
def test_bounds_and_global_questions(monkeypatch: pytest.MonkeyPatch, few: int) -> None:
    monkeypatch.setattr(answering, "FEW_STATES", few)
    rng = random.Random(7)
    values: Counter[tuple[str, object]] = Counter()
    for net in small_nets(rng, 25):
        space = explore(net, workers=1)
        bounds = [Property(place, "bound", places=(place,)) for place in net.places]
        asked = [*bounds, *(Property(name, "global", examination=name) for name in GLOBAL_PROPERTIES)]
        answers = answer_properties(net, GroupedNames(NetNames(net)), asked, seconds=10.0, memory=1 << 28)
        found = {answer.id: answer.value for answer in answers}
        assert [found[place] for place in net.places] == list(space.largest_place)
        assert found["OneSafe"] is (max(space.largest_place) <= 1)
        assert found["ReachabilityDeadlock"] is (space.deadlocks > 0)
        assert found["QuasiLiveness"] is bool(space.enabled.all())
        live = [check_ctl(net, f'AG EF enabled("{t}")', engine="explicit").status for t in net.transitions]
        assert found["Liveness"] is all(status == "holds" for status in live)
        stable = [
            check_ctl(net, f"AG {place} == {tokens}", engine="explicit").status == "holds"
            for place, tokens in zip(net.places, net.initial.tolist(), strict=True)
        ]
        assert found["StableMarking"] is any(stable)
        values.update((name, found[name]) for name in GLOBAL_PROPERTIES)
    assert len(values) >= 8, "both answers occur"


def test_far_goals_are_found_by_walks_along_solutions_of_the_state_equation() -> None:
    net = CompiledNet.build(
        {"left": 400, "middle": 0, "right": 0},
        [
            ("go", {"left": 1}, {"middle": 1}),
            ("on", {"middle": 1}, {"right": 1}),
            ("back", {"middle": 1}, {"left": 1}),
        ],
    )
    names = GroupedNames(NetNames(net))
    asked = [Property("most", "bound", places=("right", "middle"))]
    (answer,) = answer_properties(net, names, asked, seconds=60.0, memory=1 << 28)
    assert answer.value == 400


@pytest.mark.long
def test_an_unbounded_net_is_answered_where_a_part_tells() -> None:
    net = CompiledNet.build({"a": 1, "b": 0}, [("t", {"a": 1}, {"a": 1, "b": 1})])
    asked = [
        Property("many", "ctl", Exists(Finally(Not(atom))))
        for atom in atoms_of(random.Random(1), net, with_fired=False)[:1]
    ]
    asked += [Property(name, "global", examination=name) for name in GLOBAL_PROPERTIES]
    answers = {
        a.id: a.value for a in answer_properties(net, GroupedNames(NetNames(net)), asked, 5.0, 1 << 27)
    }
    assert answers["OneSafe"] is False
    assert answers["QuasiLiveness"] is True
    assert answers["StableMarking"] is True
    assert np.all([value is not None for name, value in answers.items() if name == "OneSafe"])


def test_walks_note_only_what_a_marking_enables() -> None:
    """Halfway through `back`, both places have what `never` asks for; no marking has."""
    transitions = [
        ("go", {"a": 1}, {"b": 1}),
        ("back", {"b": 1}, {"a": 1}),
        ("never", {"a": 2, "b": 2}, {"a": 4}),
        ("late", {"b": 3}, {"b": 3}),
    ]
    walker = Walker(CompiledNet.build({"a": 3, "b": 0}, transitions))
    walker.walk()
    assert walker.fired.tolist() == [True, True, False, True]
