"""Logic of the pages that needs no page, run in V8: conditions of breakpoints, names, the search."""

from __future__ import annotations

from random import Random

import pytest

from dineros.metamodel import pn
from dineros.views.javascript.client import evaluate
from dineros.views.nets.contents.times import interval_words

EVENTS = ["drop", "giveUp"]


@pytest.mark.parametrize(
    ("text", "kind", "said"),
    [
        ("Place >= 3", "place", "Place >= 3"),
        (" A place=3 ", "place", "A place == 3"),
        ('"x" != 0', "place", "x != 0"),
        ("fired( T )", "fired", "fired(T)"),
        ("signal(S)", "signal", "signal(S)"),
        ("!signal(S)", "signal", "!signal(S)"),
        ("S = false", "signal", "!signal(S)"),
        ("Drop", "event", "drop"),
        ("giveup", "event", "giveUp"),
        ("TStop", "name", "TStop"),
    ],
)
def test_conditions_are_read_and_said_in_one_form(text: str, kind: str, said: str) -> None:
    found = evaluate(["static/trace/explaining/conditions.js"], "parseCondition", text, EVENTS)
    assert (found["kind"], found["text"]) == (kind, said)
    assert evaluate(["static/trace/explaining/conditions.js"], "parseCondition", said, EVENTS) == found


@pytest.mark.parametrize("text", ["", "  ", "!fired(T)", "A > B", "f(x)", "= 3"])
def test_other_texts_are_no_conditions(text: str) -> None:
    assert evaluate(["static/trace/explaining/conditions.js"], "parseCondition", text, EVENTS) is None


@pytest.mark.parametrize(
    ("name", "expected"), [("P", "P"), ("S[2].P", "P"), ("S[2].Q[1].P", "P"), ("S[x].P", "S[x].P")]
)
def test_elements_of_server_instances_are_those_of_the_model(name: str, expected: str) -> None:
    assert evaluate(["static/trace/data.js"], "prototypeOf", name) == expected


def test_the_search_of_a_net_names_the_best_first() -> None:
    def node(id: str, detail: str) -> dict[str, object]:
        return {"id": id, "label": id, "kind": "place", "detail": {"Note": detail}}

    nodes = [
        node("Unsafe", ""),
        node("Safely", ""),
        node("Other", "is safe"),
        node("Safe", ""),
        node("No", ""),
    ]
    found = evaluate(["static/net/search.js"], "matching", nodes, "SAFE ")
    assert [one["id"] for one in found] == ["Safe", "Safely", "Unsafe", "Other"]


@pytest.mark.parametrize("seed", range(3))
def test_times_have_the_words_of_pictures(seed: int) -> None:
    random = Random(seed)
    for _ in range(30):
        earliest = random.choice((0, 0, 0.001, 0.0011, 0.017, 0.29, 0.57, 1, 2.5))
        latest = random.choice((None, earliest, round(earliest + 0.013, 6), 1, 3))
        opens = random.random() < 0.3, latest is not None and random.random() < 0.3
        if latest is not None and latest <= earliest:
            latest, opens = earliest, (False, False)
        interval = pn.TimeInterval(earliest=earliest, latest=latest)
        interval.earliestExcluded, interval.latestExcluded = opens
        said = evaluate(["static/edit/times.js"], "intervalWords", earliest, latest, *opens)
        assert said == interval_words(interval)
