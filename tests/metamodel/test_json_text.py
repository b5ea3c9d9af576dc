"""JSON from strangers: what is not JSON, or too much of it, is one error."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from dineros.metamodel.json_text import DEPTH_LIMIT, JsonTextError, decode_json

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner),
)


@given(JSON)
def test_what_json_writes_is_read(value: object) -> None:
    text = json.dumps(value)
    assert decode_json(text) == decode_json(text.encode()) == json.loads(text)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("9" * 5000, "5000 characters"),
        ("1." + "9" * 5000, "5002 characters"),
        ("1e999", "finite"),
        ("NaN", "NaN"),
        ("-Infinity", "Infinity"),
        ("[" * 100_000, "nested too deep"),
        ('{"a":' * 100_000, "nested too deep"),
        ("[" * (DEPTH_LIMIT + 1) + "]" * (DEPTH_LIMIT + 1), "nested too deep"),
        ('"\\ud800"', "surrogate"),
        (b"\xff", "UTF-8"),
        ("", "Expecting value"),
        ("{} {}", "Extra data"),
    ],
)
def test_what_is_refused(text: str | bytes, reason: str) -> None:
    with pytest.raises(JsonTextError, match=reason):
        decode_json(text)


def test_a_key_may_have_to_stand_once() -> None:
    text = '{"a": [{"b": 1, "b": 2}]}'
    assert decode_json(text) == {"a": [{"b": 2}]}
    assert decode_json('{"a": {"b": 1}, "b": 1e3}', keys_once=True) == {"a": {"b": 1}, "b": 1000.0}
    for refused in (text, "9" * 5000):
        with pytest.raises(JsonTextError, match=r"'b' occurs twice in one object|5000 characters"):
            decode_json(refused, keys_once=True)


def test_limits_are_the_last_that_pass() -> None:
    assert decode_json("[" * DEPTH_LIMIT + "]" * DEPTH_LIMIT)
    assert decode_json("9" * 400) == int("9" * 400)
    assert decode_json("[1]", limit=3) == [1]
    with pytest.raises(JsonTextError, match="longer than 3"):
        decode_json("[1, 2]", limit=3)


@pytest.mark.parametrize("number", ["9" * 401, "-" + "9" * 400, "1." + "9" * 399, "1e" + "0" * 399])
def test_a_long_number_is_found_wherever_it_stands(number: str) -> None:
    for before in range(80):
        with pytest.raises(JsonTextError, match="a number of 401 characters"):
            decode_json(" " * before + "[" + number + ', "' + "x" * before + '"]')


@given(st.text() | st.binary())
def test_anything_is_read_or_refused(text: str | bytes) -> None:
    try:
        decode_json(text)
    except JsonTextError as error:
        assert "\n" not in str(error)
