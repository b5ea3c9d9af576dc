"""Tables of sweeps: CSV and Parquet."""

from __future__ import annotations

import csv
import io
from decimal import Decimal
from pathlib import Path

import pytest

from dineros.analysis.sweeps import SweepError
from dineros.analysis.sweeps.tables import Row, to_csv, to_parquet, write_table, writer_for

ROWS: list[Row] = [
    {"A.tokens": 0, "T.clause": "a, b", "reduced": False, "states": 3, "arcs": 2**63 - 1, "seconds": 0.5},
    {"A.tokens": 1, "T.clause": 'say "x"', "reduced": True, "states": 2**63, "arcs": None, "seconds": None},
]


def parquet(rows: list[Row]) -> tuple[dict[str, str], list[dict[str, object]]]:
    from pyarrow import BufferReader
    from pyarrow.parquet import read_table

    table = read_table(BufferReader(to_parquet(rows)))
    return {field.name: str(field.type) for field in table.schema}, table.to_pylist()


def test_csv_has_whole_numbers_in_full() -> None:
    assert list(csv.reader(io.StringIO(to_csv(ROWS).decode()))) == [
        ["A.tokens", "T.clause", "reduced", "states", "arcs", "seconds"],
        ["0", "a, b", "false", "3", "9223372036854775807", "0.5"],
        ["1", 'say "x"', "true", "9223372036854775808", "", ""],
    ]


def test_parquet_is_exact_whatever_the_size() -> None:
    types, rows = parquet(ROWS)
    assert types == {
        "A.tokens": "int64",
        "T.clause": "string",
        "reduced": "bool",
        "states": "decimal128(38, 0)",
        "arcs": "int64",
        "seconds": "double",
    }
    assert rows == [*map(dict, ROWS)]


@pytest.mark.parametrize(
    ("number", "kind", "read"),
    [
        (10**38 - 1, "decimal128(38, 0)", Decimal(10**38 - 1)),
        (10**38, "decimal256(76, 0)", Decimal(10**38)),
        (10**76 - 1, "decimal256(76, 0)", Decimal(10**76 - 1)),
        (10**76, "string", str(10**76)),
        (-(2**63), "int64", -(2**63)),
    ],
)
def test_a_column_is_as_wide_as_its_largest_number(number: int, kind: str, read: object) -> None:
    types, rows = parquet([{"states": 1}, {"states": None}, {"states": number}])
    assert types == {"states": kind}
    assert rows[2]["states"] == read
    assert rows[1]["states"] is None
    assert int(str(rows[0]["states"])) == 1


def test_a_column_without_values() -> None:
    assert parquet([{"states": None}]) == ({"states": "null"}, [{"states": None}])


def test_equal_rows_give_equal_bytes() -> None:
    assert to_parquet(ROWS) == to_parquet([*map(dict, ROWS)])
    assert to_csv(ROWS) == to_csv([*map(dict, ROWS)])


def test_the_suffix_tells_the_format(tmp_path: Path) -> None:
    write_table(ROWS, tmp_path / "a.CSV")
    assert (tmp_path / "a.CSV").read_bytes() == to_csv(ROWS)
    for name, says in (("a.xls", "'.xls' is not a format of tables"), ("a", "has no suffix")):
        with pytest.raises(SweepError, match=says):
            writer_for(tmp_path / name)
