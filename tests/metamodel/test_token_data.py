import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.token_data import Value, field_type, field_value, range_of, read_data, read_json

DECLARED = {
    "text": sym.TokenField(name="text"),
    "integer": sym.TokenField(name="integer", kind="integer"),
    "number": sym.TokenField(name="number", kind="number"),
    "boolean": sym.TokenField(name="boolean", kind="boolean"),
    "list": sym.TokenField(name="list", kind="list", elementKind="integer", length=2),
    "map": sym.TokenField(name="map", kind="map", elementKind="boolean"),
}
FIELDS = {name: field_type(field) for name, field in DECLARED.items()}


@pytest.mark.parametrize(
    ("name", "raw", "value"),
    [
        ("text", "1.5", "1.5"),
        ("integer", 3, 3),
        ("integer", " -3 ", -3),
        ("number", 3, 3.0),
        ("number", "1e3", 1000.0),
        ("boolean", True, True),
        ("boolean", "false", False),
        ("list", [1, "2"], [1, 2]),
        ("list", "[1, 2]", [1, 2]),
        ("map", {"a": "true"}, {"a": True}),
        ("map", '{"a": false}', {"a": False}),
    ],
)
def test_reads_values_and_texts_that_denote_them(name: str, raw: object, value: Value) -> None:
    found = field_value(FIELDS[name], raw)
    assert found == value
    assert type(found) is type(value)


@pytest.mark.parametrize(
    ("name", "raw", "message"),
    [
        ("text", 1, "text takes a text, not 1"),
        ("integer", 1.5, "integer takes an integer, not 1.5"),
        ("integer", True, "integer takes an integer, not true"),
        ("integer", "1_000", 'integer takes an integer, not "1_000"'),
        ("integer", None, "integer takes an integer, not null"),
        ("integer", 2**63, "integer takes an integer of 64 bits, not 9223372036854775808"),
        (
            "integer",
            "-9223372036854775809",
            "integer takes an integer of 64 bits, not -9223372036854775809",
        ),
        ("number", "nan", 'number takes a number, not "nan"'),
        ("number", True, "number takes a number, not true"),
        ("number", 10**400, "number takes a number, not 1000000000000000000000000000000000000..."),
        ("boolean", 1, "boolean takes true or false, not 1"),
        ("list", [1], "list takes 2 elements, not 1"),
        ("list", [1, "x"], 'list[1] takes an integer, not "x"'),
        ("list", {"a": 1}, 'list takes a list, not {"a": 1}'),
        ("map", [True], "map takes a map, not [true]"),
        ("map", {"a": 2}, "map.a takes true or false, not 2"),
    ],
)
def test_refuses_what_does_not_fit(name: str, raw: object, message: str) -> None:
    with pytest.raises(FeatureValueError) as caught:
        field_value(FIELDS[name], raw)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{", "no JSON at column 2"),
        ("NaN", "no JSON: NaN is not a JSON number"),
        ('{"a": 1, "a": 2}', "no JSON: 'a' occurs twice in one object"),
        ("[" * 100_000, "no JSON: nested too deep"),
        ("1" * 5000, "no JSON: Exceeds the limit"),
    ],
)
def test_refuses_what_is_no_strict_json(text: str, message: str) -> None:
    with pytest.raises(FeatureValueError) as caught:
        read_json(text)
    assert str(caught.value).startswith(message)


def test_reads_some_fields_of_a_token_type() -> None:
    assert read_data('{"integer": "1", "text": "x"}', FIELDS) == {"integer": 1, "text": "x"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"txt": "x"}', "the token type has no field 'txt' (did you mean 'text'?)"),
        ('{"zzz": 1}', "has no field 'zzz' (known fields: text, integer, number, boolean, list, map)"),
        ("[]", "no JSON object"),
    ],
)
def test_refuses_what_is_no_data_of_the_token_type(text: str, message: str) -> None:
    with pytest.raises(FeatureValueError) as caught:
        read_data(text, FIELDS)
    assert message in str(caught.value)


@given(
    st.recursive(st.none() | st.booleans() | st.integers() | st.floats() | st.text(), st.lists, max_leaves=5)
)
def test_any_json_fits_or_is_refused(value: object) -> None:
    for field in FIELDS.values():
        try:
            found = field_value(field, value)
        except FeatureValueError:
            continue
        assert not isinstance(found, float) or math.isfinite(found)
        assert field_value(field, json.loads(json.dumps(found))) == found


@pytest.mark.parametrize(
    ("field", "raw", "value"),
    [
        (sym.TokenField(name="mode", kind="integer", values="IDLE=0, BUSY=3"), "BUSY", 3),
        (sym.TokenField(name="mode", kind="integer", values="IDLE=0, BUSY=3"), 0, 0),
        (sym.TokenField(name="level", kind="integer", minimum=-2, maximum=2), -2, -2),
        (sym.TokenField(name="level", kind="integer", maximum=2), "-9", -9),
    ],
)
def test_values_of_a_range(field: sym.TokenField, raw: object, value: Value) -> None:
    assert field_value(field_type(field), raw) == value


@pytest.mark.parametrize(
    ("field", "raw", "message"),
    [
        (
            sym.TokenField(name="mode", kind="integer", values="IDLE=0, BUSY=3"),
            1,
            "mode takes IDLE, BUSY, not 1",
        ),
        (
            sym.TokenField(name="mode", kind="integer", values="IDLE=0, BUSY=3"),
            "LOST",
            'mode takes an integer, not "LOST"',
        ),
        (
            sym.TokenField(name="level", kind="integer", minimum=-2, maximum=2),
            3,
            "level takes -2 to 2, not 3",
        ),
        (sym.TokenField(name="level", kind="integer", minimum=1), 0, "level takes at least 1, not 0"),
        (sym.TokenField(name="level", kind="integer", maximum=1), 2, "level takes at most 1, not 2"),
    ],
)
def test_refuses_values_outside_of_a_range(field: sym.TokenField, raw: object, message: str) -> None:
    with pytest.raises(FeatureValueError) as error:
        field_value(field_type(field), raw)
    assert error.value.message == message


@given(st.integers(-5, 5), st.integers(-5, 5), st.integers(-9, 9))
def test_a_range_has_exactly_its_values(low: int, high: int, value: int) -> None:
    declared = sym.TokenField(name="level", kind="integer", minimum=low, maximum=high)
    if low > high:
        with pytest.raises(FeatureValueError, match="is greater than the maximum"):
            range_of(declared)
    else:
        assert (range_of(declared).fault(value) is None) == (value in range(low, high + 1))
