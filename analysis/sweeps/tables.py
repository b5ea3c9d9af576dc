"""The table of a sweep, as CSV or Parquet."""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from dineros.analysis.sweeps.grid import SweepError
from dineros.metamodel.errors import Location
from dineros.metamodel.files.atomic import write_atomically

if TYPE_CHECKING:
    import pyarrow

Value = str | int | float | bool | None
Row = dict[str, Value]


def writer_for(path: Path) -> Callable[[Sequence[Row]], bytes]:
    """Return a function that makes the content of a file, by the file's suffix.

    Raises
    ------
    SweepError
        The suffix is unknown, or pyarrow is not installed.
    """
    suffix = path.suffix.lower()
    if suffix == ".csv":
        return to_csv
    if suffix == ".parquet":
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError:
            raise SweepError(
                "Parquet needs pyarrow",
                location=Location(path),
                hint="pip install 'dineros[analysis]', or write .csv",
            ) from None
        return to_parquet
    raise SweepError(
        f"{suffix!r} is not a format of tables" if suffix else "has no suffix",
        location=Location(path),
        hint="known are .csv and .parquet",
    )


def write_table(rows: Sequence[Row], path: Path) -> None:
    """Write rows with equal columns, completely or not at all.

    Raises
    ------
    SweepError
        The suffix is unknown, or pyarrow is not installed.
    ModelFileError
        The file cannot be written.
    """
    write_atomically(path, writer_for(path)(rows))


def to_csv(rows: Sequence[Row]) -> bytes:
    """Return rows as CSV (RFC 4180, but with Unix line ends): integers in full, empty for None."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows([_text(value) for value in row.values()] for row in rows)
    return text.getvalue().encode()


def _text(value: Value) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    return "" if value is None else str(value)


def to_parquet(rows: Sequence[Row]) -> bytes:
    """Return rows as Parquet.

    A column of integers is ``int64``. If one of them is larger, the column is ``decimal`` without a fraction,
    which is exact to 76 digits, and beyond that text.
    """
    import pyarrow
    import pyarrow.parquet

    columns = {name: [row[name] for row in rows] for name in rows[0]}
    table = pyarrow.table({name: _column(values) for name, values in columns.items()})
    sink = pyarrow.BufferOutputStream()
    pyarrow.parquet.write_table(table, sink)
    return bytes(sink.getvalue().to_pybytes())


def _column(values: Sequence[Value]) -> pyarrow.Array:
    from decimal import Context

    import pyarrow

    numbers = [value for value in values if isinstance(value, int) and not isinstance(value, bool)]
    if len(numbers) < sum(value is not None for value in values) or not numbers:
        return pyarrow.array(values)
    digits = max(len(str(abs(number))) for number in numbers)
    if all(-(1 << 63) <= number < 1 << 63 for number in numbers):
        return pyarrow.array(values, pyarrow.int64())
    if digits > 76:
        return pyarrow.array([None if value is None else str(value) for value in values])
    exact = Context(prec=76)
    kind = pyarrow.decimal128(38) if digits <= 38 else pyarrow.decimal256(76)
    return pyarrow.array([None if value is None else exact.create_decimal(value) for value in values], kind)
