"""Dates and times of day: which number is the day, and which day a time of day is of."""

from __future__ import annotations

import pytest

from gcode.support.errors import UserError
from testbench.importing.wish import Wish
from tests.testbench.importing.exports import import_csv


def table(folder, names, whens):
    rows = [f"{when},{0.1 * n:.1f},{0.2 * n:.1f}" for n, when in enumerate(whens)]
    path = folder / "lab.csv"
    path.write_text("\n".join([f"{names},Displacement (mm),Force (N)", *rows]) + "\n")
    return path


def time_of(path, **more):
    return import_csv(path, Wish(40.0, **more)).recording.time_s.tolist()


@pytest.mark.parametrize(
    "days",
    [("01-03-2026", "02-03-2026"), ("01-03-26", "02-03-26"), ("26-03-01", "26-03-02"), ("01/03/26", "02/03/26")],
)
def test_where_day_and_month_cannot_be_told_apart_a_change_of_them_is_refused(tmp_path, days):
    """One midnight became 30 days."""
    whens = [f"{days[0]} 23:59:59.0", f"{days[0]} 23:59:59.5", f"{days[1]} 00:00:00.0"]
    path = table(tmp_path, "Time", whens)
    with pytest.raises(UserError, match=f"row 2: Time must be a date and time.*{days[0]}.*write dates as 2026-03-01"):
        time_of(path)
    same = [f"{days[0]} 12:00:0{n}.0" for n in range(3)]
    assert time_of(table(tmp_path, "Time", same)) == [0, 1, 2]


@pytest.mark.parametrize(
    "days",
    [("12/31/2026", "1/1/2027"), ("31/12/2026", "1/1/2027"), ("31-12-2026", "01-01-2027"), ("12/31/26", "1/1/27")],
)
def test_a_number_above_12_tells_the_day_from_the_month(tmp_path, days):
    whens = [f"{days[0]} 23:59:59.0", f"{days[0]} 23:59:59.5", f"{days[1]} 00:00:00.25"]
    assert time_of(table(tmp_path, "Time", whens)) == [0, 0.5, 1.25]
    halves = [when.replace(" 23:", " 11:").replace(" 00:", " 12:") for when in whens]
    halves = [f"{when} {half}" for when, half in zip(halves, ("PM", "PM", "AM"), strict=True)]
    assert time_of(table(tmp_path, "Time", halves)) == [0, 0.5, 1.25]


@pytest.mark.parametrize("days", [("13/12/2026", "12/13/2026"), ("26-03-12", "26-03-13")])
def test_days_that_say_both_are_refused(tmp_path, days):
    with pytest.raises(UserError, match="cannot be told; write dates as 2026-03-01"):
        time_of(table(tmp_path, "Time", [f"{days[0]} 10:00:00", f"{days[0]} 10:00:01", f"{days[1]} 10:00:02"]))


@pytest.mark.parametrize(
    "form", ["2026-03-01 10:00:0{}.5 CET", "10:00:0{},5 MESZ", "10:00:0{}.5 AM EST", "2026-03-01 10:00:0{}:500"]
)
def test_one_zone_for_all_says_nothing_and_a_third_colon_has_milliseconds_behind_it(tmp_path, form):
    path = tmp_path / "lab.csv"
    rows = [f"{form.format(n)};{0.1 * n:.1f};{0.2 * n:.1f}" for n in range(4)]
    path.write_text("\n".join(["Time;Displacement (mm);Force (N)", *rows]) + "\n")
    assert time_of(path) == [0, 1, 2, 3]
    rows[2] = rows[2].replace(":02:500", ":02:750").replace(":02.5", ":02.75").replace(":02,5", ":02,75")
    path.write_text("\n".join(["Time;Displacement (mm);Force (N)", *rows]) + "\n")
    assert time_of(path) == [0, 1, 2.25, 3]


@pytest.mark.parametrize("other", ["CEST", ""])
def test_how_far_two_named_zones_lie_apart_is_not_guessed(tmp_path, other):
    path = table(tmp_path, "Time", [f"2026-10-25 02:00:0{n} {'CET' if n else other}".strip() for n in range(4)])
    with pytest.raises(UserError, match=r"got '2026-10-25 .* CE.*; how far zones .* write them as 10:00:00\+01:00"):
        time_of(path)


@pytest.mark.parametrize("cells", ["10:00:00:{}", "10:00:0{}:12"])
def test_what_a_third_colon_has_behind_it_is_not_guessed(tmp_path, cells):
    """Milliseconds without their noughts, or frames."""
    with pytest.raises(UserError, match=r"time .*: the file does not say its unit"):
        time_of(table(tmp_path, "Time", [cells.format(n) for n in range(4)]))


@pytest.mark.parametrize("days", [("2026-03-01", "2026-03-02"), ("01.03.2026", "02.03.2026"), ("1.3.26", "2.3.26")])
def test_the_days_beside_times_of_day_are_joined(tmp_path, days):
    """20 rows on one day and 20 on the next lasted an hour."""
    whens = [f"{days[0]},10:00:00.0", f"{days[0]},10:00:01.0", f"{days[1]},11:00:00.0"]
    done = import_csv(table(tmp_path, "Date,Time", whens), Wish(40.0))
    assert done.recording.time_s.tolist() == [0, 1, 90_000]
    assert "of the days in column 1 'Date'" in done.taken["time"]
    assert done.details["columns"]["time"]["days"] == "Date"


def test_a_midnight_is_counted_once_with_days_and_where_the_day_stays_that_of_the_beginning(tmp_path):
    times = ["23:59:59.0", "23:59:59.5", "00:00:00.5"]
    for days in (["2026-03-01"] * 2 + ["2026-03-02"], ["2026-03-01"] * 3, ["01/03/2026"] * 3):
        whens = [f"{day},{time}" for day, time in zip(days, times, strict=True)]
        assert time_of(table(tmp_path, "Date,Time", whens)) == [0, 0.5, 1.5]


def test_days_that_cannot_be_told_or_are_none_are_named(tmp_path):
    whens = ["01/03/2026,10:00:00", "02/03/2026,10:00:01", "02/03/2026,10:00:02"]
    with pytest.raises(
        UserError, match="row 2: Date must be a date, got '01/03/2026'; which of its numbers is the day"
    ):
        time_of(table(tmp_path, "Date,Time", whens))
    whens = ["2026-03-01,10:00:00", "yesterday,10:00:01", "2026-03-01,10:00:02", "2026-03-01,10:00:03"]
    path = table(tmp_path, "Date,Time", whens)
    with pytest.raises(UserError, match="row 3: Date must be a date, got 'yesterday'; --drop-bad"):
        time_of(path)
    assert time_of(path, drop_bad=True) == [0, 2, 3]
    whens = [f"2026-03-01,2026-01-01,10:00:0{n}" for n in range(3)]
    with pytest.raises(UserError, match="'Date' and column 2 'Calibrated' have dates: which are its days cannot be"):
        time_of(table(tmp_path, "Date,Calibrated,Time", whens))


def test_days_and_times_of_a_workbook(tmp_path):
    import datetime

    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["Date", "Time", "Displacement (mm)", "Force (N)"])
    for n, (day, hour) in enumerate([(1, 10), (1, 11), (2, 10)]):
        book.active.append([datetime.date(2026, 3, day), datetime.time(hour), 0.1 * n, 0.2 * n])
    book.save(tmp_path / "lab.xlsx")
    assert time_of(tmp_path / "lab.xlsx") == [0, 3600, 86_400]


def test_the_time_of_day_goes_on_where_it_is_set_back_in_autumn(tmp_path):
    times = [f"2026-10-25 02:{59 if n < 20 else 0:02d}:{(40 + n) % 60:02d}" for n in range(40)]
    assert time_of(table(tmp_path, "Time", times)) == list(range(40))


@pytest.mark.parametrize(
    "form", ["{:02d}-Mar-2026 {:02d}:59:{:02d}.5", "{} days {:02d}:59:{:02d}.500000", "{}.{:02d}:59:{:02d}.5"]
)
def test_dates_and_durations_as_matlab_pandas_and_net_write_them(tmp_path, form):
    times = [form.format(1, 22, 59), form.format(1, 23, 0), form.format(2, 0, 0)]
    assert time_of(table(tmp_path, "Time", times)) == [0, 3541, 7141]
