"""Excel workbooks: numbers as they are shown, numbers as text, several tables, and what only has the name of one."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.testbench.importing import exports
from tests.testbench.importing.exports import import_csv


def test_excel_is_read_as_it_is_shown(tmp_path):
    done = import_csv(exports.workbook(tmp_path), Wish(40.0))
    exports.check_same(done.recording)
    assert done.taken["time"].startswith("column 1 'Time [ms]' in ms")  # in one line


def written_workbook(
    folder: Path, values: list, formats: str | list[str] = "General", name: str = "R (kOhm)"
) -> Path:
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["Time (s)", "Extension (mm)", name])
    for at, value in enumerate(values):
        book.active.append([at, 0.5 * at, value])
        book.active.cell(at + 2, 3).number_format = formats if isinstance(formats, str) else formats[at]
    book.save(folder / "lab.xlsx")
    return folder / "lab.xlsx"


@pytest.mark.parametrize("form", ["#,##0.0", '0.0 "a,"', '0 "%"'])
def test_a_format_that_shows_the_number_itself_changes_nothing(tmp_path, form):
    recording = import_csv(written_workbook(tmp_path, [47e3, 46e3, 45e3], form), Wish(40.0)).recording
    assert recording["resistance_ohm"][0] == pytest.approx(47e6)


@pytest.mark.parametrize(
    ("form", "shown_in"), [("#,##0.0,", "thousands"), ('0.0,,"M"', "thousands"), ("0%", "%"), ("0.0,%", "thousands")]
)
def test_beside_a_format_that_scales_a_unit_says_nothing(tmp_path, form, shown_in):
    """R (kOhm), 47000 shown as 47: whether the header is of the numbers that are shown, nobody can tell."""
    path = written_workbook(tmp_path, [47e3, 46e3, 45e3], form)
    with pytest.raises(UserError, match=f"its unit 'kOhm shown in {shown_in}' cannot be read.*--resistance-unit"):
        import_csv(path, Wish(40.0))


def test_where_the_unit_is_said_it_is_of_the_numbers_that_are_shown(tmp_path):
    path = written_workbook(tmp_path, [47e3, 46e3, 45e3], "#,##0.0,")
    recording = import_csv(path, Wish(40.0, units={"resistance": "kOhm"})).recording
    assert recording["resistance_ohm"][0] == pytest.approx(47e3)


@pytest.mark.parametrize("form", ['0.0" kΩ"', "0.0\\ \\k\\Ω", 'General" kOhm"', '0.0 "kOhm";-0.0 "kOhm"'])
@pytest.mark.parametrize("name", ["R", "R (kOhm)"])
def test_a_format_may_show_the_unit(tmp_path, form, name):
    recording = import_csv(written_workbook(tmp_path, [47.0, 46.0, 45.0], form, name), Wish(40.0)).recording
    assert recording["resistance_ohm"].tolist() == pytest.approx([47e3, 46e3, 45e3])


def test_a_format_that_scales_shows_the_unit_of_what_it_shows(tmp_path):
    recording = import_csv(written_workbook(tmp_path, [47e3, 46e3, 45e3], '0.0," kΩ"', "R"), Wish(40.0)).recording
    assert recording["resistance_ohm"].tolist() == pytest.approx([47e3, 46e3, 45e3])


@pytest.mark.parametrize(
    ("form", "name", "said"),
    [
        ('0.0" kΩ"', "R (Ohm)", "Ohm shown in kΩ"),
        ('0.0," kΩ"', "R (Ohm)", "Ohm shown in kΩ"),
        (['0.0" kΩ"', '0.0" Ω"', '0.0" Ω"'], "R", "shown in kΩ or Ω"),
    ],
)
def test_where_header_and_format_say_other_units_none_is_known(tmp_path, form, name, said):
    """47.0 kΩ below R (Ohm) was read as 47 Ω."""
    path = written_workbook(tmp_path, [47.0, 46.0, 45.0], form, name)
    with pytest.raises(UserError, match=f"its unit '{said}' cannot be read.*--resistance-unit"):
        import_csv(path, Wish(40.0))


@pytest.mark.parametrize("name", ["dR/R0", "dR/R0 (%)", "dR/R0 (-)", "dR/R0 [1]", "dR/R0 (ohm/ohm)"])
def test_percent_of_a_ratio_are_of_one(tmp_path, name):
    """0.039 that is shown as 3.9 % was read as 3.9 where the header says no unit, or 1."""
    path = written_workbook(tmp_path, [0.0, 0.039, 0.02], "0.0%", name)
    recording = import_csv(path, Wish(40.0, r0_ohm=1000.0)).recording
    assert recording["resistance_ohm"].tolist() == pytest.approx([1000, 1039, 1020])


def test_a_column_that_is_shown_in_percent_here_and_there_has_no_unit(tmp_path):
    path = written_workbook(tmp_path, [0.01, 0.039, 0.02], ["0%", "General", "0%"], "dR/R0")
    with pytest.raises(UserError, match="its unit 'shown in % or other formats' cannot be read as one"):
        import_csv(path, Wish(40.0, r0_ohm=1000.0))


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


def test_a_chart_sheet_is_passed_over(tmp_path):
    """One without a chart yet was said to be no workbook."""
    import openpyxl

    book = openpyxl.load_workbook(exports.workbook(tmp_path))
    book.create_chartsheet("Chart", 0)
    book.save(tmp_path / "lab.xlsx")
    exports.check_same(import_csv(tmp_path / "lab.xlsx", Wish(40.0)).recording)


@pytest.mark.parametrize("name", ["lab.xlsx", "lab.tdms", "lab.xls"])
def test_what_only_has_the_name_of_a_workbook_is_a_sentence(tmp_path, name):
    (tmp_path / name).write_bytes(b"\1\0t,x\0\n\2\0,1\0\n")
    with pytest.raises(UserError, match=r"Excel|TDMS"):
        import_csv(tmp_path / name, Wish(40.0))


def test_a_number_beside_texts_has_no_decimal_sign(tmp_path):
    """Texts with a comma say nothing of the cells that hold numbers."""
    path = written_workbook(tmp_path, [*(1.5 + n for n in range(30)), "45,25"])
    found = import_csv(path, Wish(40.0)).recording
    assert found["resistance_ohm"][[0, 29, 30]] == pytest.approx([1500, 30_500, 45_250])
