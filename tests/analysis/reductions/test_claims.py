"""What each rule says it preserves is preserved, on generated nets, each rule alone and all together."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.reductions import RULES, Property, Rule, reduce
from tests.analysis.reductions.brute_force import check
from tests.analysis.reductions.generated_nets import nets, random_net

ASKED: list[frozenset[Property]] = [
    frozenset(),
    *(frozenset({item}) for item in Property),
    frozenset({Property.MARKINGS, Property.DEADLOCKS}),
    frozenset(Property),
]


@st.composite
def questions(draw: st.DrawFn) -> tuple[CompiledNet, list[str], list[str]]:
    """Nets with some observed places and transitions."""
    net = draw(nets())
    places = draw(st.lists(st.sampled_from(net.places), max_size=2, unique=True))
    transitions = draw(st.lists(st.sampled_from(net.transitions), max_size=1, unique=True))
    return net, places, transitions


@pytest.mark.long
@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
@settings(max_examples=40, deadline=None)
@given(question=questions(), preserve=st.sampled_from(ASKED))
def test_a_rule_alone_keeps_its_word(
    rule: Rule, question: tuple[CompiledNet, list[str], list[str]], preserve: frozenset[Property]
) -> None:
    net, places, transitions = question
    check(reduce(net, preserve, observed_places=places, observed_transitions=transitions, rules=[rule]))


@pytest.mark.long
@pytest.mark.parametrize("preserve", ASKED, ids=lambda items: "+".join(sorted(items)) or "nothing")
@settings(max_examples=40, deadline=None)
@given(question=questions())
def test_all_rules_together_keep_their_word(
    preserve: frozenset[Property], question: tuple[CompiledNet, list[str], list[str]]
) -> None:
    net, places, transitions = question
    reduction = reduce(net, preserve, observed_places=places, observed_transitions=transitions)
    assert set(places) <= set(reduction.kept_places)
    assert set(transitions) <= set(reduction.net.transitions)
    check(reduction)


@pytest.mark.long
@pytest.mark.parametrize("rule", RULES, ids=lambda rule: rule.name)
def test_the_generated_nets_give_every_rule_work(rule: Rule) -> None:
    applied = sum(bool(reduce(random_net(seed), (), rules=[rule]).steps) for seed in range(300))
    assert applied >= 5
