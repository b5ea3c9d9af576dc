"""Linear programs ``min c x, A x <= b, low <= x <= high``, solved in floating point by HiGHS.

What a program proposes is checked in integers or fractions by whoever uses it: nothing is proved here.

References
----------
Q. Huangfu, J. A. J. Hall, *Parallelizing the dual revised simplex method*, Mathematical Programming
Computation 10(1), 2018.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]


class LinearProgram:
    """A program whose matrix stays while costs and limits change.

    Parameters
    ----------
    matrix : array, shape (rows, columns)
        A.
    """

    def __init__(self, matrix: NDArray[Any]) -> None:
        self._rows, self._columns = matrix.shape
        row, column = np.nonzero(matrix)
        self._index = column.astype(np.int32)
        self._value = matrix[row, column].astype(np.float64)
        self._start = np.searchsorted(row, np.arange(self._rows)).astype(np.int32)

    def solve(
        self, costs: FloatArray, limits: FloatArray, low: FloatArray, high: FloatArray
    ) -> list[float] | None:
        """Return an optimal x; None where there is none.

        Parameters
        ----------
        costs : float array, shape (columns,)
            c.
        limits : float array, shape (rows,)
            b.
        low, high : float arrays, shape (columns,)
            Bounds of x; infinite where there is none.
        """
        import highspy

        program: Any = highspy.Highs()  # type: ignore[no-untyped-call]
        program.setOptionValue("output_flag", False)
        program.setOptionValue("threads", 1)
        model = highspy.HighsLp()
        model.num_col_, model.num_row_ = self._columns, self._rows
        model.col_cost_, model.col_lower_, model.col_upper_ = costs, low, high
        model.row_lower_, model.row_upper_ = np.full(self._rows, -np.inf), limits
        model.a_matrix_.format_ = highspy.MatrixFormat.kRowwise
        model.a_matrix_.start_ = np.append(self._start, self._index.size).astype(np.int32)
        model.a_matrix_.index_, model.a_matrix_.value_ = self._index, self._value
        program.passModel(model)
        program.run()
        if program.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        return list(program.getSolution().col_value)
