"""Exact times where they are known, and safe bounds where they are not."""

from __future__ import annotations

from dineros.analysis.latencies.results import Everything, Latency


def known_latency(exact: Latency, bound: Latency) -> Latency:
    """Return the exact times of something if they were found, else its bounds if these are narrower."""
    return bound if exact.greatest is None and exact.reason and bound.greatest is not None else exact


def known_everything(exact: Everything, bound: Everything) -> Everything:
    """Return what was found exactly, and bounds of the rest."""
    callbacks = {
        name: known_latency(exact.callbacks[name], each) if name in exact.callbacks else each
        for name, each in bound.callbacks.items()
    }
    is_exact = exact.is_exact and bool(exact.callbacks)
    source = exact if is_exact else bound
    return Everything(callbacks, source.readers, source.timers, exact.starved, is_exact, source.reasons)
