"""Guards that always hold change nothing: the unfolded net has the markings of the net without them."""

from __future__ import annotations

import pytest
from hypothesis import Phase, assume, given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.analysis.timed.exploring import explore_timed
from dineros.analysis.timed.timed_subject import timed_base_subject
from dineros.metamodel import pn, sym
from dineros.metamodel.build import node_net, place, seconds, step
from dineros.metamodel.elements import arcs, find, places, resolve, transitions
from dineros.metamodel.errors import GuardError
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.language.copying import deep_copy
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models
from tests.support.systems.models import system_models
from tests.support.timed_systems.counted import COUNTED
from tests.support.timed_systems.models import model_of

MOST_STATES = 600


def told_apart(model: sym.SystemModel, every: int = 1) -> sym.SystemModel:
    """Return a model each of whose transitions asks about a token that it takes; any will do."""
    made, _ = deep_copy(model)
    assert isinstance(made, sym.SystemModel)
    bit = sym.TokenField(name="bit", kind="boolean")
    made.tokenType = sym.TokenType(id="Bit", fields=[bit])
    for each in places(made):
        if isinstance(each, sym.Place):
            each.tokenType = None
            each.balloons.clear()
    takes: dict[pn.Node, list[pn.Arc]] = {}
    for arc in arcs(made):
        takes.setdefault(arc.target, []).append(arc)
    for number, transition in enumerate(transitions(made)):
        found = [arc for arc in takes.get(transition, ()) if arc.kind != pn.ArcKind.inhibitor]
        names = [str(resolve(arc.source).id) for arc in found]
        single = [
            name for name, arc in zip(names, found, strict=True) if names.count(name) == 1 and arc.weight == 1
        ]
        if single and number % every == 0:
            assert isinstance(transition, sym.Transition)
            transition.guard = f'"{single[0]}".bit = true or "{single[0]}".bit = false'
    return made


def reached(net: CompiledNet, only: list[str]) -> set[tuple[int, ...]] | None:
    """Return the markings of some places that can be reached; None: there are too many."""
    chosen = [net.places.index(name) for name in only]
    start = tuple(net.initial.tolist())
    todo, seen = [start], {start}
    while todo:
        marking = todo.pop()
        for transition in range(len(net.transitions)):
            if net.is_enabled(transition, list(marking)):
                after = tuple(net.fire(transition, list(marking)))
                if after not in seen:
                    if len(seen) > MOST_STATES:
                        return None
                    seen.add(after)
                    todo.append(after)
    return {tuple(marking[p] for p in chosen) for marking in seen}


def _same(model: sym.SystemModel, every: int) -> None:
    for transition in transitions(model):
        transition.overrides.clear()
    bare = compile_net(flatten(model).net)
    expected = reached(bare, list(bare.places))
    assume(expected is not None)
    net = compile_net(flatten(told_apart(model, every)).net)
    found = reached(net, list(bare.places))
    assume(found is not None)
    assert found == expected


MODELS = st.one_of(action_models(), executor_models(), lifecycle_models(), system_models())


@settings(max_examples=40, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(MODELS, st.integers(1, 3))
def test_no_marking_is_lost_or_added(model: sym.SystemModel, every: int) -> None:
    _same(model, every)


@pytest.mark.parametrize("number", [1, 3, 4, 11, 13, 15])
def test_no_marking_is_lost_or_added_in_time(number: int) -> None:
    model = model_of(COUNTED[number].system)
    bare = explore_timed(timed_base_subject(model).timed, Budget(1 << 28, seconds=60))
    explored = explore_timed(timed_base_subject(told_apart(model)).timed, Budget(1 << 28, seconds=60))
    assert bare.is_complete and explored.is_complete
    assert len(explored.net.untimed.transitions) > len(bare.net.untimed.transitions)
    names = list(bare.net.untimed.places)
    chosen = [explored.net.untimed.places.index(name) for name in names]
    assert {*map(tuple, explored.markings[:, chosen].tolist())} == {*map(tuple, bare.markings.tolist())}


def test_tokens_that_share_a_clock_are_refused() -> None:
    """Two tokens with one interval: what is done with one of them starts the time of the other one again."""
    model = sym.SystemModel(id="m", tokenType=sym.TokenType(id="Nothing"))
    node = node_net(model, "node")
    left = place(node, "Left", tokens=2)
    step(node, "Work", [left], [place(node, "Done")]).interval = seconds(1.0, 2.0)
    made = told_apart(model)
    find(made, "Left", sym.Place).balloons.append(sym.BalloonToken(data='{"bit": true}'))
    with pytest.raises(GuardError, match="transition Work has an interval") as error:
        timed_base_subject(made)
    assert error.value.hint == "give the places that it takes tokens from a capacity of 1"
    find(made, "Left", sym.Place).tokens = 1
    assert explore_timed(timed_base_subject(made).timed, Budget(1 << 28, seconds=60)).is_complete
