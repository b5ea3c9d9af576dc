"""Walks led by the state equation: a solution says how often each transition fires; a walk tries that.

Where no firing that is left to do is enabled, some other one is fired. What is reached is reached, whatever
led there, so nothing has to be proved.

References
----------
Y. Thierry-Mieg, *Symbolic and structural model-checking*, Fundamenta Informaticae 183(3-4), 2021 (walks along
Parikh vectors).
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.properties.kernels.walks import follow as follow_counts
from dineros.analysis.properties.predicates import Int64Array, MarkingMatrix
from dineros.analysis.properties.walking import NetArrays

#: Walks for one solution.
TRIES = 5
#: Rows kept of a walk: the last ones, among which the goal is.
MOST_ROWS = 1 << 10


def follow(arrays: NetArrays, counts: Int64Array, seed: int) -> MarkingMatrix:
    """Return the last markings of a walk that fires transitions so often, in some order, as far as it can."""
    rows = np.empty((MOST_ROWS, len(arrays.net.places)), dtype=np.int64)
    written = follow_counts(arrays.parts, arrays.net.initial, counts.copy(), rows, seed)
    return MarkingMatrix(arrays.net, rows[: min(written, MOST_ROWS)])
