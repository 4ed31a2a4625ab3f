"""Excel workbooks (.xlsx), read by openpyxl."""

from __future__ import annotations

import datetime
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import ParseError

from gcode.support import kinds
from gcode.support.errors import UserError
from testbench.importing.files import unpacking
from testbench.importing.files.unpacking import BROKEN, check_unpacked
from testbench.importing.layout import Column, count_numbers, find_layout
from testbench.importing.sheet import HEAD_ROWS, Hints, Sheet
from testbench.importing.vocabulary.laboratory_units import units_spelt
from testbench.importing.vocabulary.notation import decimal_sign, is_number

if TYPE_CHECKING:
    import pandas as pd

Cells = Sequence[Any]
# Of a number format: what is shown as it stands, colours, conditions.
_LITERAL = re.compile(r'"([^"]*)"|\\(.)|\[[^\]]*\]')
_BY_THOUSAND = re.compile(r"[0#?](,+)(?![0#?,])")  # a comma with no digit behind it
PER_CENT, THOUSANDS = "%", "thousands"


class _Scaled(float):
    """A number as the sheet shows it, with the one that the cell holds and what the format makes of that."""

    def __new__(cls, stored: float, factor: float, shown_in: str) -> _Scaled:
        made = super().__new__(cls, stored * factor)
        made.stored, made.shown_in = stored, shown_in
        return made

    stored: float
    shown_in: str


@dataclass(frozen=True)
class ExcelSheet(Sheet):
    """One sheet of a workbook."""

    rows: Sequence[Cells]

    def body(self, numbers: Sequence[int]) -> pd.DataFrame:
        """The columns with these numbers, from the first row of numbers on."""
        import pandas as pd

        rows = self.rows[self.layout.first_row - 1 :]
        columns = {
            number: [row[number - 1] if number <= len(row) else None for row in rows] for number in set(numbers)
        }
        return pd.DataFrame({number: _typed(cells) for number, cells in sorted(columns.items())})


def open_excel(path: Path, wanted: Sequence[str], hints: Hints) -> ExcelSheet:
    """Read a workbook; the sheet is the only one with a table, or the one that `hints` names.

    Raises
    ------
    UserError
        If it is no workbook, there is no such sheet, none has numbers, or several have and none was named.
    """
    sheets = _read(path, hints.sheet)
    found = {}
    for name, rows in sheets.items():
        head = [[_shown(cell) for cell in row] for row in rows[:HEAD_ROWS]]
        layout = find_layout(head, wanted, hints.header_row, hints.units_row)
        if layout and len(layout.columns) > 1:
            found[name] = (head, layout, rows)
    if not found:
        raise UserError(f"{path}: no rows of numbers in {_sheets(sheets)}; see --header-row")
    if len(found) > 1:  # a sheet of settings has no more than one number a row
        found = {name: one for name, one in found.items() if count_numbers(one[0][one[1].first_row - 1]) > 1} or found
    if len(found) > 1:
        raise UserError(f"{path}: {_sheets(found)} have tables; say which one with --sheet NAME")
    name, (head, layout, rows) = next(iter(found.items()))
    body = rows[layout.first_row - 1 :]
    layout = replace(layout, columns=tuple(_as_meant(column, body) for column in layout.columns))
    decimal = hints.decimal_said or _decimal(path, body[:HEAD_ROWS])
    return ExcelSheet(path, head, layout, decimal, "\t", {"sheet": name, "decimal": decimal}, rows)


def _as_meant(column: Column, rows: Sequence[list[Any]]) -> Column:
    """A column with the unit that its numbers are shown in, as their format says; a ratio of 1 stays as stored.

    Beside any other unit, nobody can tell whether it is of the numbers shown or of those stored: then none is known.
    """
    place = column.number - 1
    cells = [row[place] for row in rows if place < len(row)]
    forms = {getattr(cell, "shown_in", "") for cell in cells if isinstance(cell, int | float) and cell}
    if not any(forms):
        return column
    said, shown = units_spelt(column.unit_text), units_spelt("".join(forms) if len(forms) == 1 else "")
    if shown and (not column.unit_text or set(said) & set(shown)):
        return replace(column, unit_text="".join(forms), unit_from=column.unit_from or "the format of its cells")
    if forms == {PER_CENT} and any(unit.quantity == "ratio" and unit.factor == 1 for unit in said):
        for row in rows:
            if place < len(row) and isinstance(row[place], _Scaled):
                row[place] = row[place].stored
        return column
    others = " or ".join(sorted(form or "other formats" for form in forms))
    return replace(column, unit_text=f"{column.unit_text} shown in {others}".strip())


def _decimal(path: Path, rows: Sequence[Cells]) -> str:
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


def _sheets(sheets: dict[str, Any]) -> str:
    return f"the sheet{'s' if len(sheets) > 1 else ''} {', '.join(map(repr, sheets))}"


def _read(path: Path, wanted: str | None) -> dict[str, list[list[Any]]]:
    from openpyxl.reader.excel import ExcelReader
    from openpyxl.utils.exceptions import InvalidFileException

    check_unpacked(path)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of styles and extensions that are of no use here
            reader = ExcelReader(path, read_only=True, data_only=True)
            reader.read_chartsheet = lambda *_: None  # which has no cells, and openpyxl fails where it is empty
            reader.read()
            book = reader.wb
    except (*BROKEN, InvalidFileException, ParseError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: not an Excel workbook that can be read ({error}); save it again as .xlsx") from None
    try:
        names = [sheet.title for sheet in book.worksheets]
        if wanted is not None and wanted not in names:
            raise UserError(f"{path}: no sheet {wanted!r}; it has {', '.join(names)}")
        return {name: _rows(path, book[name]) for name in ([wanted] if wanted is not None else names)}
    except UserError:
        raise
    except (*BROKEN, ParseError, KeyError, IndexError, TypeError) as error:
        raise UserError(f"{path}: a workbook with broken parts ({error}); save it again as .xlsx") from None
    finally:
        book.close()


def _rows(path: Path, sheet: Any) -> list[list[Any]]:
    """The values as the sheet shows them: ``0 %`` shows 0.5 as 50 %, ``0 "N"`` as 1 N, and ``0,`` 47000 as 47."""
    from openpyxl.cell.read_only import EMPTY_CELL

    rows: list[list[Any]] = []
    count = 0
    # What a sheet says of its size would fill every row up to there.
    sheet.reset_dimensions()
    for cells in sheet.iter_rows():
        count += max(len(cells), 1)
        if count > unpacking.MOST_CELLS:
            raise UserError(
                f"{path}: sheet {sheet.title!r} has more than {unpacking.MOST_CELLS} cells, empty ones between "
                "others counted; export the table as CSV"
            )
        # Empty cells are all one object.
        rows.append([None if cell is EMPTY_CELL else _value(cell) for cell in cells])
    return rows


def _value(cell: Any) -> Any:
    """What a cell holds; a number that its format shows in a unit, or in hundredths or thousands, as it is shown."""
    if not isinstance(cell.value, int | float) or isinstance(cell.value, bool):
        return cell.value
    factor, shown_in = _shown_by(str(cell.number_format or ""))
    return _Scaled(cell.value, factor, shown_in) if shown_in else cell.value


@lru_cache
def _shown_by(number_format: str) -> tuple[float, str]:
    """What a format multiplies numbers by to show them, and the unit it shows behind them; empty where none."""
    first = number_format.partition(";")[0]
    form, unit = _LITERAL.sub("", first), "".join(map("".join, _LITERAL.findall(first))).strip()
    thousands, per_cent = _BY_THOUSAND.search(form), PER_CENT in form
    factor = (100 if per_cent else 1) / 1000 ** (len(thousands[1]) if thousands else 0)
    if units_spelt(unit) and PER_CENT not in first:
        return factor, unit
    return factor, THOUSANDS if thousands else PER_CENT * per_cent


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
