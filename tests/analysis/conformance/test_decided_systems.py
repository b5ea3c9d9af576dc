"""Random systems of ROS 2 in which data decides: runs conform, and the unfolded net can be where they are.

Topics, services, actions, executors and managed nodes are among them.
"""

from __future__ import annotations

import random
import tempfile
from collections.abc import Iterable, Mapping
from functools import partial
from pathlib import Path

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from dineros.analysis.conformance import conform
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.models import compile_net
from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from dineros.metamodel.elements import find
from dineros.metamodel.errors import GuardError
from dineros.metamodel.records import read_trace, traces_of_runs
from dineros.runtime import Firing
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.flatten import flatten
from dineros.transformations.flattening.split import split
from tests.analysis.conformance.decided import colours, decided, seen
from tests.support.references.guards import without_guards
from tests.support.references.messages import ALL, Data
from tests.support.ros2_systems.action_models import action_models
from tests.support.ros2_systems.executor_models import executor_models
from tests.support.ros2_systems.lifecycle_models import lifecycle_models
from tests.support.systems.models import system_models

MOST_STATES = 4_000
STEPS = 40

Tokens = Mapping[str, list[Data]]


def moments(model: sym.SystemModel, seed: int, folder: Path) -> list[Tokens]:
    """Return the tokens of all places after each step of a run whose handlers compute any open value."""
    dice = random.Random(seed)
    application = LocalApplication(split(model), seed=seed, recorder=partial(JournalRecorder, folder))
    for net in application.nets.values():
        for number, transition in enumerate(net.structure.transition_names):
            assigned = {name for _, given in net.structure.decisions[number].assigns for name, _ in given}

            def compute(firing: Firing, assigned: set[str] = assigned) -> dict[str, object]:
                ok, level = dice.choice(ALL)
                return {name: v for name, v in (("ok", ok), ("level", level)) if name not in assigned}

            net.handler(transition, name=f"h{number}")(compute)
    found: list[Tokens] = []
    application.open()
    for _ in range(STEPS):
        application.step()
        found.append(
            {
                id: [(bool(token.data["ok"]), int(str(token.data["level"]))) for token in tokens]
                for net in application.nets.values()
                for id, tokens in net.inspect().marking.items()
            }
        )
    application.close()
    return found


def reached(net: CompiledNet, most: int) -> set[tuple[int, ...]] | None:
    """Return the reachable markings; None: there are too many."""
    rows = [
        (net.pre.row(each), net.inhibitor.row(each), net.delta[each]) for each in range(len(net.transitions))
    ]
    start = tuple(net.initial.tolist())
    todo, found = [start], {start}
    while todo:
        marking = todo.pop()
        for needs, below, change in rows:
            if all(marking[p] >= n for p, n in needs) and all(marking[p] < n for p, n in below):
                after = list(marking)
                for place, tokens in change.items():
                    after[place] += tokens
                if (key := tuple(after)) not in found:
                    if len(found) > most:
                        return None
                    found.add(key)
                    todo.append(key)
    return found


def shown(net: CompiledNet, markings: Iterable[tuple[int, ...]], ids: Iterable[str]) -> set[tuple[int, ...]]:
    chosen = [net.places.index(id) for id in ids]
    return {tuple(marking[place] for place in chosen) for marking in markings}


def impossible(model: sym.SystemModel, run: list[Tokens]) -> list[Tokens]:
    """Return moments of a run that guards exclude from the net; none if there are too many markings.

    A step of a run may be some of several firings of the net. So a moment is left out if even the net without
    guards never has its numbers of tokens.
    """
    try:
        flattened = flatten(model)
    except GuardError as error:
        assert "more than" in str(error)
        return []
    net = compile_net(flattened.net)
    markings = reached(net, MOST_STATES)
    if markings is None:
        return []
    own = [id for id in run[0] if id in net.places]
    made = [(place, *each) for place, found in colours(flattened).items() if place in own for each in found]
    kinds = [(place, kind) for place, _, kind in made]
    expected = shown(net, markings, [*own, *(id for _, id, _ in made)])
    wrong = [each for each in run if sum(seen(each, own, kinds), ()) not in expected]
    if not wrong:
        return []
    bare = compile_net(flatten(without_guards(model)).net)
    known = reached(bare, 20 * MOST_STATES)
    counts = shown(bare, known or (), own)
    return [each for each in wrong if seen(each, own, ())[0] in counts]


MODELS = st.one_of(action_models(), executor_models(), lifecycle_models(), system_models())


@pytest.mark.long
@settings(max_examples=40, deadline=None, phases=[Phase.explicit, Phase.reuse, Phase.generate])
@given(MODELS, st.integers(0, 2**20))
def test_runs_conform_and_the_net_can_be_where_they_are(model: sym.SystemModel, seed: int) -> None:
    made = decided(model, random.Random(seed))
    with tempfile.TemporaryDirectory() as folder:
        run = moments(made, seed, Path(folder))
        traces = {node: list(read_trace(parts)) for node, parts in traces_of_runs([Path(folder)]).items()}
    verdict = conform(made, {node: partial(iter, records) for node, records in traces.items()})
    assert (verdict.status, verdict.violations) == ("conforms", [])
    assert impossible(made, run) == []


def test_data_that_no_step_allows_is_seen(tmp_path: Path) -> None:
    model = sym.SystemModel(id="m", middleware="ros2")
    node = node_net(model, "node")
    before, after = place(node, "Before", tokens=1), place(node, "After")
    step(node, "Make", [before], [after])
    step(node, "Ask", [after], [place(node, "End")])
    model = decided(model, random.Random(0))
    find(model, "Make", sym.Transition).guard = None
    find(model, "Make", sym.Transition).assigns = "After.ok := true"
    find(model, "Ask", sym.Transition).guard = "After.ok = false"
    run = moments(model, 0, tmp_path)
    assert [data[0] for data in run[-1]["After"]] == [True]
    assert impossible(model, run) == []
    wrong = {**run[-1], "After": [(False, 0)]}
    assert impossible(model, [*run, wrong]) == [wrong]
