"""Solutions of the state equation in whole numbers: how often transitions fire on a way."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.evidence import Row
from dineros.analysis.nets.compiled import CompiledNet

Int64Array = NDArray[np.int64]

#: Seconds for an integer program, and firings of its solution.
PROGRAM_SECONDS, MOST_STEPS = 1.0, 100_000


def firings(net: CompiledNet, rows: Sequence[Row], gains: Int64Array | None = None) -> Int64Array | None:
    """Return how often transitions fire by a smallest solution of the state equation that fulfils conditions.

    Parameters
    ----------
    net : CompiledNet
    rows : sequence of Row
        Weighted sums of tokens that have to be at least a number.
    gains : int64 array, optional
        By transition: what its firing is worth, to look for the most instead.
    """
    import highspy

    transitions = len(net.transitions)
    if not transitions:
        return None
    effects: list[tuple[dict[int, int], float]] = []
    by_place: list[dict[int, int]] = [{} for _ in net.places]
    for t, change in enumerate(net.delta):
        for p, tokens in change.items():
            by_place[p][t] = tokens
    effects += [
        (row, -float(tokens)) for row, tokens in zip(by_place, net.initial.tolist(), strict=True) if row
    ]
    for factors, bound in rows:
        sums: dict[int, int] = {}
        for p, factor in factors.items():
            for t, tokens in by_place[p].items():
                sums[t] = sums.get(t, 0) + factor * tokens
        begins = sum(factor * int(net.initial[p]) for p, factor in factors.items())
        effects.append(({t: value for t, value in sums.items() if value}, float(bound - begins)))
    program = highspy.Highs()  # type: ignore[no-untyped-call]
    program.setOptionValue("output_flag", False)
    program.setOptionValue("threads", 1)
    program.setOptionValue("time_limit", PROGRAM_SECONDS)
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = transitions, len(effects)
    model.col_cost_ = np.ones(transitions) if gains is None else 1e-3 - gains.astype(float)
    model.col_lower_, model.col_upper_ = np.zeros(transitions), np.full(transitions, float(MOST_STEPS))
    model.row_lower_ = np.array([least for _, least in effects])
    model.row_upper_ = np.full(len(effects), np.inf)
    model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    model.a_matrix_.start_ = np.cumsum([0, *(len(row) for row, _ in effects)]).astype(np.int32)
    model.a_matrix_.index_ = np.array([t for row, _ in effects for t in row], dtype=np.int32)
    model.a_matrix_.value_ = np.array([v for row, _ in effects for v in row.values()], dtype=np.float64)
    model.integrality_ = [highspy.HighsVarType.kInteger] * transitions
    program.passModel(model)
    program.run()
    found = np.array(program.getSolution().col_value)
    if found.size != transitions or not np.isfinite(found).all():
        return None
    counts: Int64Array = np.rint(found).astype(np.int64)
    return counts if 0 < counts.sum() <= MOST_STEPS else None
