"""Excel workbooks: numbers as they are shown, numbers as text, several tables, and what only has the name of one."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.importing.from_file import import_csv
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.testbench.importing import exports


def test_excel_is_read_as_it_is_shown(tmp_path):
    exports.check_same(import_csv(exports.workbook(tmp_path), Wish(40.0)).recording)


def written_workbook(folder: Path, values: list, number_format: str = "General") -> Path:
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["Time (s)", "Extension (mm)", "R (kOhm)"])
    for at, value in enumerate(values):
        book.active.append([at, 0.5 * at, value])
        book.active.cell(at + 2, 3).number_format = number_format
    book.save(folder / "lab.xlsx")
    return folder / "lab.xlsx"


@pytest.mark.parametrize(
    ("form", "shown"), [("#,##0.0,", 47_000), ('0.0,,"M"', 47), ("#,##0.0", 47e6), ('0.0 "a,"', 47e6), ("0%", 47e8)]
)
def test_a_number_is_what_the_sheet_shows(tmp_path, form, shown):
    """A header that says kOhm is of what stands there: a format may show a thousandth of what the cell holds."""
    recording = import_csv(written_workbook(tmp_path, [47e3, 46e3, 45e3], form), Wish(40.0)).recording
    assert recording["resistance_ohm"][0] == pytest.approx(shown)


def test_numbers_that_a_workbook_holds_as_text(tmp_path):
    path = written_workbook(tmp_path, ["46,5", "46,4", "46,3"])
    assert import_csv(path, Wish(40.0)).recording["resistance_ohm"][0] == pytest.approx(46_500)
    path = written_workbook(tmp_path, ["46,512", "46,412", "46,312"])
    with pytest.raises(UserError, match="numbers stored as text such as '46,512'; say --decimal"):
        import_csv(path, Wish(40.0))
    recording = import_csv(path, Wish(40.0, hints=Hints(decimal=","))).recording
    assert recording["resistance_ohm"][0] == pytest.approx(46_512)


def test_of_several_tables_in_a_workbook_one_must_be_named(tmp_path):
    import openpyxl

    book = openpyxl.load_workbook(exports.workbook(tmp_path))
    copy = book.copy_worksheet(book["Data"])
    copy.title = "Again"
    book.save(tmp_path / "two.xlsx")
    with pytest.raises(UserError, match="'Data', 'Again' have tables; say which one with --sheet"):
        import_csv(tmp_path / "two.xlsx", Wish(40.0))
    exports.check_same(import_csv(tmp_path / "two.xlsx", Wish(40.0, hints=Hints(sheet="Data"))).recording)
    with pytest.raises(UserError, match="no sheet 'Dat'; it has Remarks, Data, Again"):
        import_csv(tmp_path / "two.xlsx", Wish(40.0, hints=Hints(sheet="Dat")))


@pytest.mark.parametrize("name", ["lab.xlsx", "lab.tdms", "lab.xls"])
def test_what_only_has_the_name_of_a_workbook_is_a_sentence(tmp_path, name):
    (tmp_path / name).write_text("t,x\n0,1\n")
    with pytest.raises(UserError, match=r"Excel|TDMS"):
        import_csv(tmp_path / name, Wish(40.0))
