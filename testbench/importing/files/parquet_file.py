"""Parquet files, read by pyarrow."""

from __future__ import annotations

from pathlib import Path

from gcode.support.errors import UserError
from testbench.importing.files.cells import check_size
from testbench.importing.files.tdms_file import ColumnSheet
from testbench.importing.layout import find_layout
from testbench.importing.sheet import HEAD_ROWS


def open_parquet(path: Path) -> ColumnSheet:
    """Read a Parquet file; what is nested in a column has its name and that of the column.

    Raises
    ------
    UserError
        If pyarrow is not there, the file cannot be read, is too large, or has no numbers.
    """
    try:
        import pyarrow as pa
        from pyarrow import parquet
    except ImportError:
        raise UserError(
            f"{path}: a Parquet file, which needs pyarrow; install it with: pip install 'knitbench[parquet]'"
        ) from None
    try:
        with parquet.ParquetFile(path) as file:
            check_size(path, file.metadata.num_rows * file.metadata.num_columns)
            table = file.read().flatten()
    except UserError:
        raise
    except (pa.ArrowException, OSError, ValueError) as error:
        raise UserError(f"{path}: not a Parquet file that can be read ({str(error)[:200]})") from None
    columns = [column.to_pandas() for column in table.columns]
    shown = (map(str, values[:HEAD_ROWS]) for values in columns)
    head = [table.column_names, *map(list, zip(*shown, strict=True))]
    layout = find_layout(head, (), 1, 0)
    if layout is None:
        raise UserError(f"{path}: no column of it holds numbers")
    return ColumnSheet(path, head, layout, ".", "\t", {}, columns)
