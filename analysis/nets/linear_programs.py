"""Linear programs ``min c x, A x <= b, low <= x <= high``, solved in floating point by HiGHS.

The results are not proofs: callers check them in integers or fractions.

References
----------
Q. Huangfu, J. A. J. Hall, *Parallelizing the dual revised simplex method*, Mathematical Programming
Computation 10(1), 2018.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import cached_property
from math import lcm
from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


#: Maximum work of all solutions of one program: some seconds. It counts entries examined, a row and a column
#: for each step of the simplex method.
MOST_WORK = 400_000_000
LARGEST_DENOMINATOR, NEARLY_ZERO = 1_000, 1e-9


def in_whole_numbers(proposed: Sequence[float]) -> tuple[list[int], int]:
    """Return integers proportional to the numbers that a program proposes, and the integer for 1.

    They approximate the proposed numbers; the caller must check their properties.
    """
    values = np.asarray(proposed, dtype=np.float64)
    exact = {
        number: Fraction(float(values[number])).limit_denominator(LARGEST_DENOMINATOR)
        for number in np.flatnonzero(np.abs(values) > NEARLY_ZERO).tolist()  # most are zero
    }
    unit = lcm(*(value.denominator for value in exact.values()))
    whole = [0] * len(proposed)
    for number, value in exact.items():
        whole[number] = int(value * unit)
    return whole, unit


class LinearProgram:
    """A program whose matrix is fixed while costs and limits change.

    Parameters
    ----------
    rows : sequence of mappings
        A: by row, its entries by column, without zeros.
    most_work : int
        Maximum number of entries examined in total; then no further solutions are returned.
    is_warm : bool
        Each solution starts from the last one, which takes a fraction of the time. If there are several
        optimal solutions, the result may then depend on earlier calls.
    """

    def __init__(
        self,
        rows: Sequence[Mapping[int, float]],
        columns: int,
        most_work: int = MOST_WORK,
        *,
        is_warm: bool = True,
    ) -> None:
        self._is_warm = is_warm
        self._rows, self._columns = len(rows), columns
        self._index = np.array([column for row in rows for column in row], dtype=np.int32)
        self._value = np.array([value for row in rows for value in row.values()], dtype=np.float64)
        self._start = np.cumsum([0, *(len(row) for row in rows)]).astype(np.int32)
        self._work_left = most_work

    def solve(
        self, costs: FloatArray, limits: FloatArray, low: FloatArray, high: FloatArray
    ) -> list[float] | None:
        """Return an optimal x; None: there is none, or none was found in time.

        Parameters
        ----------
        costs : float array, shape (columns,)
            c.
        limits : float array, shape (rows,)
            b.
        low, high : float arrays, shape (columns,)
            Bounds of x; infinite where there is none.
        """
        size = self._rows + self._columns
        self._work_left -= size + self._index.size
        if self._work_left < size:
            return None
        program, optimal = self._program
        program.setOptionValue("simplex_iteration_limit", self._work_left // size)
        columns, rows = np.arange(self._columns, dtype=np.int32), np.arange(self._rows, dtype=np.int32)
        program.changeColsCost(self._columns, columns, costs)
        program.changeColsBounds(self._columns, columns, low, high)
        program.changeRowsBounds(self._rows, rows, np.full(self._rows, -np.inf), limits)
        if not self._is_warm:
            program.clearSolver()
        program.run()
        self._work_left -= size * max(0, program.getInfo().simplex_iteration_count)
        return list(program.getSolution().col_value) if program.getModelStatus() == optimal else None

    @cached_property
    def _program(self) -> tuple[Any, Any]:
        """Return HiGHS with the matrix, and its status for an optimal x."""
        import highspy

        program: Any = highspy.Highs()  # type: ignore[no-untyped-call]
        program.setOptionValue("output_flag", False)
        program.setOptionValue("threads", 1)
        # Undoing presolve may print a line on standard output regardless of options; it saves no time here.
        program.setOptionValue("presolve", "off")
        model = highspy.HighsLp()
        model.num_col_, model.num_row_ = self._columns, self._rows
        model.col_cost_ = model.col_lower_ = model.col_upper_ = np.zeros(self._columns)
        model.row_lower_ = model.row_upper_ = np.zeros(self._rows)
        model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
        model.a_matrix_.start_ = self._start
        model.a_matrix_.index_, model.a_matrix_.value_ = self._index, self._value
        program.passModel(model)
        return program, highspy.HighsModelStatus.kOptimal
