"""Groups of fair transitions by their words, and to what a run is unfair, against the plain definition."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from dineros.analysis.logic import verify_ltl
from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.fairness import fair_transitions, unfairness
from dineros.analysis.model.step_roles import step_roles
from dineros.analysis.model.subject import Subject, subject_of
from dineros.metamodel import pn
from dineros.metamodel.files import load

ROOT = Path(__file__).resolve().parents[3]
FORMULA = "G (PickReqL >= 1 -> F PickResL >= 1)"


def case_study(**options: str) -> Subject:
    model = load(ROOT / "case_study/sorting.sym.xmi")
    assert isinstance(model, pn.Net)
    return subject_of(model, **options)  # type: ignore[arg-type]


@pytest.fixture(scope="module")
def sorting() -> Subject:
    return case_study()


def test_all_and_signals_share_the_transitions_out(sorting: Subject) -> None:
    changes, others = fair_transitions(sorting, ["signals"]), fair_transitions(sorting, ["all"])
    assert sorted(changes + others) == sorted(sorting.net.transitions)
    signals = {signal.id for net in sorting.model.pages for signal in getattr(net, "signals", ())}
    assert {name.split(".")[0] for name in changes} == signals
    assert "TShowResult" in others


def test_a_node_has_what_it_takes_part_in(sorting: Subject) -> None:
    of_nodes = [fair_transitions(sorting, [f"node:{net.id}"]) for net in sorting.model.pages if net.id]
    assert all(of_nodes)
    flat = [name for names in of_nodes for name in names]
    assert len(flat) == len(set(flat))
    inside = {name for name, role in step_roles(sorting.links()).items() if role.node is None}
    assert set(flat) | inside == set(fair_transitions(sorting, ["all"]))


def test_some_are_left_out(sorting: Subject) -> None:
    left = set(fair_transitions(sorting, ["all"])) - set(fair_transitions(sorting, ["all-but:TSense,TStop"]))
    # Both stand on a server page or not: a name means all its instances.
    assert left == {
        sorting.net.transitions[number]
        for name in ("TSense", "TStop")
        for number in sorting.names.transitions(name)
    }


def test_words_add_up_once(sorting: Subject) -> None:
    assert fair_transitions(sorting, ["TStop", "TStop"]) == ("TStop",)


@pytest.mark.parametrize(
    ("word", "said"),
    [
        ("node:contrller", "no node net is named 'contrller'"),
        ("all-but:TSens", "no transition is named 'TSens'"),
        ("everything", "no transition is named 'everything'"),
    ],
)
def test_an_unknown_name_is_refused(sorting: Subject, word: str, said: str) -> None:
    with pytest.raises(FormulaError, match=said):
        fair_transitions(sorting, [word])


def test_a_transition_of_that_name_comes_first() -> None:
    net = pn.Net(id="n")
    page = pn.Page(id="page", net=net)
    pn.Transition(id="all", page=page)
    pn.Transition(id="other", page=page)
    assert fair_transitions(subject_of(net), ["all"]) == ("all",)


@pytest.mark.long
def test_strong_fairness_to_all_shows_what_weak_fairness_does_not() -> None:
    sorting = case_study(signals="none")
    names = fair_transitions(sorting, ["all"])
    assert verify_ltl(sorting.net, FORMULA, sorting.names, weak=names).status == "violated"
    assert verify_ltl(sorting.net, FORMULA, sorting.names, strong=names).status == "holds"


def neglected(subject: Subject, stem: tuple[int, ...], loop: tuple[int, ...]) -> tuple[set[int], set[int]]:
    """Return what is enabled at every step of the loop and at some, by the arcs, and not fired in it."""
    net = subject.net
    marking = dict(enumerate(net.initial.tolist()))

    def enabled(t: int) -> bool:
        takes = all(marking[place] >= weight for place, weight in net.pre.row(t))
        return takes and all(marking[place] < weight for place, weight in net.inhibitor.row(t))

    seen: list[set[int]] = []
    for position, t in enumerate((*stem, *loop)):
        if position >= len(stem):
            seen.append({other for other in range(len(net.transitions)) if enabled(other)})
        for place, tokens in net.delta[t].items():
            marking[place] += tokens
    always, sometimes = set.intersection(*seen) - set(loop), set.union(*seen) - set(loop)
    return always, sometimes - always


@pytest.mark.long
def test_unfairness_is_that_of_the_definition() -> None:
    sorting = case_study(signals="none")
    choose = random.Random(7)
    for _ in range(5):
        fair = choose.sample(fair_transitions(sorting, ["all"]), 6)
        found = verify_ltl(sorting.net, FORMULA, sorting.names, weak=fair)
        assert found.status == "violated"
        unfair = unfairness(sorting, found.stem, found.loop)
        assert (set(unfair.weakly), set(unfair.strongly)) == neglected(sorting, found.stem, found.loop)
        assert not {sorting.net.transitions[t] for t in unfair.weakly} & set(fair)


def test_changes_of_signals_are_left_out(sorting: Subject) -> None:
    found = verify_ltl(sorting.net, FORMULA, sorting.names)
    unfair = unfairness(sorting, found.stem, found.loop)
    changes = set(fair_transitions(sorting, ["signals"]))
    told = unfair.to_dict(sorting.net.transitions)
    assert not changes & {*told["weakly"], *told["strongly"]}
    always, _ = neglected(sorting, found.stem, found.loop)
    assert {sorting.net.transitions[t] for t in always} - changes == set(told["weakly"])


def test_a_run_that_ends_neglects_nothing(sorting: Subject) -> None:
    assert unfairness(sorting, (), ()).to_dict(sorting.net.transitions) == {"weakly": [], "strongly": []}
