"""Files of laboratories that none of us has seen: what a person reads at a glance is read, row by row."""

from __future__ import annotations

from datetime import datetime, timedelta

import numpy as np
import openpyxl
import pytest

from gcode.support.errors import UserError
from testbench.cli import main
from testbench.importing.files.encodings import encoding_of
from testbench.importing.from_file import import_file
from testbench.importing.sheet import Hints
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

COUNT = 40
T, X, F, R = (np.round(np.arange(COUNT) * step, 3) for step in (0.1, 0.25, 0.5, 40.0))
R = R + 4700
WISH = Wish(40.0)


def _written(path, lines, encoding="utf-8"):
    path.write_bytes(("\n".join(lines) + "\n").encode(encoding))
    return path


def _rows(form, *columns):
    return [form.format(*map(float, cells)) for cells in zip(*columns, strict=True)]


def _check(found, resistance=False):
    assert found.time_s == pytest.approx(T)
    assert found["displacement_mm"] == pytest.approx(X)
    assert found["force_N"] == pytest.approx(F)
    if resistance:
        assert found["resistance_ohm"] == pytest.approx(R)


@pytest.mark.parametrize("sign", ["# ", "% ", "// ", "#"])
def test_the_sign_of_a_comment_before_names_is_no_name(tmp_path, sign):
    rows = _rows("{:.18e} {:.18e} {:.18e} {:.18e}", T, X, F, R)
    path = _written(tmp_path / "numpy.dat", [f"{sign}t_s x_mm F_N R_ohm", *rows])
    _check(import_csv(path, WISH).recording, resistance=True)


@pytest.mark.parametrize("between", [["knit 4"], ["-" * 30], ["", "BEGIN", ""]])
def test_a_line_or_a_remark_between_names_and_numbers_is_passed_over(tmp_path, between):
    lines = ["Time\tExtension\tLoad\tR", "s\tmm\tN\tkΩ", *between, *_rows("{}\t{}\t{}\t{}", T, X, F, R / 1e3)]
    _check(import_csv(_written(tmp_path / "origin.txt", lines), WISH).recording, resistance=True)


def test_a_row_of_limits_below_the_names_is_none_of_the_table(tmp_path):
    lines = ["Time (s),Ext. (mm),Load (N)", "60 s,500 mm,25 N", *_rows("{},{},{}", T, X, F)]
    _check(import_csv(_written(tmp_path / "lab.csv", lines), WISH).recording)


def test_settings_above_numbers_without_names_are_no_names(tmp_path):
    boot = ["rst:0x1 (POWERON),boot:0x8 (SPI)", "load:0x40,len:0xad0", "entry 0x403c98d4"]
    said = {"columns": {"time": "1", "displacement": "2"}, "units": {"time": "s", "displacement": "mm"}}
    path = _written(tmp_path / "esp.log", [*boot, *_rows("{},{},{}", T, X, F)])
    found = import_csv(path, Wish(40.0, **said)).recording
    assert found["displacement_mm"] == pytest.approx(X)


@pytest.mark.parametrize(
    ("strain", "form", "resistance", "other"),
    [
        ("Dehnung", "{};{:.4f}%;{};{}", "Widerstand [Ohm]", 1.0),
        ("Strain (%)", "{};{:.4f} %;{};{} kOhm", "Resistance", 1e3),
        ("Strain", "{};{:.4f}%;{};{}KOHM", "R", 1e3),
    ],
)
def test_the_unit_may_stand_in_the_cells(tmp_path, strain, form, resistance, other):
    rows = _rows(form, T, X / 0.4, F, R / other)
    names = f"Time [s];{strain};Force [N];{resistance}"
    _check(import_csv(_written(tmp_path / "a.csv", [names, *rows]), WISH).recording, resistance=True)
    commas = [row.replace(".", ",") for row in rows]
    _check(import_csv(_written(tmp_path / "b.csv", [names, *commas]), WISH).recording, resistance=True)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_unit_beside_numbers_with_decimal_commas(tmp_path, separator):
    """Of what pandas had read as a number already, the point parted thousands: 1.234 kΩ were 1 234."""
    rows = [row.replace(";", separator).replace(".", ",") for row in _rows("{};{};{};{};kOhm", T, X, F, R / 1e3)]
    names = "Zeit [s];Weg [mm];Kraft [N];Widerstand;Einheit".replace(";", separator)
    _check(import_csv(_written(tmp_path / "meter.csv", [names, *rows]), WISH).recording, resistance=True)


def test_each_cell_counts_in_its_own_unit_and_one_without_is_refused(tmp_path):
    cells = [f"{ohm:g} Ohm" if n % 2 else f"{ohm / 1e3:.6f} kOhm" for n, ohm in enumerate(R)]
    rows = [f"{t},{x},{f},{cell}" for t, x, f, cell in zip(T, X, F, cells, strict=True)]
    names = "Time (s),Extension (mm),Load (N),Resistance"
    _check(import_csv(_written(tmp_path / "meter.csv", [names, *rows]), WISH).recording, resistance=True)
    for header, cell in ((names, "4700"), (names, "4.7 kN"), (f"{names} (Ohm)", "4.7 kOhm"), (names, "5 %")):
        bad = [*rows[:9], f"{T[9]},{X[9]},{F[9]},{cell}", *rows[10:]]
        bad = [row.replace(cells[0], "4700 Ohm") for row in bad]
        with pytest.raises(UserError, match=r"must be a number with (a unit of resistance|Ω, as header says), got"):
            import_csv(_written(tmp_path / "bad.csv", [header, *bad]), WISH)


@pytest.mark.parametrize("name", ["Rs[ohm]", "Rdc (Ohm)", "Resist. [Ohm]"])
def test_the_resistance_of_an_lcr_meter(tmp_path, name):
    rows = _rows("{},{},{},{},-0.3", T, X, F, R)
    path = _written(tmp_path / "lcr.csv", [f"TIME[s],STROKE[mm],LOAD[N],{name},X[ohm]", *rows])
    _check(import_csv(path, WISH).recording, resistance=True)


def test_percent_of_a_resistance_lead_to_what_is_relative(tmp_path):
    for header, form in (("Resistance (%)", "{},{},{}"), ("Resistance", "{},{},{}%")):
        path = _written(tmp_path / "film.csv", [f"Time (s),Extension (mm),{header}", *_rows(form, T, X, R / 47)])
        with pytest.raises(UserError, match=r"its unit '%' cannot be read as one; .* or --relative-resistance 3 "):
            import_csv(path, WISH)
        found = import_csv(path, Wish(40.0, {"relative": "3"}, r0_ohm=4700.0)).recording
        assert found["resistance_ohm"] == pytest.approx(R)


def test_a_single_cell_with_a_unit_among_plain_ones_is_no_number(tmp_path):
    rows = _rows("{},{},{}", T, X, F)
    rows[5] = "0.5,1.25 cm,2.5"
    with pytest.raises(UserError, match=r"row 7: Extension \(mm\) must be a number, got '1.25 cm'"):
        import_csv(_written(tmp_path / "lab.csv", ["Time (s),Extension (mm),Load (N)", *rows]), WISH)


@pytest.mark.parametrize("separator", [",", ";", " "])
def test_exponents_of_fortran(tmp_path, separator):
    rows = [row.replace("e", "D").replace(" ", separator) for row in _rows("{:.8e} {:.8e} {:.8e}", T, X, F)]
    names = "TIME(S) DISP(MM) FORCE(N)".replace(" ", separator)
    _check(import_csv(_written(tmp_path / "run.dat", [names, *rows]), WISH).recording)


def _labview(names, units, rows, dimension="Time"):
    head = ["LabVIEW Measurement", "Writer_Version\t2", "Separator\tTab", "***End_of_Header***", ""]
    about = {"Channels": "2", "Samples": f"{COUNT}", "Date": "2024/03/12", "Time": "10:12:44.1"}
    lines = [f"{name}\t{text}\t{text}" for name, text in about.items()]
    lines += [
        f"Y_Unit_Label\t{units}",
        f"X_Dimension\t{dimension}\t{dimension}",
        "X0\t0.0E+0\t0.0E+0",
        "Delta_X\t0.1",
    ]
    return [*head, *lines, "***End_of_Header***\t\t\t", names, *rows]


def test_the_header_of_labview_says_units_and_time(tmp_path):
    names, rows = "X_Value\tDisplacement\tForce\tComment", _rows("{}\t{}\t{}", T, X, F / 1e3)
    path = _written(tmp_path / "lab.lvm", _labview(names, "mm\tkN", rows))
    _check(import_csv(path, WISH).recording)
    _check(import_csv(path, Wish(40.0, {"time": "X_Value"})).recording)
    path = _written(tmp_path / "spectrum.lvm", _labview(names, "mm\tkN", rows, "Frequency"))
    with pytest.raises(UserError, match="no time found"):
        import_csv(path, WISH)
    names, rows = "X_Value\tDisplacement\tX_Value\tForce\tComment", _rows("{}\t{}\t{}\t{}", T, X, T, F)
    _check(import_csv(_written(tmp_path / "two.lvm", _labview(names, "mm\t\tN", rows)), WISH).recording)


def _clocks(form, step_s):
    start = datetime(2024, 3, 12, 23, 50)
    return [f"{(start + timedelta(seconds=n * step_s)):{form}}" for n in range(COUNT)]


@pytest.mark.parametrize(
    ("name", "cells", "unit", "step_s"),
    [
        ("Time", _clocks("%H:%M", 60), "h", 60),
        ("Time", _clocks("%H:%M", 60), "date", 60),
        ("Time [hh:mm]", _clocks("%H:%M", 60), "", 60),
        ("Time", _clocks("%I:%M %p", 60), "", 60),
        ("Time", [f"{n // 6:02d}:{10 * (n % 6):02d}" for n in range(COUNT)], "min", 10),
        ("Elapsed (mm:ss)", [f"{n // 6:02d}:{10 * (n % 6):02d}" for n in range(COUNT)], "", 10),
    ],
)
def test_times_of_two_numbers(tmp_path, name, cells, unit, step_s):
    rows = [f"{cell},{x},{f}" for cell, x, f in zip(cells, X, F, strict=True)]
    path = _written(tmp_path / "lab.csv", [f"{name},Extension (mm),Load (N)", *rows])
    found = import_csv(path, Wish(40.0, units={"time": unit} if unit else {})).recording
    assert found.time_s == pytest.approx(step_s * np.arange(COUNT))


def test_what_times_of_two_numbers_count_is_asked_unless_days_stand_beside_them(tmp_path):
    rows = [f"{cell};{x};{f}" for cell, x, f in zip(_clocks("%H:%M", 60), X, F, strict=True)]
    path = _written(tmp_path / "lab.csv", ["Time;Extension (mm);Load (N)", *rows])
    with pytest.raises(UserError, match="its unit 'h:min or min:s' cannot be read as one; say --time-unit"):
        import_csv(path, WISH)
    with pytest.raises(UserError, match="must be a number, got '23:50'"):
        import_csv(path, Wish(40.0, units={"time": "s"}))
    days = [f"{day};{row}" for day, row in zip(_clocks("%d.%m.%Y", 60), rows, strict=True)]
    path = _written(tmp_path / "days.csv", ["Date;Time;Extension (mm);Load (N)", *days])
    assert import_csv(path, WISH).recording.time_s == pytest.approx(60 * np.arange(COUNT))


@pytest.mark.parametrize("names", [["A", "B"], ["knit 1/2", "knit 3"], ["1", "2"], ["A1", "2"]])
def test_specimens_may_have_names(tmp_path, names):
    rows = [f"{name},{row}" for name in names for row in _rows("{},{},{}", T, X, F)]
    path = _written(tmp_path / "all.csv", ["Specimen,Time (s),Extension (mm),Load (N)", *rows])
    parts = import_file(path, WISH)
    assert [part.label for part in parts] == [name.replace(" ", "-").replace("/", "-") for name in names]
    for part in parts:
        _check(part.recording)
    argv = ["import", str(path), "--gauge-length-mm", "40", "--repeat", parts[1].label, "-o", str(tmp_path / "two")]
    assert main(argv) == 0


def test_a_number_of_each_sample_parts_nothing(tmp_path):
    rows = [f"{n},{t % 2:.1f},{x},{f}" for n, (t, x, f) in enumerate(zip(T, X, F, strict=True))]
    path = _written(tmp_path / "all.csv", ["Sample,Time (s),Extension (mm),Load (N)", *rows])
    with pytest.raises(UserError, match="row 22: time must increase"):
        import_csv(path, WISH)


@pytest.mark.parametrize("separator", [",", "\t", " "])
def test_stamps_in_brackets_are_a_column_of_their_own(tmp_path, separator):
    lines = ["t_ms,x_mm,F_N", *_rows("{:.0f},{},{}", T * 1e3, X, F)]
    lines = [f"[2024-03-12 10:12:{n:02d}.123] {line.replace(',', separator)}" for n, line in enumerate(lines)]
    _check(import_csv(_written(tmp_path / "teraterm.log", lines), WISH).recording)


def test_noise_that_looks_like_the_mark_of_utf_16_is_noise(tmp_path):
    lines = ["\xff\xfe\x80rr\x00\x1b", "t_s,x_mm,F_N", *_rows("{},{},{}", T, X, F)]
    path = _written(tmp_path / "esp.log", lines, "latin-1")
    _check(import_csv(path, WISH).recording)
    assert encoding_of("\ufefftime\n1\n".encode("utf-16-le")) == "utf-16"


@pytest.mark.parametrize(
    ("header", "encoding"),
    [
        ("Tid (s);Förlängning (mm);Kraft (N);Resistans (ohm)", "cp1252"),
        ("Tid (s);Forlængelse (mm);Kraft (N);Modstand (ohm)", "cp1252"),
        ("Čas [s];Posunutí [mm];Síla [N];Odpor [Ohm]", "cp1250"),
        ("Czas [s];Wydłużenie [mm];Siła [N];Rezystancja [Ohm]", "cp1250"),
        ("Zaman (s);Uzama (mm);Kuvvet (N);Direnç (ohm)", "cp1254"),
        ("Время, с;Перемещение, мм;Нагрузка, Н;Сопротивление, Ом", "cp1251"),
        ("Zeit [s];Längenänderung [mm];Kraft [N];Widerstand [Ohm]", "cp850"),
        ("Zeit [s];Längenänderung [mm];Kraft [N];Widerstand [Ohm]", "cp1252"),
        ("micros();x (mm);F (N);R (ohm)", "ascii"),
    ],
)
def test_names_of_other_languages_in_their_encodings(tmp_path, header, encoding):
    wish = Wish(40.0, units={"time": "s"})
    path = _written(tmp_path / "lab.csv", [header, *_rows("{};{};{};{}", T, X, F, R)], encoding)
    _check(import_csv(path, wish).recording, resistance=True)
    path = _written(tmp_path / "utf8.csv", [header, *_rows("{};{};{};{}", T, X, F, R)])
    _check(import_csv(path, wish).recording, resistance=True)


def test_a_sheet_of_settings_is_no_second_table(tmp_path):
    book = openpyxl.Workbook()
    for row in (["Specimen", "knit"], ["Gauge length (mm)", 40], ["Width (mm)", 10], ["Course", 12]):
        book.active.append(row)
    data = book.create_sheet("Data")
    for row in (["Time (s)", "Extension (mm)", "Load (N)"], *zip(T.tolist(), X.tolist(), F.tolist(), strict=True)):
        data.append(list(row))
    book.save(tmp_path / "lab.xlsx")
    _check(import_csv(tmp_path / "lab.xlsx", WISH).recording)
    book.copy_worksheet(data)
    book.save(tmp_path / "lab.xlsx")
    with pytest.raises(UserError, match="'Data', 'Data Copy' have tables"):
        import_csv(tmp_path / "lab.xlsx", WISH)
    _check(import_csv(tmp_path / "lab.xlsx", Wish(40.0, hints=Hints(sheet="Data"))).recording)


NAMED = [
    "t_ms:{:.0f},x_mm:{},F_N:{},R_ohm:{}",
    "t_ms: {:.0f}, x_mm: {}, F_N: {}, R_ohm: {}",
    "t_ms={:.0f} x_mm={} F_N={} R_ohm={}",
    "Time: {:.0f} ms | Position: {} mm | Force: {} N | Resistance: {} Ohm",
    '{{"t_ms": {:.0f}, "x_mm": {}, "F_N": {}, "R_ohm": {}}}',
    "{{'t_ms': {:.0f}, 'x_mm': {}, 'F_N': {}, 'R_ohm': {}}}",
]


@pytest.mark.parametrize("form", NAMED)
def test_names_in_the_cells_are_those_of_the_columns(tmp_path, form):
    boot = ["rst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)", "load:0x3fff0018,len:4", "entry 0x400806b4"]
    path = _written(tmp_path / "serial.log", [*boot, *_rows(form, T * 1e3, X, F, R)])
    _check(import_csv(path, WISH).recording, resistance=True)
    name = "Position" if "Position" in form else "x_mm"
    _check(import_csv(path, Wish(40.0, {"displacement": name})).recording, resistance=True)


@pytest.mark.parametrize("line", ["t_s:0.5,F_N:2.5,x_mm:1.25", "t_s:0.5,x_mm:1.25"])
def test_a_row_of_other_names_than_most_is_refused(tmp_path, line):
    rows = _rows("t_s:{},x_mm:{},F_N:{}", T, X, F)
    path = _written(tmp_path / "serial.log", [*rows[:5], line, *rows[6:]])
    with pytest.raises(UserError, match="row 6"):
        import_csv(path, WISH)
