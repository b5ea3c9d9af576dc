"""Sets of values as intervals, compared with plain sets; and constants of messages of each form."""

from __future__ import annotations

import operator
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.build import node_net, place, step
from dineros.metamodel.elements import places
from dineros.metamodel.errors import GuardError
from dineros.metamodel.guards.conditions import Comparison, FieldName
from dineros.metamodel.guards.parser import parse_guard
from dineros.metamodel.guards.values import (
    Values,
    classes_of,
    contains,
    is_subset,
    sample,
    values_of,
    values_text,
)
from dineros.metamodel.token_data import FieldType
from dineros.metamodel.token_types.installed import installed_constants, installed_fields
from dineros.metamodel.value_ranges import UNLIMITED, ValueRange
from dineros.transformations.flattening.flatten import flatten

SIGNS = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def _field(range: ValueRange = UNLIMITED, ros: str | None = None) -> FieldType:
    return FieldType("n", "integer", "text", None, 0, ros, range=range)


def _numbers(values: Values) -> set[int]:
    return {value for low, high in values for value in range(low, high + 1)}


FIELDS = st.one_of(
    st.builds(lambda low, more: _field(ValueRange(low, low + more)), st.integers(-6, 3), st.integers(0, 9)),
    st.sets(st.integers(-6, 6), min_size=1).map(
        lambda some: _field(
            ValueRange(names=tuple((f"V{n}", v) for n, v in enumerate(sorted(some, key=abs))))
        )
    ),
)
ASKED = st.lists(st.tuples(st.sampled_from(sorted(SIGNS)), st.integers(-8, 14)), max_size=4)


@given(FIELDS, ASKED)
def test_values_are_in_one_class_if_no_comparison_distinguishes_them(
    field: FieldType, asked: list[tuple[str, int]]
) -> None:
    classes = classes_of(field, [Comparison(FieldName(None, "n"), *each) for each in asked])
    wanted: dict[tuple[bool, ...], set[int]] = {}
    for value in sorted(_numbers(values_of(field) or ())):
        wanted.setdefault(tuple(SIGNS[sign](value, other) for sign, other in asked), set()).add(value)
    assert [_numbers(each) for each in classes] == list(wanted.values())
    for each in classes:
        assert abs(sample(each)) == min(map(abs, _numbers(each)))
        assert [value for value in range(-9, 16) if contains(each, value)] == sorted(_numbers(each))
        assert is_subset(each, values_of(field) or ())
        assert all(is_subset(each, other) == (_numbers(each) <= _numbers(other)) for other in classes)


def test_integers_of_any_width_have_classes() -> None:
    wide = _field(ros="uint64")
    comparisons = [Comparison(FieldName(None, "n"), "=", 3), Comparison(FieldName(None, "n"), ">", 2**40)]
    classes = classes_of(wide, comparisons)
    assert [values_text(wide, each) for each in classes] == [
        f"0..2|4..{2**40}",
        "3",
        f"{2**40 + 1}..{2**64 - 1}",
    ]


def test_a_value_with_two_names_is_shown_once() -> None:
    field = _field(ValueRange(names=(("ADD", 0), ("MODIFY", 0), ("DELETE", 2)), is_open=True), "uint8")
    assert values_text(field, ((0, 255),)) == "ADD|1|DELETE|3..255"


def test_a_guard_about_a_field_without_a_range() -> None:
    """Two kinds of tokens, although the field has 2 ** 64 values."""
    model = sym.SystemModel(
        id="m", tokenType=sym.TokenType(id="T", fields=[sym.TokenField(name="n", kind="integer")])
    )
    node = node_net(model, "node")
    start, few, many = place(node, "Start", tokens=1), place(node, "Few"), place(node, "Many")
    step(node, "Less", [start], [few]).guard = "n < 1000000"
    step(node, "More", [start], [many]).guard = "n >= 1000000"
    names = [each.id for each in places(flatten(model).net)]
    assert f"Start[n=1000000..{2**63 - 1}]" in names
    assert len(names) == 5


@pytest.mark.parametrize(
    ("text", "same"),
    [
        ("n != 3", "n <> 3"),
        ("3 < n", "n > 3"),
        ("3 >= n", "n <= 3"),
        ("3 = n", "n = 3"),
        ("3 <> n", "n <> 3"),
        ("'A' <= n", "n >= 'A'"),
        ("n = 0xFf", "n = 255"),
        ("n > -0x10", "n > -16"),
        ("n = 007", "n = 7"),
        ("not n = 1 AND m = 2 Or k = 3", "((not (n = 1)) and m = 2) or k = 3"),
        ("n between -3 and 2 and m = 1", "n >= -3 and n <= 2 and m = 1"),
    ],
)
def test_ways_to_write_a_comparison(text: str, same: str) -> None:
    left, right = parse_guard(text), parse_guard(same)
    assert left == right or "between" in text


@pytest.mark.parametrize(
    ("text", "message", "hint"),
    [
        ("n == 1", "column 3 has '=='", "write = for equal"),
        ("n = 1 && m = 2", "column 7 has '&&'", "write and"),
        ("n = 1 || m = 2", "column 7 has '||'", "write or"),
        ("!ok = true", "column 1 has '!'", "write not"),
        ("n = 1.5", "column 6 has '.5'", "whole numbers"),
        ("n in (1, 2)", "column 3 has 'in'", "join comparisons by or"),
        ("Got.status.status = 1", "column 11 has '.status'", "nested messages"),
        (f"n = {'9' * 21}", f"column 5 has '{'9' * 21}'", "at most 20 digits"),
        ("success", "ends too early", "write success = true"),
        ("n = ３", "column 5 has '３'", "write it like"),
        ("", "ends too early", "write it like"),
    ],
)
def test_what_programmers_may_write_instead(text: str, message: str, hint: str) -> None:
    with pytest.raises(GuardError) as error:
        parse_guard(text)
    assert message in str(error.value)
    assert hint in str(error.value.hint)


def test_long_names_are_cut_in_messages() -> None:
    for guard in (f'"{"a" * 9000}".n = 1', f"n = '{'A' * 9000}'", f'"{"b" * 9000}" = 1'):
        model = sym.SystemModel(
            id="m", tokenType=sym.TokenType(id="T", fields=[sym.TokenField(name="n", kind="integer")])
        )
        node = node_net(model, "node")
        step(node, "Go", [place(node, "Start", tokens=1)], []).guard = guard
        with pytest.raises(GuardError) as error:
            flatten(model)
        assert len(str(error.value)) < 300


MESSAGE = """# comment = 1
uint8 STATE_IDLE = 0
uint8   STATE_BUSY=0x10   # it's hexadecimal
\tuint8 STATE_DONE=010 # "decimal"
int8 MODE_BACK=-3
int8 MODE_STOP = +0
char LETTER_A=65
byte FLAG_ON=0b11
bool YES=1
float32 PI=3.5
string NAME_TEXT="a # b = 3"
string OTHER='it''s'
int32 ERROR_NONE=0
int32 ERROR_LOST=-70000
uint8 state
int8 mode
char letter
byte flag
int32 error
string name
"""


def test_constants_of_each_form(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    types = {"state": 3, "mode": 2, "letter": 13, "flag": 16, "error": 6, "name": 17}
    fields = ", ".join(
        f'{{"name": "{name}", "type": {{"type_id": {number}, "capacity": 0, "string_capacity": 0,'
        f' "nested_type_name": ""}}, "default_value": ""}}'
        for name, number in types.items()
    )
    folder = tmp_path / "share" / "forms" / "msg"
    folder.mkdir(parents=True)
    (folder / "Forms.msg").write_text(MESSAGE)
    (folder / "Forms.json").write_text(
        '{"type_description_msg": {"referenced_type_descriptions": [], "type_description": '
        f'{{"type_name": "forms/msg/Forms", "fields": [{fields}]}}}}}}'
    )
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    found = {each.name: dict(each.range.names) for each in installed_fields("forms/msg/Forms")}
    assert found == {
        "state": {"STATE_IDLE": 0, "STATE_BUSY": 16, "STATE_DONE": 10},
        "mode": {"MODE_BACK": -3, "MODE_STOP": 0},
        "letter": {"LETTER_A": 65},
        "flag": {"FLAG_ON": 3},
        "error": {"ERROR_NONE": 0, "ERROR_LOST": -70000},
        "name": {},
    }
    assert installed_constants("forms/msg/Forms")["PI"] == 3.5
