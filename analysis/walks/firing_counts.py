"""Solutions of the state equation in whole numbers: how often transitions fire on a way, or in a loop.

The equation does not see what a firing looks at and leaves as it is. In a loop, a transition that needs
tokens of a place and one that the same tokens inhibit can both fire only if something takes tokens from the
place; so much is added for loops, with a variable for each such transition that says whether it fires.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.evidence import Row
from dineros.analysis.nets.compiled import CompiledNet

Int64Array = NDArray[np.int64]

#: Nodes and seconds for an integer program, and firings of its solution. Most programs take one node, and
#: milliseconds; seconds are a guard, as another number of them gives another solution.
PROGRAM_NODES, PROGRAM_SECONDS, MOST_STEPS = 500, 2.0, 100_000


def firings(
    net: CompiledNet, rows: Sequence[Row], gains: Int64Array | None = None, *, is_loop: bool = False
) -> Int64Array | None:
    """Return how often transitions fire by a smallest solution of the state equation that fulfils conditions.

    Parameters
    ----------
    rows : sequence of Row
        Weighted sums of tokens that have to be at least a number.
    gains : int64 array, optional
        By transition: what its firing is worth, to look for the most instead.
    is_loop : bool
        Whether the firings are to be repeated from wherever they begin; then the net has no initial tokens.
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
    fires, limits = _exclusions(net, by_place) if is_loop else ([], [])
    columns = transitions + len(fires)
    effects += limits
    program = highspy.Highs()  # type: ignore[no-untyped-call]
    program.setOptionValue("output_flag", False)
    program.setOptionValue("threads", 1)
    program.setOptionValue("mip_max_nodes", PROGRAM_NODES)
    program.setOptionValue("time_limit", PROGRAM_SECONDS)
    model = highspy.HighsLp()
    model.num_col_, model.num_row_ = columns, len(effects)
    costs = np.ones(transitions) if gains is None else 1e-3 - gains.astype(float)
    model.col_cost_ = np.concatenate([costs, np.zeros(len(fires))])
    model.col_lower_ = np.zeros(columns)
    model.col_upper_ = np.concatenate([np.full(transitions, float(MOST_STEPS)), np.ones(len(fires))])
    model.row_lower_ = np.array([least for _, least in effects])
    model.row_upper_ = np.full(len(effects), np.inf)
    model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
    model.a_matrix_.start_ = np.cumsum([0, *(len(row) for row, _ in effects)]).astype(np.int32)
    model.a_matrix_.index_ = np.array([t for row, _ in effects for t in row], dtype=np.int32)
    model.a_matrix_.value_ = np.array([v for row, _ in effects for v in row.values()], dtype=np.float64)
    model.integrality_ = [highspy.HighsVarType.kInteger] * columns
    program.passModel(model)
    program.run()
    found = np.array(program.getSolution().col_value)
    if found.size != columns or not np.isfinite(found).all():
        return None
    counts: Int64Array = np.rint(found[:transitions]).astype(np.int64)
    return counts if 0 < counts.sum() <= MOST_STEPS else None


def _exclusions(
    net: CompiledNet, by_place: Sequence[dict[int, int]]
) -> tuple[list[int], list[tuple[dict[int, int], float]]]:
    """Return which transitions get a variable, after those of all, and rows that exclude some together."""
    transitions = len(net.transitions)
    needing: dict[int, list[tuple[int, int]]] = {}
    inhibited: dict[int, list[tuple[int, int]]] = {}
    for t in range(transitions):
        for p, weight in net.inhibitor.row(t):
            inhibited.setdefault(p, []).append((t, weight))
        for p, weight in net.pre.row(t):
            if net.delta[t].get(p, 0) >= 0:  # what takes some itself excludes nothing
                needing.setdefault(p, []).append((t, weight))
    pairs = [
        (p, one, other)
        for p, inhibiting in inhibited.items()
        for other, most in inhibiting
        for one, least in needing.get(p, [])
        if least >= most
    ]
    fires = sorted({t for _, *both in pairs for t in both})
    column = {t: transitions + number for number, t in enumerate(fires)}
    rows: list[tuple[dict[int, int], float]] = [({t: -1, column[t]: MOST_STEPS}, 0.0) for t in fires]
    for p, one, other in pairs:
        takes = {t: 1 for t, tokens in by_place[p].items() if tokens < 0}
        both = {column[one]: -1, column[other]: -1}
        rows.append((takes | both, -1.0))
    return fires, rows
