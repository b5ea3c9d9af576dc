"""Comparisons of two fields of a token, compared with the operators of Python and with flattened nets."""

from __future__ import annotations

import json
import operator
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from dineros.metamodel.elements import places, transitions
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.conditions import Condition
from dineros.metamodel.guards.deciding import fulfils
from dineros.metamodel.guards.reading import read_guard
from dineros.metamodel.token_data import FieldType
from dineros.metamodel.token_types.declared import token_type_of
from dineros.transformations.flattening.flatten import flatten

SIGNS = {
    "=": operator.eq,
    "<>": operator.ne,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}
FIELDS = [
    sym.TokenField(name="a", kind="integer", minimum=-2, maximum=3),
    sym.TokenField(name="b", kind="integer", values="NONE=0, SOME=2, MANY=5"),
    sym.TokenField(name="ok", kind="boolean"),
    sym.TokenField(name="sure", kind="boolean"),
    sym.TokenField(name="wide", kind="integer"),
]
VALUES = {"a": range(-2, 4), "b": (0, 2, 5)}


def read(guard: str) -> Condition:
    """Return the condition of a guard on the only place that its transition takes from."""
    model, start = modelled(guard)
    assert model.tokenType is not None
    known: dict[str, FieldType] = {each.name: each for each in token_type_of(model.tokenType).fields}
    return read_guard(guard, {start: 1}, lambda place: known)[start]


def modelled(guard: str, tokens: list[dict[str, object]] | None = None) -> tuple[sym.SystemModel, sym.Place]:
    """Return a model with one guarded transition, and its place."""
    fields = [
        sym.TokenField(name=f.name, kind=f.kind, minimum=f.minimum, maximum=f.maximum, values=f.values)
        for f in FIELDS
    ]
    model = sym.SystemModel(id="m", tokenType=sym.TokenType(id="T", fields=fields), middleware="ros2")
    node = node_net(model, "node")
    start = place(node, "Start", tokens=len(tokens or [{}]))
    for token in tokens or ():
        start.balloons.append(sym.BalloonToken(data=json.dumps(token)))
    step(node, "Go", [start], [place(node, "Gone")]).guard = guard
    return model, start


@given(st.sampled_from(sorted(SIGNS)), st.permutations(["a", "b"]), st.booleans())
def test_two_fields_compare_as_in_python(sign: str, names: list[str], negated: bool) -> None:
    text = f"{names[0]} {sign} {names[1]}"
    condition = read(f"not {text}" if negated else text)
    for a, b in product(VALUES["a"], VALUES["b"]):
        data = {"a": a, "b": b}
        assert fulfils(condition, data) == (SIGNS[sign](data[names[0]], data[names[1]]) != negated)


def test_two_truth_values() -> None:
    condition = read("ok <> sure")
    assert all(
        fulfils(condition, {"ok": o, "sure": s}) == (o != s) for o in (False, True) for s in (False, True)
    )


def test_the_flattened_net_has_a_place_for_each_pair_of_values() -> None:
    model, _ = modelled("Start.a > Start.b", [{"a": 3, "b": "SOME"}, {"a": 1, "b": "SOME"}])
    net = flatten(model).net
    held = {str(each.id): each.tokens for each in places(net) if each.tokens}
    assert held == {"Start": 2, "Start[a=1,b=SOME]": 1, "Start[a=3,b=SOME]": 1}
    (go,) = transitions(net)
    assert {str(arc.source.id) for arc in go.incoming} == {"Start", "Start[a=3,b=SOME]"}


@pytest.mark.parametrize(
    ("guard", "message", "hint"),
    [
        ("a < wide", "kinds of tokens apart", "give both fields a range"),
        ("a = ok", "compares a boolean with a number", ""),
        ("ok < sure", "which '<' does not order", ""),
        ("a < a", "no token of Start can fulfil it", "-2..3"),
        ("a = BUSY", "no place has a field 'BUSY'", "single quotes: state = 'BUSY'"),
        ('a = "BUSY"', "no place has a field 'BUSY'", "single quotes: state = 'BUSY'"),
        ("Start.a < Gone.b", "takes no 'Gone'", "its places are Start"),
    ],
)
def test_what_cannot_be_compared(guard: str, message: str, hint: str) -> None:
    with pytest.raises(GuardError) as error:
        read(guard)
    assert message in str(error.value)
    assert hint in str(error.value.hint or "")
