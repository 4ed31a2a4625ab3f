"""Numbers above the table that was found: another test there is never lost, and tables of results never stop one."""

from __future__ import annotations

from pathlib import Path

import pytest

from gcode.support.errors import UserError
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

ENGLISH = ["Time (s);Extension (mm);Load (N)"]
GERMAN = ["Prüfzeit;Standardweg;Standardkraft", "s;mm;N"]
LONGER = 120


def samples(count: int, columns: int = 3, below: str = "") -> list[str]:
    """Rows of a test with decimal commas, and a text behind them where one is given."""
    rows = [[f"{0.1 * n:.1f}", f"{0.5 * n:.2f}", f"{0.2 * n:.3f}", f"{900 + n:.1f}"][:columns] for n in range(count)]
    return [";".join(row).replace(".", ",") + below for row in rows]


def written(folder: Path, *blocks: list[str]) -> Path:
    path = folder / "lab.csv"
    path.write_text("\n".join(line for block in blocks for line in block) + "\n", encoding="utf-8")
    return path


TWO_TESTS = {
    "other names for the same": ([*ENGLISH, *samples(9)], [*GERMAN, *samples(LONGER)]),
    "another unit": (["Prüfzeit;Standardweg;Standardkraft", "s;mm;kN", *samples(9)], [*GERMAN, *samples(LONGER)]),
    "one column less": ([*ENGLISH, *samples(9)], ["Time [s];Extension [mm]", *samples(LONGER, 2)]),
    "a text behind each": (
        ["Time (s);Extension (mm);Load (N);Phase", *samples(9, below=";up")],
        ["Time [s];Extension [mm];Load [N];Phase", *samples(LONGER, below=";up")],
    ),
    "a phase before the test": (["Time (s);Load (N)", *samples(40, 2)], [*GERMAN, *samples(LONGER)]),
    "no names above": (samples(40, 2), [*GERMAN, *samples(LONGER)]),
    "names that say nothing": (samples(9), ["K1;K2;K3", "s;mm;N", *samples(LONGER)]),
}


@pytest.mark.parametrize("name", TWO_TESTS)
def test_a_test_above_the_table_is_not_left_out_without_a_word(tmp_path, name):
    """The longer run of numbers was taken, and that above it forgotten."""
    above, below = TWO_TESTS[name]
    with pytest.raises(UserError, match=r"the numbers in rows \d+ to \d+ would be left out.*part the file.*--header"):
        import_csv(written(tmp_path, ["Test 1"], above, ["", "Test 2"], below), Wish(40.0))


def test_the_rows_that_would_be_left_out_are_named_and_one_table_can_be_chosen(tmp_path):
    path = written(tmp_path, ["Test 1", *ENGLISH, *samples(9), "", "Test 2", *GERMAN, *samples(LONGER)])
    with pytest.raises(UserError, match=r"rows 3 to 11 would be .* table was taken to begin in row 16:"):
        import_csv(path, Wish(40.0))
    done = import_csv(path, Wish(40.0, hints=Hints(header_row=14)))
    assert len(done.recording) == LONGER
    assert "not read: the numbers in rows 3 to 11, above the table" in done.notes


def test_a_workbook_with_two_tests_is_refused(tmp_path):
    import openpyxl

    book = openpyxl.Workbook()
    for names, count in ((["Time (s)", "Extension (mm)"], 30), (["Time / s", "Extension / mm"], 90)):
        book.active.append(names)
        for n in range(count):
            book.active.append([0.1 * n, 0.5 * n])
    book.save(tmp_path / "lab.xlsx")
    with pytest.raises(UserError, match="rows 2 to 31 would be left out"):
        import_csv(tmp_path / "lab.xlsx", Wish(40.0))


RESULTS = {
    "results of specimens": ["Probe;Fmax;dL bei Fmax", "Nr;N;mm", *[f"{n};6,{n};15,{n}" for n in range(10, 40)]],
    "statistics of the same names": [";".join(["", *ENGLISH]), "Max;15,0;5,0;2,0", "Min;0,1;0,2;0,3"],
    "a calibration": ["Weight (g);Counts", *[f"{100 * n};{1234 * n}" for n in range(12)]],
    "numbers of the columns": ["1;2;3"],
}


@pytest.mark.parametrize("name", RESULTS)
def test_results_above_the_table_are_not_read_and_said(tmp_path, name):
    path = written(tmp_path, ["Report;1,5;N"], RESULTS[name], ["", "Probe 1"], GERMAN, samples(LONGER))
    done = import_csv(path, Wish(40.0))
    assert len(done.recording) == LONGER
    assert len([note for note in done.notes if note.startswith("not read: the numbers in row")]) == 1


def test_numbers_of_the_columns_may_stand_between_names_and_units(tmp_path):
    path = written(tmp_path, [GERMAN[0], "1;2;3", GERMAN[1]], samples(LONGER))
    assert len(import_csv(path, Wish(40.0)).recording) == LONGER
    with pytest.raises(UserError, match=r"the numbers in rows 3 to 4 would be left out"):
        import_csv(written(tmp_path, GERMAN, ["1;2;3", "1;2;3", "# Weg; Kraft"], samples(LONGER)), Wish(40.0))


def test_what_was_set_is_no_table(tmp_path):
    """Lines of a name and a number each, more than there are samples."""
    settings = [f"Setting {n};{n}" if n % 3 else f"Remark {n};none" for n in range(30)]
    done = import_csv(written(tmp_path, settings, GERMAN, samples(5)), Wish(40.0))
    assert len(done.recording) == 5
    assert not any(note.startswith("not read") for note in done.notes)
