"""Publishers whose place stands in the node and is shared by callbacks, as imported models have it."""

from __future__ import annotations

import pytest

from dineros.analysis.answers.budget import Budget
from dineros.analysis.bounds.answers import Bounds
from dineros.analysis.latencies.answers import Latencies, end_of
from dineros.metamodel import pn, sym
from dineros.metamodel.build import here, place
from dineros.metamodel.constraints import validate
from dineros.metamodel.elements import channels, node_net_of, nodes
from tests.analysis.latencies.test_answers import units
from tests.support.timed_systems.counted import CHAINS, COUNTED
from tests.support.timed_systems.models import model_of


def moved(model: sym.SystemModel) -> sym.SystemModel:
    """Put the place of each publisher into its node; its callback refers to it."""
    for topic in channels(model, sym.TopicChannel):
        for writer in topic.publishers:
            old, node = writer.place, node_net_of(writer.place)
            assert node is not None and old.page is not None
            new = place(node, f"{old.id}.of_node", tokens=old.tokens)
            away = [
                each for each in nodes(model) if isinstance(each, pn.ReferencePlace) and each.target is old
            ]
            for arc in list(old.incoming):
                arc.target = here(new, old.page)
            for each in away:
                each.target = new
            writer.place, old.page = new, None
    assert [each for each in validate(model) if each.severity == "error"] == []
    return model


@pytest.mark.parametrize("number", [1, 2, 4, 6, pytest.param(11, marks=pytest.mark.long), 14])
def test_chains_have_the_same_times(number: int) -> None:
    first, last, least, greatest, loses = CHAINS[number]
    model = moved(model_of(COUNTED[number].system, 0.01))
    found = Latencies(model, Budget(seconds=100)).between(end_of(model, first), end_of(model, last))
    assert (*units(found), found.is_lost) == (least, greatest, loses)
    bound = Bounds(model).between(end_of(model, first), end_of(model, last))
    assert bound.greatest is None or bound.greatest.value * 100 >= greatest


def test_of_two_callbacks_that_publish_each_is_followed() -> None:
    """The second one publishes, too, and its messages have a way of their own."""
    system = {
        "nodes": {"n": {"threads": 2}, "m": {"threads": 1}},
        "latency": {"out": (0, 1)},
        "chains": [],
        "callbacks": [
            {"name": name, "node": "n", "group": name, "script": [["work", work, work], ["publish", "out"]],
             "period": 20, "offset": 0}
            for name, work in (("quick", 1), ("slow", 5))
        ] + [
            {"name": "use", "node": "m", "group": "default", "script": [["work", 1, 1]], "topic": "out",
             "depth": 4}
        ],
    }  # fmt: skip
    model = moved(model_of(system, 0.01))
    for name, least, greatest in (("quick", 2, 3), ("slow", 6, 7)):
        found = Latencies(model, Budget(seconds=100)).between(end_of(model, name), end_of(model, "use"))
        assert units(found) == (least, greatest), name
