"""Putting a run's marking together from its traces."""

from __future__ import annotations

from dineros.metamodel.records import Checkpoint, Drop, Fire, Signal, Start, StoredToken
from dineros.runtime.application.observer import Observer


def test_marking_signals_and_counts() -> None:
    observer = Observer()
    observer.see(
        [
            Start(sequence=1, node="n", marking={"a": [StoredToken(1, {})]}, signals={"S": False}),
            Fire(sequence=2, node="n", transition="t", change={"a": -1, "b": 2}),
            Signal(sequence=3, node="n", signal="S", value=True),
            Drop(sequence=4, node="n", channel="c", queue="subscriber", count=3),
        ]
    )
    assert observer.marking == {"a": 0, "b": 2}
    assert observer.signals == {"S": True}
    assert (observer.firings, observer.drops) == (1, 3)


def test_a_node_that_starts_again_says_what_it_holds() -> None:
    observer = Observer()
    observer.see([Fire(sequence=1, node="n", transition="t", change={"a": 1})])
    observer.see([Fire(sequence=1, node="other", transition="u", change={"c": 1})])
    observer.see([Checkpoint(sequence=2, node="n"), Start(sequence=3, node="n", resumed=True)])
    assert observer.marking == {"a": 0, "c": 1}
