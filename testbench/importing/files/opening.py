"""Open a file as a table of cells, by its kind: text, Excel or TDMS."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from gcode.support.errors import UserError
from gcode.support.strict import check_plain
from testbench.importing.sheet import Hints, Sheet
from testbench.recordings.csv_columns import MOST_BYTES

WORKBOOKS = (".xlsx", ".xlsm")


def open_sheet(path: Path, wanted: Sequence[str], hints: Hints) -> Sheet:
    """Read the top of a file and find its layout.

    Parameters
    ----------
    path : Path
        ``.xlsx`` and ``.xlsm`` are read as Excel, ``.tdms`` as TDMS, anything else as text.
    wanted : sequence of str
        Names that its header must have, as far as a person gave some.
    hints : Hints

    Raises
    ------
    UserError
        If it cannot be read, or has no numbers.
    """
    kind = path.suffix.lower()
    if kind == ".xls":
        raise UserError(f"{path}: the old Excel format; open it in Excel or LibreOffice and save it as .xlsx")
    check_plain(path, "table", MOST_BYTES)
    if hints.sheet and kind not in (*WORKBOOKS, ".tdms"):
        raise UserError(
            f"`sheet` is of a workbook or a TDMS file, which this is not; leave it out, got {hints.sheet!r}"
        )
    if kind in WORKBOOKS:
        from testbench.importing.files.excel_file import open_excel

        return open_excel(path, wanted, hints)
    if kind == ".tdms":
        from testbench.importing.files.tdms_file import open_tdms

        return open_tdms(path, hints)
    from testbench.importing.files.text_file import open_text

    return open_text(path, wanted, hints)
