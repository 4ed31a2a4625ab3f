"""Excel workbooks (.xlsx), read by openpyxl."""

from __future__ import annotations

import re
import warnings
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO
from xml.etree.ElementTree import ParseError

from gcode.support.errors import UserError
from testbench.importing.files import unpacking
from testbench.importing.files.cells import CellSheet, sheet_of
from testbench.importing.files.unpacking import BROKEN, check_unpacked
from testbench.importing.layout import Column
from testbench.importing.sheet import Hints
from testbench.importing.vocabulary.laboratory_units import units_spelt

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


def open_excel(path: Path, wanted: Sequence[str], hints: Hints) -> CellSheet:
    """Read a workbook; the sheet is the only one with a table, or the one that `hints` names.

    Raises
    ------
    UserError
        If it is no workbook, there is no such sheet, none has numbers, or several have and none was named.
    """
    sheet = sheet_of(path, _read(path, hints.sheet), wanted, hints)
    body = sheet.rows[sheet.layout.first_row - 1 :]
    columns = tuple(_as_meant(column, body) for column in sheet.layout.columns)
    return replace(sheet, layout=replace(sheet.layout, columns=columns))


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


def _read(path: Path, wanted: str | None) -> dict[str, list[list[Any]]]:
    check_unpacked(path)
    with path.open("rb") as stream:  # of a path, openpyxl believes the ending
        book = _book(path, stream)
        try:
            names = [sheet.title for sheet in book.worksheets]
            return {name: _rows(path, book[name]) if wanted in (None, name) else [] for name in names}
        except UserError:
            raise
        except (*BROKEN, ParseError, KeyError, IndexError, TypeError) as error:
            raise UserError(f"{path}: a workbook with broken parts ({error}); save it again as .xlsx") from None
        finally:
            book.close()


def _book(path: Path, stream: BinaryIO) -> Any:
    from openpyxl.reader.excel import ExcelReader

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of styles and extensions that are of no use here
            reader = ExcelReader(stream, read_only=True, data_only=True)
            reader.read_chartsheet = lambda *_: None  # which has no cells, and openpyxl fails where it is empty
            reader.read()
            return reader.wb
    except (*BROKEN, ParseError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path}: not an Excel workbook that can be read ({error}); save it again as .xlsx") from None


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
