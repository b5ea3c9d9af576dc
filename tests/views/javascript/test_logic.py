"""Logic of the pages that needs no page, run in V8: conditions of breakpoints, names, the search."""

from __future__ import annotations

import pytest

from dineros.views.javascript.client import evaluate

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
