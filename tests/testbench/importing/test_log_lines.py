"""Logs of serial ports and boards, and what loggers leave in them: read row by row as a person would."""

from __future__ import annotations

import numpy as np
import pytest

from gcode.support.errors import UserError
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv

COUNT = 40
T, X, F, R = (np.round(np.arange(COUNT) * step, 3) for step in (0.1, 0.25, 0.5, 40.0))
R = R + 4700
MS = [str(1200 + 100 * n) for n in range(COUNT)]
BOOT = [
    "ets Jul 29 2019 12:21:46",
    "rst:0x1 (POWERON_RESET),boot:0x13 (SPI_FAST_FLASH_BOOT)",
    "I (27) boot: ESP-IDF v5.1 2nd stage bootloader",
    "I (325) cpu_start: Starting scheduler.",
]


WISH = Wish(40.0)


def _check(path, lines, wish=WISH):
    path.write_bytes("\n".join([*lines, ""]).encode())
    found = import_csv(path, wish).recording
    assert found.time_s == pytest.approx(T)
    assert found["displacement_mm"] == pytest.approx(X)
    assert found["force_N"] == pytest.approx(F)


def _rows(form, *columns):
    return [form.format(*cells) for cells in zip(*columns, strict=True)]


@pytest.mark.parametrize(
    "form",
    [
        "I ({}) knit: t_s={} x_mm={} F_N={}",
        "\x1b[0;32mI ({}) knit: t_s={}, x_mm={}, F_N={}\x1b[0m",
        "I ({}) knit.rig: t_s:{};x_mm:{};F_N:{};",
        '[10:00:00.{:.3}] {{"t_s": {}, "x_mm": {}, "F_N": {}}},',
        "10:00:00.{:.3} -> t_s:{},x_mm:{},F_N:{}",
        "2026-03-01 10:00:00.{:.3} t_s:{},x_mm:{},F_N:{}",
        "[00:00:00.{:.3},091] <inf> main: t_s: {}, x_mm: {}, F_N: {}",
    ],
)
def test_named_cells_behind_what_a_board_or_a_monitor_writes_before_each_line(tmp_path, form):
    _check(tmp_path / "esp.log", [*BOOT, *_rows(form, MS, T, X, F)])


def test_the_names_may_stand_in_a_line_of_a_board_above_the_others(tmp_path):
    rows = _rows("I ({}) knit: {},{},{}", MS, T, X, F)
    _check(tmp_path / "esp.log", [*BOOT, "I (1100) knit: t_s,x_mm,F_N", *rows])


@pytest.mark.parametrize("form", ["I ({}) knit: {},{}", "I ({}) knit: x_mm={}, F_N={}"])
def test_the_ms_of_a_board_are_a_column_that_may_be_said_to_be_the_time(tmp_path, form):
    rows = ["I (1100) knit: x_mm,F_N"] * (form[-3] != "=") + _rows(form, MS, X, F)
    with pytest.raises(UserError, match="no time found: say --time COL"):
        _check(tmp_path / "esp.log", rows)
    _check(tmp_path / "esp.log", rows, Wish(40.0, {"time": "1"}, {"time": "ms"}))


@pytest.mark.parametrize("form", ["10:00:0{}.{}00 {},{}", "2026-03-01 10:00:0{},{}00  {}, {}"])
def test_a_clock_alone_before_a_blank_is_a_stamp(tmp_path, form):
    rows = _rows(form, *np.divmod(np.arange(COUNT), 10), X, F)
    _check(tmp_path / "coolterm.txt", [form.format(0, 0, "x_mm", "F_N"), *rows])


def test_the_time_of_the_log_of_zephyr(tmp_path):
    rows = _rows("[00:00:0{}.{}00,091] <inf> rig: {},{}", *np.divmod(np.arange(COUNT), 10), X, F)
    _check(tmp_path / "zephyr.txt", ["*** Booting Zephyr OS ***", "[00:00:00.000,000] <inf> rig: x_mm,F_N", *rows])


@pytest.mark.parametrize("clock", ["10:00:0{}.{}00", "10:00:0{}.{}00 AM", "2026-03-01 10:00:0{}.{}00 +01:00"])
@pytest.mark.parametrize("separator", [",", ";", " ; ", "\t"])
def test_a_clock_that_is_a_cell_is_no_stamp(tmp_path, clock, separator):
    rows = _rows(f"{clock}{separator}{{}}{separator}{{}}", *np.divmod(np.arange(COUNT), 10), X, F)
    _check(tmp_path / "lab.txt", [separator.join(["Clock", "x_mm", "F_N"]), *rows])


def test_blanks_may_part_clocks_and_decimal_commas(tmp_path):
    cells = [[str(cell).replace(".", ",") for cell in cells] for cells in (X, F)]
    for point in ".,":
        rows = _rows(f"10:00:0{{}}{point}{{}}00 {{}} {{}}", *np.divmod(np.arange(COUNT), 10), *cells)
        _check(tmp_path / "lab.txt", ["Time x_mm F_N", *rows])


def test_words_may_stand_between_clocks_and_numbers_that_blanks_part(tmp_path):
    """Of a program's log, the comma of the clock was taken for what parts the cells."""
    rows = _rows("2026-03-01 10:00:0{},{}00 INFO {} {}", *np.divmod(np.arange(COUNT), 10), X, F)
    columns, units = {"displacement": "4", "force": "5"}, {"displacement": "mm", "force": "N"}
    _check(tmp_path / "lab.txt", rows, Wish(40.0, columns, units))


@pytest.mark.parametrize("remark", ["knit 1", "2026-03-01 10:00:00", "1 2 3 4 5 6"])
def test_blanks_within_cells_part_none_where_commas_do(tmp_path, remark):
    rows = _rows(f"{{}}, {remark}, {{}}, {{}}", range(COUNT), X, F)
    _check(tmp_path / "lab.txt", ["t [ds], Remark, x_mm, F_N", *rows], Wish(40.0, {"time": "none"}, rate_hz=10.0))


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_the_names_of_rows_have_none_in_a_table_of_r(tmp_path, separator):
    names = [f'"{name}"' for name in ("t_s", "x_mm", "F_N")]
    rows = [separator.join([f'"{at}"', *map(str, row)]) for at, row in enumerate(zip(T, X, F, strict=True), 1)]
    _check(tmp_path / "lab.txt", [separator.join(names), *rows])
    with pytest.raises(UserError, match="row 1 has 3 names, the rows of numbers below it 4 columns"):
        _check(tmp_path / "lab.txt", [separator.join(names), *(row.replace('"', "") for row in rows)])


def test_stamps_are_the_time_where_nothing_else_is(tmp_path):
    rows = _rows("10:00:0{}.{}00 -> x_mm:{},F_N:{}", *np.divmod(np.arange(COUNT), 10), X, F)
    _check(tmp_path / "serial.log", rows)


@pytest.mark.parametrize("header", ["Logged at", "", "Heure", "Uhr"])
@pytest.mark.parametrize("constant", [[], ["2026-03-01"], ["2026-03-01", "2026-03-01 08:00:00"]])
def test_dates_and_clocks_are_the_time_by_any_name_unless_two_go_on(tmp_path, header, constant):
    clock = _rows("10:00:0{}.{}", *np.divmod(np.arange(COUNT), 10))
    rows = [",".join([*constant, *cells]) for cells in zip(clock, map(str, X), map(str, F), strict=True)]
    names = ",".join([*("Day", "Made")[: len(constant)], header, "x_mm,F_N"])
    _check(tmp_path / "lab.csv", [names, *rows])
    with pytest.raises(UserError, match="no time found"):
        _check(tmp_path / "lab.csv", [f"Read at,{names}", *_rows("{},{}", clock, rows)])


@pytest.mark.parametrize("end", ["\0" * 512, "\0" * 512 + "\n", "\x1a\n", "\n\0\0\n\0\0\n"])
def test_what_fills_up_the_end_of_a_file_is_no_row(tmp_path, end):
    _check(tmp_path / "card.csv", ["t_s,x_mm,F_N", *_rows("{},{},{}", T, X, F), end.removesuffix("\n")])


def test_bytes_that_a_power_cut_left_between_the_rows_are_refused(tmp_path):
    rows = _rows("{},{},{}", T, X, F)
    rows[9] = "\0" * 20
    with pytest.raises(UserError, match="row 11: "):
        _check(tmp_path / "card.csv", ["t_s,x_mm,F_N", *rows])


@pytest.mark.parametrize("unit", ["", "min"])
def test_one_day_beside_times_of_two_numbers_does_not_make_them_hours(tmp_path, unit):
    """A minute of seconds was read as an hour of minutes."""
    rows = _rows("2026-03-01,{:02d}:{:02d},{}", *np.divmod(np.arange(COUNT) + 700, 60), X)
    (tmp_path / "lab.csv").write_text("\n".join(["Date,Time,x_mm", *rows]))
    if unit:
        recording = import_csv(tmp_path / "lab.csv", Wish(40.0, units={"time": unit})).recording
        assert recording.time_s == pytest.approx(np.arange(COUNT))
        return
    with pytest.raises(UserError, match="its unit 'h:min or min:s' cannot be read as one; say --time-unit"):
        import_csv(tmp_path / "lab.csv", Wish(40.0))


def _resistance(path, header, cells, decimal=".", **said):
    rows = [row.replace(".", decimal) for row in _rows("{};{};{}", T, X, cells)]
    path.write_text("\n".join([f"t_s;x_mm;{header}", *rows]))
    return import_csv(path, Wish(40.0, **said)).recording["resistance_ohm"]


@pytest.mark.parametrize("form", ["{:g}k", "{:g} k", "{:g}K"])
@pytest.mark.parametrize("decimal", [".", ","])
def test_a_prefix_behind_a_number_is_that_of_its_unit(tmp_path, form, decimal):
    cells = [form.format(ohm / 1e3) if n % 3 else f"{ohm:g}" for n, ohm in enumerate(R)]
    path, said = tmp_path / "lab.csv", {"units": {"resistance": "ohm"}}
    assert _resistance(path, "R [Ohm]", cells, decimal) == pytest.approx(R)
    assert _resistance(path, "R", cells, decimal, **said) == pytest.approx(R)
    for header, wrong in (("R [kOhm]", {}), ("R", {"units": {"resistance": "kohm"}})):
        with pytest.raises(UserError, match=r"must be a number, got '4[.,]74"):
            _resistance(path, header, cells, decimal, **wrong)
    with pytest.raises(UserError, match=r"its unit .K. cannot be read|does not say its unit"):
        _resistance(path, "R", cells, decimal)


def test_other_prefixes_and_what_is_none(tmp_path):
    assert _resistance(tmp_path / "lab.csv", "R [Ohm]", [f"{ohm / 1e6:.9f}M" for ohm in R]) == pytest.approx(R)
    assert _resistance(tmp_path / "lab.csv", "G [S]", [f"{1e6 / ohm:.12g}u" for ohm in R]) == pytest.approx(R)
    (tmp_path / "lab.csv").write_text("\n".join(["t_s,x_mm,T [°C]", *_rows("{},{},{}k", T, X, T)]))
    with pytest.raises(UserError, match=r"T .°C. must be a number, got '0.0k'"):
        import_csv(tmp_path / "lab.csv", Wish(40.0))


def test_an_empty_column_is_said_to_be_one(tmp_path):
    with pytest.raises(UserError, match=r"its column is empty .*--conductance none leaves it out"):
        _resistance(tmp_path / "lab.csv", "G [S]", [""] * COUNT)
