"""Orders kept beside a model."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import pytest

from dineros.analysis.symbolic import engine as symbolic
from dineros.analysis.symbolic.engine import symbolic_state_space
from dineros.analysis.symbolic.level_order import OrderSearch
from dineros.analysis.symbolic.order_cache import SIZE_LIMIT, OrderCache, structure_key
from tests.analysis.reference_case_study import reference_case_study


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> OrderCache:
    monkeypatch.setattr(symbolic, "WORTH_KEEPING", 0)
    monkeypatch.setattr(OrderSearch, "good_effort", None)  # small nets need no search
    return OrderCache(tmp_path / "model.xmi")


def test_an_order_serves_again_for_more_objects(cache: OrderCache) -> None:
    first = symbolic_state_space(reference_case_study((1, 1, 1), "none"), orders=cache)
    assert first.search_work > 0
    again = symbolic_state_space(reference_case_study((2, 2, 2), "none"), orders=cache)
    assert (again.search_work, again.order) == (0, first.order)
    assert again.markings == symbolic_state_space(reference_case_study((2, 2, 2), "none")).markings


def test_another_structure_has_another_key(cache: OrderCache) -> None:
    net = reference_case_study((1, 1, 1), "none")
    cache.keep(net, [["a"]])
    assert cache.order(net) == [["a"]]
    assert structure_key(reference_case_study((3, 1, 2), "none")) == structure_key(net)
    for other in (
        replace(net, places=net.places[::-1]),
        replace(net, transitions=net.transitions[::-1]),
        replace(net, pre=net.post),
        replace(net, post=net.pre),
        replace(net, inhibitor=net.pre),
    ):
        assert cache.order(other) is None
    assert cache.order(reference_case_study((1, 1, 1), "input")) is None


def test_easy_nets_leave_no_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(OrderSearch, "good_effort", None)
    cache = OrderCache(tmp_path / "model.xmi")
    space = symbolic_state_space(reference_case_study((1, 1, 1), "none"), orders=cache)
    assert 0 < space.search_work < symbolic.WORTH_KEEPING
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("content", ["", "[1]", '{"x": 1', "\x00"])
def test_a_broken_file_is_no_order(cache: OrderCache, content: str) -> None:
    net = reference_case_study((1, 0, 0), "none")
    cache.path.parent.mkdir()
    cache.path.write_text(content)
    assert cache.order(net) is None
    space = symbolic_state_space(net, orders=cache)
    assert cache.order(net) == [list(group) for group in space.order]


@pytest.mark.parametrize("order", [1, [1], [[1]], [["nothing"]], []])
def test_an_order_that_does_not_fit_is_ignored(cache: OrderCache, order: object) -> None:
    net = reference_case_study((1, 0, 0), "none")
    cache.keep(net, [["a"]])
    cache.path.write_text(cache.path.read_text().replace('[["a"]]', __import__("json").dumps(order)))
    assert symbolic_state_space(net, orders=cache).markings == 432


def test_where_nothing_can_be_written_nothing_is(cache: OrderCache) -> None:
    cache.path.parent.write_text("a file where the folder should be")
    assert symbolic_state_space(reference_case_study((1, 0, 0), "none"), orders=cache).markings == 432


@pytest.mark.parametrize("kind", ["deep", "digits", "large", "pipe", "device", "link", "folder link"])
def test_a_hostile_file_is_no_order(cache: OrderCache, kind: str) -> None:
    net = reference_case_study((1, 0, 0), "none")
    theirs = OrderCache(cache.model.parent / "theirs" / "model.xmi")
    theirs.keep(net, [["theirs"]])
    order = theirs.path.read_bytes()
    if kind == "folder link":
        cache.path.parent.symlink_to(theirs.path.parent)
    else:
        cache.path.parent.mkdir()
    if kind == "deep":
        cache.path.write_bytes(order.replace(b"}", b', "x": ' + b"[" * 100 + b"]" * 100 + b"}"))
    elif kind == "digits":
        cache.path.write_bytes(order.replace(b"}", b', "x": ' + b"1" * 5000 + b"}"))
    elif kind == "large":
        cache.path.write_bytes(order + b" " * SIZE_LIMIT)
    elif kind == "pipe":
        os.mkfifo(cache.path)
    elif kind in ("device", "link"):
        cache.path.symlink_to("/dev/zero" if kind == "device" else theirs.path)
    assert cache.order(net) is None
    cache.keep(net, [["a"]])
    assert theirs.path.read_bytes() == order
    if kind in ("deep", "digits", "large"):
        assert cache.order(net) == [["a"]]


def test_a_file_never_grows_beyond_what_is_read(cache: OrderCache, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dineros.analysis.symbolic.order_cache.SIZE_LIMIT", 200)
    nets = [reference_case_study((1, 0, 0), signals) for signals in ("none", "input")]
    for net in nets:
        cache.keep(net, [["a" * 100]])
    assert [cache.order(net) for net in nets] == [None, [["a" * 100]]]
