"""Tables whose cells are there one by one, whatever they were read from: a workbook, a page, JSON."""

from __future__ import annotations

import datetime
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gcode.support import kinds
from gcode.support.errors import UserError
from testbench.importing.files import unpacking
from testbench.importing.layout import column_named, count_numbers, find_layout
from testbench.importing.sheet import HEAD_ROWS, Hints, Sheet
from testbench.importing.vocabulary.notation import decimal_sign, is_number

if TYPE_CHECKING:
    import pandas as pd

Rows = Sequence[list[Any]]


@dataclass(frozen=True)
class CellSheet(Sheet):
    """One table of a file."""

    rows: Rows

    def body(self, numbers: Sequence[int]) -> pd.DataFrame:
        """The columns with these numbers, from the first row of numbers on."""
        import pandas as pd

        rows = self.rows[self.layout.first_row - 1 :]
        columns = {
            number: [row[number - 1] if number <= len(row) else None for row in rows] for number in set(numbers)
        }
        return pd.DataFrame({number: _typed(cells) for number, cells in sorted(columns.items())})


def check_size(path: Path, cells: int) -> None:
    """Refuse more cells than a recording can need.

    Raises
    ------
    UserError
    """
    if cells > unpacking.MOST_CELLS:
        raise UserError(f"{path}: it has more than {unpacking.MOST_CELLS} cells; export the table as CSV")


def sheet_of(
    path: Path, sheets: Mapping[str, Rows], wanted: Sequence[str], hints: Hints, named: bool = False
) -> CellSheet:
    """The only one of the sheets with a table, or the one that `hints` names.

    Of `named` ones, the first row is names that stand in no row of the file.

    Raises
    ------
    UserError
        If there is no such sheet, none has numbers, or several have and none was named.
    """
    if hints.sheet is not None and hints.sheet not in sheets:
        raise UserError(f"{path}: no sheet {hints.sheet!r}; it has {', '.join(sheets)}")
    found = {}
    for name in [hints.sheet] if hints.sheet is not None else sheets:
        rows = sheets[name][named:]
        head = [[_shown(cell) for cell in row] for row in rows[:HEAD_ROWS]]
        layout = find_layout(head, wanted, hints.header_row, hints.units_row)
        if named and (layout := find_layout(head, (), 0, 0)):
            columns = tuple(column_named(at, name) for at, name in enumerate(sheets[name][0], 1))
            layout = replace(layout, columns=columns, header_row=layout.first_row)
        if layout and len(layout.columns) > 1:
            found[name] = (head, layout, rows)
    if not found:
        raise UserError(f"{path}: no rows of numbers in {_sheets(sheets)}; see --header-row")
    if len(found) > 1:  # a sheet of settings has no more than one number a row
        found = {name: one for name, one in found.items() if count_numbers(one[0][one[1].first_row - 1]) > 1} or found
    if len(found) > 1:
        raise UserError(f"{path}: {_sheets(found)} have tables; say which one with --sheet NAME")
    name, (head, layout, rows) = next(iter(found.items()))
    decimal = hints.decimal_said or _decimal(path, rows[layout.first_row - 1 :][:HEAD_ROWS])
    return CellSheet(path, head, layout, decimal, "\t", {"sheet": name, "decimal": decimal}, rows)


def _decimal(path: Path, rows: Rows) -> str:
    """The decimal sign of numbers that were stored as text; those that are numbers have none."""
    texts = [cell for row in rows for cell in row if isinstance(cell, str)]
    sign = decimal_sign(texts)
    if sign is None:
        seen = next(text for text in texts if is_number(text) and ("," in text or "." in text))
        raise UserError(
            f"{path}: cannot tell what the sign means in numbers stored as text such as {seen!r}; "
            "say --decimal , or --decimal ."
        )
    return sign


def _sheets(sheets: Mapping[str, Any]) -> str:
    return f"the sheet{'s' if len(sheets) > 1 else ''} {', '.join(map(repr, sheets))}"


def _shown(cell: Any) -> str:
    if cell is None:
        return ""
    if isinstance(cell, datetime.datetime):
        return cell.isoformat(sep=" ")
    return str(cell).replace("\n", " ")


def _typed(cells: list[Any]) -> pd.Series:
    import pandas as pd

    if all(cell is None or kinds.is_number(cell) for cell in cells):
        return pd.Series(cells, dtype="float64")
    if all(cell is None or isinstance(cell, datetime.datetime) for cell in cells):
        return pd.to_datetime(pd.Series(cells))
    if all(cell is None or isinstance(cell, datetime.timedelta) for cell in cells):
        return pd.to_timedelta(pd.Series(cells))
    return pd.Series(
        [cell if cell is None or kinds.is_number(cell) else _shown(cell) for cell in cells], dtype=object
    )
