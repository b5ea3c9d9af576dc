"""A node's structure is counted before it is made: instances, tokens, lists, values."""

from __future__ import annotations

import pytest

from dineros.metamodel import rtm, sym
from dineros.metamodel.limits import VARIABLE, SizeLimitError
from dineros.runtime.nets.structure import read_structure
from tests.runtime.tiny import tiny
from tests.support.broken.small import runtime

NUMBER = 2**31 - 1


def refused(model: rtm.RuntimeModel, says: str) -> None:
    with pytest.raises(SizeLimitError, match=says):
        read_structure(model)


def test_instances(monkeypatch: pytest.MonkeyPatch) -> None:
    small = runtime()
    small["Entry"].ports[0].instances = NUMBER
    refused(small.net, "has 2147483647 instances, more than the limit of 1000")
    monkeypatch.setenv(VARIABLE, f"instances={NUMBER},elements=50000")
    small["Entry"].ports[0].instances = 20_000
    refused(small.net, "elements, more than the limit of 50000")


def test_tokens_of_all_places_together() -> None:
    refused(tiny({"t": "a b -> c"}, {"a": 60_000, "b": 60_000}), "has 120000 tokens")


def test_lists_of_fixed_length() -> None:
    model = tiny({"t": "a -> b"}, {"a": 1})
    assert model.tokenType is not None
    model.tokenType.fields[4].length = NUMBER
    refused(model, "'pose' has 2147483647 elements, more than the limit of 1000000")


def test_values_of_all_tokens_together() -> None:
    model = tiny({"t": "a -> b"}, {"a": 1000})
    assert model.tokenType is not None
    cloud = sym.TokenField(name="cloud", kind="list", elementKind="number", length=20_000)
    model.tokenType.fields.append(cloud)
    refused(model, "values, more than the limit of 10000000")
