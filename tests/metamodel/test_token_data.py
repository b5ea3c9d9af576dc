import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel import sym
from dineros.metamodel.errors import FeatureValueError
from dineros.metamodel.token_data import Value, field_type, field_value, read_data, read_json

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
        ('{"a": 1, "a": 2}', "no JSON: 'a' stands twice in one object"),
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
