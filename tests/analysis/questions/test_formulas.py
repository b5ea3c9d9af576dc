"""Formulas that are split and asked as goals, against plain searches; and who answers."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.answers.outcome import Outcome
from dineros.analysis.logic.automata.translation import translate
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.rewriting import negated
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import (
    And,
    Exists,
    Finally,
    Fired,
    ForAll,
    Formula,
    Globally,
    Implies,
    Name,
    Not,
    Or,
)
from dineros.analysis.logic.verdicts.faults import check_fault, faulty_beginning
from dineros.analysis.logic.verdicts.verdict import ReplayError, check_counterexample
from dineros.analysis.model.subject import Subject
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio import asking
from dineros.analysis.portfolio.asking import find_marking
from dineros.analysis.portfolio.branching_time import check_ctl
from dineros.analysis.portfolio.plans import FIND
from dineros.analysis.portfolio.scheduler import Turn
from dineros.analysis.questions import formulas
from dineros.analysis.questions.engines import ENGINES
from dineros.analysis.questions.formulas import verify_branching, verify_linear
from dineros.analysis.questions.needed_fairness import NeededFairness, needed_fairness
from dineros.analysis.questions.net_questions import Linear
from dineros.metamodel import pn
from tests.analysis import classic_nets as classic
from tests.analysis.logic.generated import atoms_of, random_ctl, random_ltl, random_net
from tests.analysis.logic.reference_ltl import has_counterexample, reachability_graph
from tests.analysis.strategies import nets

LIMITS = Budget(1 << 26, seconds=20)


@pytest.fixture(params=[1, 20_000])
def near(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> int:
    """Markings of the first search: with one, the engines behind it answer."""
    plan = [
        replace(turn, most_states=request.param) if isinstance(turn, Turn) and turn.most_states else turn
        for turn in FIND
    ]
    monkeypatch.setattr(asking, "FIND", plan)
    monkeypatch.setattr(formulas, "NEAR_STATES", request.param if request.param > 1 else 0)
    return int(request.param)


def condition_of(rng: random.Random, net: CompiledNet) -> Formula:
    one, other, third = (rng.choice(atoms_of(rng, net, with_fired=False)) for _ in range(3))
    return rng.choice([one, Not(one), And((one, Not(other))), Or((And((one, third)), other))])


def check_shown(
    net: CompiledNet,
    formula: Formula,
    answer: Outcome,
    weak: Sequence[int] = (),
    strong: Sequence[int] = (),
) -> None:
    """Check what shows that a formula is violated: a beginning of a run, or a whole run."""
    if answer.ends_at_fault:
        assert not answer.loop
        check_fault(net, formula, NetNames(net), answer.stem)
    else:
        bound = BoundAtoms(net, formula, NetNames(net))
        check_counterexample(net, formula, bound, answer.stem, answer.loop, weak, strong)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_linear_time_under_fairness(near: int, seed: int) -> None:
    rng = random.Random(seed)
    seen: Counter[tuple[str, str]] = Counter()
    for _ in range(60):
        net = random_net(rng)
        graph = reachability_graph(net, 200)
        if graph is None:
            continue
        atoms = atoms_of(rng, net, with_fired=True)
        parts: list[Formula] = [Globally(condition_of(rng, net)) for _ in range(rng.randrange(1, 3))]
        if rng.random() < 0.5:
            fired = Fired(Name(rng.choice(net.transitions)))
            condition = condition_of(rng, net)
            when_fired = rng.choice([Implies(fired, condition), Not(And((condition, fired)))])
            parts = [*parts[1:], Globally(when_fired)]
        if rng.random() < 0.5:
            parts.append(random_ltl(rng, rng.randrange(2, 6), atoms))
        formula = And(tuple(parts))
        fair = [rng.sample(net.transitions, rng.randrange(0, 2)) for _ in range(2)]
        weak, strong = ([net.transitions.index(name) for name in names] for names in fair)
        bound = BoundAtoms(net, formula, NetNames(net))
        is_violated = has_counterexample(net, graph, translate(negated(formula)), bound, weak, strong)
        answer = verify_linear(net, formula, NetNames(net), fair[0], fair[1], LIMITS)
        assert answer.status == ("violated" if is_violated else "holds"), (net, str(formula), fair, answer)
        if is_violated:
            check_shown(net, formula, answer, weak, strong)
        seen[answer.status, answer.by] += 1
    assert len({status for status, _ in seen}) == 2
    assert near > 1 or len({by for _, by in seen}) >= 2


COUNTED = CompiledNet.build(
    {"idle": 1, "bad": 0, "log": 0},
    [
        Transition("stay", {"idle": 1}, {"idle": 1, "log": 1}),
        Transition("go", {"idle": 1}, {"bad": 1, "log": 1}),
        Transition("back", {"bad": 1}, {"idle": 1, "log": 1}),
    ],
)
"""Whatever is fired, a token is added to the log."""


@pytest.mark.parametrize("formula", ["G (bad = 0)", "G (log < 3)", "G (bad = 0) & F (log >= 2)"])
@pytest.mark.parametrize("fair", [(), ("back",)])
def test_a_violated_condition_where_every_way_on_must_grow(formula: str, fair: tuple[str, ...]) -> None:
    answer = verify_linear(COUNTED, formula, NetNames(COUNTED), fair, (), LIMITS)
    assert (answer.status, answer.ends_at_fault) == ("violated", True)
    check_shown(COUNTED, parse(formula), answer)


@pytest.mark.long
def test_a_condition_on_more_tokens_than_are_replayed_in_loops() -> None:
    answer = verify_linear(COUNTED, "G (log < 30000)", NetNames(COUNTED), (), (), LIMITS)
    assert (answer.status, len(answer.stem)) == ("violated", 30_000)


@pytest.mark.parametrize(
    ("formula", "length"),
    [
        ("G (bad = 0)", 1),
        ("G (log < 6)", 6),
        ("G !fired(back)", 2),
        ("G (bad = 1 -> X (log = 0))", 2),
        ("(bad = 0) W (log >= 3)", 1),
        ("G (fired(go) -> X X (bad = 1))", 2),
        ("log >= 1", 0),
        ("G (bad = 0) & G F fired(stay)", 1),
    ],
)
def test_a_witness_ends_at_the_fault(formula: str, length: int) -> None:
    answer = verify_linear(COUNTED, formula, NetNames(COUNTED), (), (), LIMITS)
    assert (answer.status, answer.loop, answer.ends_at_fault) == ("violated", (), True)
    assert len(answer.stem) == length


@pytest.mark.parametrize("formula", ["F (bad = 1)", "G F fired(go)", "F G (bad = 0)"])
def test_a_run_that_violates_only_as_a_whole_goes_on_for_ever(formula: str) -> None:
    answer = verify_linear(COUNTED, formula, NetNames(COUNTED), (), (), LIMITS)
    assert (answer.status, answer.ends_at_fault) == ("violated", False)
    check_shown(COUNTED, parse(formula), answer)


@pytest.mark.long
@pytest.mark.parametrize("seed", range(4))
def test_whatever_follows_a_fault_violates_the_formula(seed: int) -> None:
    """A beginning that is said to violate a formula does so with each loop that continues from it."""
    rng, seen = random.Random(seed), Counter[bool]()
    for _ in range(400):
        net = random_net(rng)
        formula = random_ltl(rng, rng.randrange(2, 8), atoms_of(rng, net, with_fired=True))
        names = NetNames(net)
        bound = BoundAtoms(net, formula, names)
        firings, steps, marking = [], [], tuple(net.initial.tolist())
        for _ in range(12):
            able = [t for t in range(len(net.transitions)) if net.is_enabled(t, marking)]
            if not able:
                break
            firings.append(rng.choice(able))
            steps.append(Step(marking, firings[-1]))
            marking = tuple(net.fire(firings[-1], marking))
        length = faulty_beginning(net, formula, names, firings)
        seen[length is not None] += 1
        if length is None:
            continue
        # Whatever follows, the marking after the firings comes first; what is fired there may be anything.
        there = steps[length].marking if length < len(steps) else marking
        for _ in range(10):
            fired = rng.choice([None, *range(len(net.transitions))])
            rest = rng.choices([*steps, Step(marking, None)], k=rng.randrange(1, 5))
            beginning = [*steps[:length], Step(there, fired)]
            assert not holds_on_lasso(formula, beginning, rest, bound.is_true), (net, str(formula), firings)
    assert min(seen[True], seen[False]) > 20


def test_a_witness_that_does_not_replay_is_no_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    def wrong(*_: object) -> None:
        raise ReplayError("the witness fires 't', which is not enabled")

    monkeypatch.setattr("dineros.analysis.logic.ltl.verification.check_counterexample", wrong)
    question = Linear(COUNTED, NetNames(COUNTED), "F G (bad = 0)")
    answer = ENGINES["auto"].answer(question, LIMITS)
    assert (answer.status, answer.trace) == ("unknown", None)
    assert "the witness fires 't', which is not enabled" in answer.reason


GROWS = CompiledNet.build(
    {"start": 1, "on": 0, "grown": 0},
    [
        Transition("begin", {"start": 1}, {"on": 1}),
        Transition("grow", {"on": 1}, {"on": 1, "grown": 1}),
        Transition("shrink", {"grown": 3}, {"grown": 1}),
    ],
)


@pytest.mark.parametrize(
    ("formula", "status"),
    [
        ("G (fired(begin) -> grown = 0)", "holds"),
        ("G !(fired(begin) & grown >= 1 & on >= 1)", "holds"),
        ("G (fired(shrink) -> grown <= 5)", "violated"),
    ],
)
def test_what_holds_when_a_transition_fires_is_proved_without_all_markings(formula: str, status: str) -> None:
    """There is no end of markings: the automaton's product would grow until time or memory is spent."""
    answer = verify_linear(GROWS, formula, NetNames(GROWS), budget=Budget(1 << 26, seconds=60))
    assert answer.status == status
    if status == "violated":
        check_shown(GROWS, parse(formula), answer)
        assert GROWS.transitions[answer.stem[-1]] == "shrink"


@pytest.mark.long
@settings(max_examples=30, deadline=None)
@given(nets(), st.sampled_from(["G (p0 <= 2)", "G (p0 <= 40)", "G (p0 <= 2) & F (p0 = 0)"]), st.booleans())
def test_conditions_on_nets_that_may_have_no_bounds(net: CompiledNet, formula: str, is_fair: bool) -> None:
    names, tree = NetNames(net), parse(formula)
    fair = ("t0",) if is_fair else ()
    answer = verify_linear(net, tree, names, fair, (), Budget(1 << 26, states=5_000, seconds=10))
    if answer.status == "violated":
        check_shown(net, tree, answer, [0] if is_fair else [])


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_branching_time(near: int, seed: int) -> None:
    rng = random.Random(seed)
    seen: Counter[str] = Counter()
    for _ in range(60):
        net = random_net(rng)
        if reachability_graph(net, 200) is None:
            continue
        condition = condition_of(rng, net)
        goal = rng.choice([Exists(Finally(condition)), ForAll(Globally(condition))])
        others = [random_ctl(rng, rng.randrange(2, 6), atoms_of(rng, net, with_fired=False))]
        formula = rng.choice([goal, And((goal, *others))])
        expected = check_ctl(net, formula, engine="explicit")
        answer = verify_branching(net, formula, NetNames(net), LIMITS)
        assert answer.status == expected.status, (net, str(formula))
        seen[answer.status] += 1
        if formula is goal and (answer.status == "holds") == isinstance(goal, Exists):
            assert answer.trace is not None
            last = Step(tuple(replay(net, answer.trace)[-1]), None)
            bound = BoundAtoms(net, condition, NetNames(net))
            assert holds_on_lasso(condition, [], [last], bound.is_true) == isinstance(goal, Exists)
    assert min(seen["holds"], seen["violated"]) > 5


@pytest.mark.long
@pytest.mark.parametrize("seed", range(3))
def test_goals(near: int, seed: int) -> None:
    rng = random.Random(seed)
    by: Counter[str] = Counter()
    for _ in range(80):
        net = random_net(rng)
        graph = reachability_graph(net, 200)
        if graph is None:
            continue
        condition = condition_of(rng, net)
        bound = BoundAtoms(net, condition, NetNames(net))
        is_reached = any(
            holds_on_lasso(condition, [], [Step(marking, None)], bound.is_true) for marking in graph
        )
        answer = find_marking(net, condition, NetNames(net), LIMITS)
        assert answer.status == ("reachable" if is_reached else "unreachable"), (net, str(condition))
        by[answer.by] += 1
    assert by["explicit search"]
    assert by["state equation"] or near > 1


@pytest.mark.long
def test_an_invariant_costs_the_same_in_all_logics() -> None:
    net = classic.philosophers(60)
    names = NetNames(net)
    invariant = "!(eat3 >= 1 & eat4 >= 1)"
    answers = [
        verify_linear(net, f"G {invariant}", names, budget=LIMITS),
        verify_linear(net, f"G {invariant}", names, net.transitions, (), LIMITS),
        verify_branching(net, f"AG {invariant}", names, LIMITS),
    ]
    assert [(a.status, a.by) for a in answers] == [("holds", "state equation")] * 3
    assert all(a.evidence is not None for a in answers)
    found = find_marking(net, "eat3 >= 1 & eat4 >= 1", names, LIMITS)
    assert (found.status, found.by) == ("unreachable", "state equation")


def test_a_run_that_repeats_is_not_there_where_tokens_grow() -> None:
    net = CompiledNet.build({"a": 0, "b": 1}, [("t", {"b": 1}, {"a": 1, "b": 1})])
    answer = verify_linear(net, "G (a <= 3)", NetNames(net), budget=Budget(1 << 24, states=5_000, seconds=20))
    assert (answer.status, answer.stem, answer.loop) == ("violated", (0, 0, 0, 0), ())
    assert answer.ends_at_fault


SHIFTS = CompiledNet.build(
    {"idle": 1, "busy": 0, "door": 1, "open": 0, "inside": 1, "outside": 0},
    [
        Transition("start", {"idle": 1}, {"busy": 1}),
        Transition("stop", {"busy": 1}, {"idle": 1}),
        Transition("leave", {"inside": 1, "open": 1}, {"outside": 1, "open": 1}),
        Transition("unlock", {"door": 1}, {"open": 1}),
        Transition("lock", {"open": 1}, {"door": 1}),
        Transition("wait"),
    ],
)
"""A worker, and a visitor who can leave while the door is open."""


@pytest.mark.parametrize(
    ("formula", "fair", "expected"),
    [
        ("F (busy = 1)", (), NeededFairness(("start",), ())),
        ("G (busy = 1 -> F (idle = 1))", (), NeededFairness(("stop",), ())),
        ("G F (open = 1)", (), NeededFairness(("unlock",), ())),
        ("F (busy = 1)", ("unlock",), NeededFairness(("start",), ())),
        ("G (busy = 0)", (), None),  # every run that continues from the fault violates it
        ("F G (open = 1)", (), None),  # fair runs violate it
    ],
)
def test_the_fairness_that_would_prove_a_formula(
    formula: str, fair: tuple[str, ...], expected: NeededFairness | None
) -> None:
    subject = Subject(pn.Net(id="shifts"), SHIFTS)
    question = Linear(SHIFTS, NetNames(SHIFTS), formula, fair)
    answer = question.decided(LIMITS)
    assert answer.status == "violated"
    assert needed_fairness(subject, question, answer, LIMITS) == expected


def test_fairness_to_what_is_enabled_again_and_again() -> None:
    subject = Subject(pn.Net(id="shifts"), SHIFTS)
    question = Linear(SHIFTS, NetNames(SHIFTS), "F (outside = 1)")
    needed = needed_fairness(subject, question, question.decided(LIMITS), LIMITS)
    assert needed is not None
    assert needed == NeededFairness(("unlock",), ("leave",))
    assert replace(question, weak=needed.weak, strong=needed.strong).decided(LIMITS).status == "holds"
    for name in (*needed.weak, *needed.strong):
        fewer = [[each for each in names if each != name] for names in (needed.weak, needed.strong)]
        weaker = replace(question, weak=tuple(fewer[0]), strong=tuple(fewer[1]))
        assert weaker.decided(LIMITS).status == "violated"


def test_goals_are_answered_where_something_grows_behind_an_inhibitor(near: int) -> None:
    """Of a net without bounds: a goal that is never met, and one that always stays possible."""
    rows = [
        Transition("ask", {"idle": 1}, {"idle": 1, "pile": 1}, {}),
        Transition("begin", {"idle": 1, "pile": 1}, {"busy": 1}, {"held": 1}),
        Transition("end", {"busy": 1}, {"idle": 1}, {}),
        Transition("hold", {"free": 1}, {"held": 1}, {"busy": 1}),
        Transition("release", {"held": 1}, {"free": 1}, {}),
    ]
    net = CompiledNet.build({"idle": 1, "pile": 0, "busy": 0, "free": 1, "held": 0}, rows)
    names = NetNames(net)
    never = find_marking(net, "busy >= 1 & held >= 1", names, LIMITS)
    assert never.status == "unreachable"
    assert verify_linear(net, "G !(busy >= 1 & held >= 1)", names, (), (), LIMITS).status == "holds"
    possible = verify_branching(net, "AG EF busy >= 1", names, LIMITS)
    assert (possible.status, possible.by) == ("holds", "decision diagrams of a net with limits")
