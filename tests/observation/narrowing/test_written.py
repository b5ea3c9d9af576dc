"""What is given is read again as it was written."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.observation.importing.flows.labels import Step
from dineros.observation.importing.given import (
    LIFE,
    ORDERS,
    Given,
    GivenCallback,
    GivenNode,
    GivenService,
    GivenTopic,
    Span,
)
from dineros.observation.importing.given_reading import read_given
from dineros.observation.narrowing.written import given_text

NAMES = st.text(st.characters(exclude_categories=["Cs"]), max_size=8)
WORDS = st.from_regex(r"/[a-z]{1,5}", fullmatch=True)
STEPS = st.builds(
    Step, st.sampled_from(["publish", "call", "send", "cancel"]), WORDS, st.sampled_from(["", "?", "*"])
)
GROUPS = st.dictionaries(NAMES, st.sampled_from(["exclusive", "reentrant"]), max_size=2)


TENTHS = st.integers(1, 50).map(lambda number: number / 10)
SPANS = st.one_of(st.none(), st.tuples(TENTHS, st.integers(6, 9).map(float)))


def callbacks(group: st.SearchStrategy[str | None]) -> st.SearchStrategy[GivenCallback]:
    """Return callbacks; one that sleeps takes at least some time, and says what it does."""
    steps = st.lists(STEPS, max_size=3).map(tuple)
    takes = st.one_of(st.none(), st.tuples(TENTHS, st.integers(6, 9).map(float)))
    sleeps = st.tuples(TENTHS, st.none())
    times = {"offset": SPANS, "jitter": st.one_of(st.none(), TENTHS)}
    works = st.builds(GivenCallback, st.one_of(st.none(), steps), group, st.booleans(), takes=takes, **times)
    return st.one_of(works, st.builds(GivenCallback, steps, group, st.booleans(), takes=sleeps))


@st.composite
def nodes(draw: st.DrawFn) -> GivenNode:
    groups = draw(GROUPS)
    group = st.sampled_from([None, *groups])
    return GivenNode(
        draw(st.one_of(st.none(), st.integers(1, 1000))),
        groups,
        draw(st.dictionaries(NAMES, st.integers(0, 1_000_000), max_size=2)),
        draw(st.one_of(st.none(), st.dictionaries(NAMES, st.floats(1e-3, 1e3), max_size=2))),
        draw(st.one_of(st.none(), st.lists(st.sampled_from(LIFE)).map(tuple))),
        draw(st.dictionaries(NAMES, callbacks(group), max_size=2)),
        draw(st.dictionaries(NAMES, st.booleans(), max_size=2)),
        order=draw(st.sampled_from([None, *ORDERS])),
    )


TOPICS = st.builds(GivenTopic, st.lists(NAMES).map(tuple), st.lists(NAMES).map(tuple), SPANS)
SERVICES = st.builds(GivenService, st.lists(NAMES).map(tuple), st.lists(NAMES).map(tuple), SPANS)
ACTIONS = st.builds(GivenService, latency=SPANS)


@settings(max_examples=30, deadline=None)
@given(
    st.dictionaries(NAMES, nodes(), max_size=3),
    st.dictionaries(NAMES, TOPICS, max_size=2),
    st.dictionaries(NAMES, SERVICES, max_size=2),
    st.dictionaries(NAMES, ACTIONS, max_size=2),
    SPANS,
    SPANS,
)
def test_round_trip(
    said: dict[str, GivenNode],
    topics: dict[str, GivenTopic],
    services: dict[str, GivenService],
    actions: dict[str, GivenService],
    latency: Span | None,
    takes: Span | None,
) -> None:
    whole = Given(said, topics, None, services, actions, latency, takes)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.given.toml")
        path.write_text(given_text(whole), encoding="utf-8")
        assert read_given(path) == replace(whole, path=path)
