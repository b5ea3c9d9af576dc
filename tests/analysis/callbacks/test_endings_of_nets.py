"""Whether what has begun can always end, decided on parts of random nets, is what all markings say."""

from __future__ import annotations

from collections import Counter

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from dineros.analysis.answers.budget import Budget
from dineros.analysis.callbacks.refining import Endings
from dineros.analysis.nets.compiled import CompiledNet
from dineros.analysis.nets.witness import replay
from tests.analysis.covering.plain import plain_search
from tests.analysis.parts.test_part_firings import nets_of_machines
from tests.analysis.strategies import nets

Marking = tuple[int, ...]


def endless(net: CompiledNet, markings: set[Marking], place: int) -> set[Marking]:
    """Return the markings from which a place keeps a token for ever, by a plain backward search."""
    before: dict[Marking, list[Marking]] = {}
    for marking in markings:
        for t in range(len(net.transitions)):
            if net.is_enabled(t, marking):
                before.setdefault(tuple(net.fire(t, marking)), []).append(marking)
    ending = [marking for marking in markings if marking[place] == 0]
    known = set(ending)
    for marking in ending:
        fresh = [each for each in before.get(marking, ()) if each not in known]
        known.update(fresh)
        ending.extend(fresh)
    return markings - known


def check_many(examples: int, strategy: st.SearchStrategy[CompiledNet]) -> Counter[str]:
    """Compare all places of so many nets; return what was answered."""
    answers: Counter[str] = Counter()

    @settings(max_examples=examples, deadline=None)
    @given(strategy)
    def compare(net: CompiledNet) -> None:
        seen = plain_search(net, 5_000)
        if not seen.is_complete:
            return
        endings = Endings(net)
        for place in range(len(net.places)):
            ending, expected = (
                endings.of((place,), Budget(seconds=30).begun()),
                endless(net, seen.markings, place),
            )
            answers[ending.status] += 1
            if ending.status == "waits":
                assert tuple(replay(net, ending.trace)[-1]) in expected
            elif ending.status == "ends":
                assert not expected

    compare()
    return answers


def test_machines_with_buffers() -> None:
    answers = check_many(6, nets_of_machines())
    assert answers["unknown"] == 0 < answers["waits"], answers


@pytest.mark.long
def test_more_nets() -> None:
    """All is decided of machines; of nets of all kinds, what has bounds."""
    answers = check_many(40, nets_of_machines())
    assert answers["unknown"] == 0 < min(answers["waits"], answers["ends"]), answers
    answers = check_many(60, nets())
    assert answers["ends"] + answers["waits"] > answers["unknown"], answers
