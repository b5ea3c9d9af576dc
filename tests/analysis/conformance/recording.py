"""Runs in one process, and what they record."""

from __future__ import annotations

import random
import tempfile
from functools import partial
from pathlib import Path

from dineros.metamodel import sym
from dineros.metamodel.records import Record, read_trace, traces_of_runs
from dineros.runtime.application.simulation import LocalApplication
from dineros.runtime.journal import JournalRecorder
from dineros.transformations.flattening.split import split


def recorded(model: sym.SystemModel, seed: int, steps: int) -> dict[str, list[Record]]:
    """Return the traces of a run in one process, with signals that change."""
    with tempfile.TemporaryDirectory() as folder:
        application = LocalApplication(
            split(model), seed=seed, recorder=partial(JournalRecorder, Path(folder))
        )
        application.open()
        draw = random.Random(seed)
        signals = [(net, name) for net in application.nets.values() for name in net.structure.signals]
        for _ in range(steps):
            if signals and draw.random() < 0.2:
                net, name = draw.choice(signals)
                values = net.signal(name).values
                net.signal(name).set(draw.choice(values) if values else draw.random() < 0.5)
            application.step()
        application.close()
        return {node: list(read_trace(parts)) for node, parts in traces_of_runs([Path(folder)]).items()}
