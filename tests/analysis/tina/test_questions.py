"""Questions by way of stand-ins, which explore what was written for them, compared with our own engines."""

from __future__ import annotations

import random

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis import tina
from dineros.analysis.answers.budget import Budget
from dineros.analysis.explicit import Order
from dineros.analysis.logic.language.atoms import BoundAtoms, Step
from dineros.analysis.logic.language.names import NetNames
from dineros.analysis.logic.language.parser import parse
from dineros.analysis.logic.language.semantics import holds_on_lasso
from dineros.analysis.logic.language.syntax import Atom, Comparison, Deadlock, Enabled, Fired, Name
from dineros.analysis.logic.ltl.verification import verify_ltl
from dineros.analysis.logic.verdicts.verdict import check_counterexample
from dineros.analysis.nets.compiled import CompiledNet, Transition
from dineros.analysis.nets.witness import replay
from dineros.analysis.portfolio import asking as goals
from dineros.analysis.tina import TinaError, trial
from tests.analysis.logic.generated import random_ltl
from tests.analysis.reference_search import reference_search
from tests.analysis.strategies import nets
from tests.analysis.tina.stand_ins import FAULTS

ODD = CompiledNet.build(
    {"a": 3, "odd name": 0, "c[1]": 1},
    [
        Transition("t", {"a": 2}, {"odd name": 3}, {"c[1]": 2}),
        Transition("u v", {"odd name": 1}, {"c[1]": 1}, {"c[1]": 4}, {"a": 1}),
    ],
)
QUICK = settings(
    max_examples=40,
    deadline=None,
    suppress_health_check=[HealthCheck.function_scoped_fixture, HealthCheck.filter_too_much],
)


@pytest.mark.usefixtures("in_process")
class TestReachability:
    @pytest.mark.long
    @QUICK
    @given(
        nets(),
        st.lists(st.integers(0, 3), min_size=5, max_size=5),
        st.sampled_from(["breadth-first", "depth-first"]),
    )
    def test_answers_are_those_of_our_engine(self, net: CompiledNet, bounds: list[int], order: Order) -> None:
        assume(reference_search(net, 300))
        goal = " & ".join(f"{p} >= {n}" for p, n in zip(net.places, bounds, strict=False))
        names = NetNames(net)
        for text in (goal, f"deadlock & {goal}", f"{net.places[0]} > {bounds[0]}"):
            answer = tina.find_marking(net, text, names, order=order)
            assert answer.status == goals.find_marking(net, text, names, Budget(1 << 26)).status
            if answer.trace is not None:
                condition = parse(text, "state")
                end = Step(tuple(replay(net, answer.trace)[-1]), None)
                assert holds_on_lasso(condition, [], [end], BoundAtoms(net, condition, names).is_true)

    @pytest.mark.parametrize("fault", ["", "sift tells no number"])
    def test_a_transition_comes_last(self, fault: str, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv(FAULTS, fault)
        answer = tina.find_enabled(ODD, "u v", NetNames(ODD))
        assert (answer.status, answer.trace) == ("reachable", (0, 1))
        assert tina.find_marking(ODD, '"c[1]" >= 3', NetNames(ODD)).trace == (0, 1, 1)
        assert tina.find_marking(ODD, '"c[1]" >= 5', NetNames(ODD)).status == "unreachable"
        assert tina.find_marking(ODD, "a = 3", NetNames(ODD)).trace == ()

    def test_what_was_not_explored_leaves_it_unknown(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv(FAULTS, "sift stops early")
        answer = tina.find_marking(ODD, '"c[1]" >= 5', NetNames(ODD))
        assert (answer.status, answer.reason) == (
            "unknown",
            "sift stopped before it had explored all markings",
        )


@pytest.mark.usefixtures("in_process")
class TestTemporal:
    @pytest.mark.long
    @QUICK
    @given(nets(), st.randoms(use_true_random=False))
    def test_answers_are_those_of_our_engine(self, net: CompiledNet, rng: random.Random) -> None:
        assume(reference_search(net, 200))
        atoms: list[Atom] = [Comparison(((1, Name(place)),), ">=", 1) for place in net.places]
        for name in net.transitions:
            atoms += [Fired(Name(name)), Enabled(Name(name))]
        formula = random_ltl(rng, rng.randrange(1, 8), [*atoms, Deadlock()])
        weak = rng.sample(net.transitions, rng.randrange(2))
        strong = rng.sample(net.transitions, rng.randrange(2))
        names = NetNames(net)
        verdict = tina.verify(net, formula, names, weak, strong)
        assert verdict.status == verify_ltl(net, formula, names, weak, strong).status
        if verdict.status == "violated":
            fair = [[net.transitions.index(name) for name in chosen] for chosen in (weak, strong)]
            check_counterexample(
                net, formula, BoundAtoms(net, formula, names), verdict.stem, verdict.loop, *fair
            )

    def test_a_violation_may_stand_without_a_run(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv(FAULTS, "selt shows nothing")
        verdict = tina.verify(ODD, "G a >= 2", NetNames(ODD))
        assert (verdict.status, verdict.reason, verdict.stem, verdict.loop) == (
            "violated",
            "selt shows no run",
            (),
            (),
        )

    def test_an_unbounded_net_is_unknown(self) -> None:
        net = CompiledNet.build({"a": 0}, [("t", {}, {"a": 1})])
        verdict = tina.verify(net, "G a >= 0", NetNames(net))
        assert (verdict.status, verdict.reason) == ("unknown", "tina does not find the net bounded")


class TestTrial:
    @pytest.mark.parametrize("fact", trial.FACTS)
    def test_facts_are_true_of_its_one_run(self, fact: str) -> None:
        assert verify_ltl(trial.TRIAL, fact).status == "holds"
        assert verify_ltl(trial.TRIAL, f"!({fact})").status == "violated"

    @pytest.mark.usefixtures("in_process")
    @pytest.mark.parametrize(
        ("fault", "says"),
        [
            ("trial selt drops ends", "selt answers TRUE to"),
            ("trial selt lies", "selt answers FALSE to"),
            ("trial tina miscounts", "tina counts 3 markings and 3 arcs, where 3 and 2 is right"),
            ("trial selt babbles", "selt answers neither TRUE nor FALSE but 'Hello.'"),
        ],
    )
    def test_programs_that_mean_something_else_are_found_out(
        self, fault: str, says: str, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        monkeypatch.setenv(FAULTS, fault)
        with pytest.raises(TinaError, match=says) as error:
            tina.verify(ODD, "G a >= 0", NetNames(ODD))
        assert error.value.hint
        if "tina" not in fault:
            with pytest.raises(TinaError, match=says):
                tina.find_marking(ODD, "a >= 0", NetNames(ODD))

    @pytest.mark.usefixtures("in_process")
    def test_programs_that_have_passed_are_not_tried_again(self, monkeypatch: pytest.MonkeyPatch) -> None:
        assert tina.verify(ODD, "G a >= 0", NetNames(ODD)).status == "holds"
        monkeypatch.setenv(FAULTS, "trial selt lies")
        assert tina.verify(ODD, "G a >= 1", NetNames(ODD)).status == "holds"
        trial.forget()
        with pytest.raises(TinaError, match="tried on a net of three markings"):
            tina.verify(ODD, "G a >= 1", NetNames(ODD))
