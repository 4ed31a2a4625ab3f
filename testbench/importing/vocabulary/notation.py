"""Numbers as laboratories write them: decimal comma, thousands apart, dates and times of day."""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from gcode.support import kinds
from testbench.importing.vocabulary.laboratory_units import units_spelt
from testbench.recordings.csv_columns import as_numbers

if TYPE_CHECKING:
    import pandas as pd

_EXPONENT = r"([eEdD][+-]?\d+)?"  # D of Fortran
_PREFIXES = {"k": "e3", "K": "e3", "M": "e6", "G": "e9", "m": "e-3", "u": "e-6", "µ": "e-6", "n": "e-9"}  # 4.7k
_PREFIX = re.compile(rf"(?<=[\d.,])\s?([{''.join(_PREFIXES)}])$")
_POINT = re.compile(rf"^[+-]?(\d+\.?\d*|\.\d+)({_EXPONENT}|{_PREFIX.pattern})$")
_COMMA = re.compile(rf"^[+-]?(\d+,?\d*|,\d+)({_EXPONENT}|{_PREFIX.pattern})$")
# 1,234 may be a bit more than one, or a thousand and more.
_EITHER = re.compile(r"^[+-]?[1-9]\d{0,2}[.,]\d{3}$")
_APART = r"'’ \u00a0\u2007\u2009\u202f"  # apostrophes and blanks: no-break, of a digit's width, thin, narrow
_THOUSANDS = {
    ".": re.compile(rf"^[+-]?\d{{1,3}}((,\d{{3}})+|([{_APART}]\d{{3}})+)(\.\d*)?{_EXPONENT}$"),
    ",": re.compile(rf"^[+-]?\d{{1,3}}((\.\d{{3}})+|([{_APART}]\d{{3}})+)(,\d*)?{_EXPONENT}$"),
}
_BEHIND_SIGN = re.compile(r"(?<=^[+-])\s+(?=[\d.,])")  # +   0.5, as Graphtec aligns numbers
_UNIT = re.compile(r"(?<=[\d.,])\s*([^\d\s.,:;+-][^\d:]*)$")  # behind a number: 7.8 %, 4.7kOhm
_SEPARATORS = {".": rf"[,{_APART}]", ",": rf"[.{_APART}]"}
# Dates and times in their plain form, see `_plain_when`.
_MONTHS = "Jan|Feb|Mar|Apr|May|Jun|Jul|Aug|Sep|Oct|Nov|Dec"
_DATE = re.compile(
    rf"^(?:\d{{1,4}}[-./年]\d{{1,2}}[-./月]\d{{1,4}}日?|\d{{1,2}}[- ](?:{_MONTHS})[- ]\d{{2,4}})"
    r"([T ,]+\d{1,2}:\d{2}(:\d{2}(\.\d+)?)?)?"
    r"( ?[AP]M| ?Z| ?[+-]\d{2}:?\d{2})?$"
)
# 10:15:30.5, with AM or PM behind it, or days before it as pandas and .NET write them; or minutes and
# seconds, 15:30.5
_CLOCK = re.compile(
    r"^(?:(?:(\d+)(?: days? |\.))?(\d{1,3}):([0-5]\d):([0-5]\d(?:\.\d+)?)(?: ?([AaPp])\.?[Mm]\.?)?"
    r"|(\d{1,3}):(\d{2}\.\d+))$"
)
# 12:01: hours and minutes, or minutes and seconds; before AM or PM, it can be but the former.
_SHORT_CLOCK = re.compile(r"^(\d{1,3}:\d{2})$")
_BEFORE_HALF = re.compile(r"(?i)^(\d{1,2}:\d{2})(?= ?[ap]\.?m)")
WHOLE_CLOCKS = {"h": r"\1:00", "min": r"0:\1"}  # of the unit before the colon
# 01/03/2026, 01-03-26: the day or the month may come first, and of 26-03-01 even the year.
_UNCLEAR_DAY = re.compile(r"^((\d{1,2})([/-])(\d{1,2})\3(\d{2}(?:\d{2})?))(?!\d)")
# A day, and behind it a time of day in no named zone.
_DAY_AND_CLOCK = re.compile(r"^(.{1,30}?\d日?)[T ,]+((?:[01]?\d|2[0-3]):[0-5]\d(?::[0-5]\d(?:\.\d+)?)?(?: ?[AP]M)?)$")
_MIDNIGHT = re.compile(r"[T ]+0{1,2}:00(:00(\.0+)?)?$")
_BEFORE_PARTS = re.compile(r"(:\d{2})(?:,(?=\d)|:(?=\d{3}(?!\d)))")  # 30,5 s; a third colon has ms behind it
_ZONE = re.compile(r"(?<=[\dM.]) ([A-Z]{3,5})$")  # CET, behind digits or AM
_WEEKDAY = re.compile(r"^(?:Mon|Tue|Wed|Thu|Fri|Sat|Sun),? +(?=\w)")
_MONTH_FIRST = re.compile(rf"^({_MONTHS})[a-z]{{0,6}}\.? +(\d{{1,2}})(?:, ?| )(?:([\d:.]{{5,15}}) )?(\d{{4}})(?= |$)")
_COMPACT = re.compile(r"^((?:19|20)\d\d)(\d\d)(\d\d)[T_ -](\d\d)(\d\d)(\d\d)(?:[._](\d{1,9}))?(?=Z?$)")
HALF_DAY_S = 43_200.0
MISSING = {"", "nan", "na", "n/a", "-", "--", "---", "null", "none", "inf", "-inf", "#n/a"}
MISSING |= {
    f"{sign}{start}#{what}"
    for sign in ("", "-")
    for start in ("", "1.", "1,")
    for what in ("inf", "ind", "qnan", "snan")
}


def _plain_sign(cell: str) -> str:
    """A cell without blanks around it and behind its sign, and with the hyphen of programs for a printed minus."""
    return _BEHIND_SIGN.sub("", cell.strip().replace("−", "-"))


def is_number(text: str) -> bool:
    """Whether a cell may be a number, in any of the notations."""
    text = _plain_sign(text)
    return bool(_POINT.match(text) or _COMMA.match(text)) or any(form.match(text) for form in _THOUSANDS.values())


def unit_in(cell: str) -> str:
    """The unit behind a number in its cell (``7.8 %``); empty where there is none."""
    cell = cell.strip()
    found = None if cell[-1:].isdigit() else _UNIT.search(cell)
    return found[1] if found and units_spelt(found[1]) and is_number(cell[: found.start()]) else ""


def is_value(text: str) -> bool:
    """Whether a cell may be a number, alone or with its unit, or is a date or time."""
    return is_number(text) or is_when(text) or is_short_clock(text) or bool(unit_in(text))


def units_apart(cells: pd.Series) -> tuple[pd.Series, pd.Series]:
    """Numbers and the units behind them; nothing where a cell has none."""
    text = _texts(cells)
    return text.str.replace(_UNIT, "", regex=True), text.str.extract(_UNIT)[0]


def _plain_when(cell: str) -> str:
    """A date or time with seconds and a point before parts of them, without the names of its zone and its weekday."""
    cell = cell.strip()
    if cell[:1].isalpha():  # Sat Mar 14 09:58:57 2026; Mar 14, 2026 09:58:57
        cell = _MONTH_FIRST.sub(lambda found: " ".join(filter(None, found.group(2, 1, 4, 3))), _WEEKDAY.sub("", cell))
    elif found := _COMPACT.match(cell):
        cell = "{}-{}-{} {}:{}:{}.{}".format(*found.groups("0")) + cell[found.end() :]
    return _ZONE.sub("", _BEFORE_PARTS.sub(r"\1.", _BEFORE_HALF.sub(WHOLE_CLOCKS["h"], cell)))


def is_when(text: str) -> bool:
    """Whether a cell is a date, a date and time, or a time of day with seconds."""
    text = _plain_when(text)
    return bool(_DATE.match(text) or _CLOCK.match(text))


def is_short_clock(text: str) -> bool:
    """Whether a cell is a time of two numbers (``12:01``), of which it does not say what they count."""
    return bool(_SHORT_CLOCK.match(text.strip()))


def is_time_of_day(text: str) -> bool:
    """Whether a cell is a time of day, with seconds, that does not say of which day."""
    return bool(_CLOCK.match(_plain_when(text)))


def is_day(text: str) -> bool:
    """Whether a cell is a date without a time of day (or at midnight, as spreadsheets write it)."""
    text = _plain_when(text)
    return bool(_DATE.match(text)) and ":" not in _MIDNIGHT.sub("", text)


def why_unclear(cell: str) -> str:
    """What cannot be told of a date or time where others in its column differ, and what to write; or nothing."""
    if _UNCLEAR_DAY.match(cell.strip()):
        return "which of its numbers is the day and which the month cannot be told; write dates as 2026-03-01"
    if _ZONE.search(cell.strip()):
        return "how far zones that have but a name lie apart cannot be told; write them as 10:00:00+01:00"
    return ""


def decimal_sign(cells: Iterable[str]) -> str | None:
    """The decimal sign that the cells prove: ``,`` or ``.``; None where some say neither or both.

    ``0,5`` and ``1.234,5`` prove the comma; ``1,234`` and ``1.234`` prove nothing: they may be a thousand and more.
    """
    proofs, open_to_doubt = set(), False
    for cell in map(_plain_sign, cells):
        cell = cell.removesuffix(unit_in(cell)).rstrip()
        if "," not in cell and "." not in cell:
            continue
        if _EITHER.match(cell):
            open_to_doubt = True
        elif _COMMA.match(cell) or (_THOUSANDS[","].match(cell) and cell.rfind(",") > cell.rfind(".")):
            proofs.add(",")
        elif _POINT.match(cell) or (_THOUSANDS["."].match(cell) and cell.rfind(".") > cell.rfind(",")):
            proofs.add(".")
    if len(proofs) == 1:
        return proofs.pop()
    return None if proofs or open_to_doubt else "."


def may_be_thousands(cell: str, decimal: str) -> bool:
    """Whether a cell is a number if the sign in it that is not the decimal one parts thousands."""
    return bool(_THOUSANDS[decimal].match(cell.strip()))


def numbers(
    cells: pd.Series, decimal: str, thousands: str | None = None, prefixes: bool = False
) -> tuple[np.ndarray, int | None]:
    """Cells as numbers, and the place of the first that is none.

    A thousands separator is taken away only where a number of the column proves it (``1.234,5``), or where it was
    named; otherwise ``1.234`` beside a decimal comma is no number: it may be a thousand and more, or a bit over one.

    Parameters
    ----------
    cells : Series
    decimal : {".", ","}
    thousands : str, optional
    prefixes : bool
        Whether a prefix of the unit may stand behind a number (``4.7k``).

    Returns
    -------
    values : ndarray, shape (n,)
        NaN where a cell is empty or no number.
    wrong : int or None
    """
    import pandas as pd

    if cells.dtype.kind in "fiu":
        return cells.to_numpy(dtype=np.float64), None
    text = _texts(cells).str.replace("−", "-", regex=False).str.replace(_BEHIND_SIGN, "", regex=True)
    grouped = text.str.match(_THOUSANDS[decimal].pattern, na=False)
    sign = re.escape(thousands) if thousands else _SEPARATORS[decimal]
    proven = thousands or (grouped & text.str.contains(re.escape(decimal), na=False)).any()
    apart = grouped & text.str.contains(f"[{_APART}]", na=False)  # 12 345 can be nothing else
    plain = text.mask(grouped, text.str.replace(sign, "", regex=True)) if proven else text
    plain = plain.mask(apart, text.str.replace(_SEPARATORS[decimal], "", regex=True))
    if decimal == ",":
        pointed = plain.str.contains(".", regex=False, na=False)
        plain = plain.mask(pointed, "?").str.replace(",", ".", regex=False)
    if prefixes:
        plain = plain.str.replace(_PREFIX, lambda found: _PREFIXES[found[1]], regex=True)
    values = pd.to_numeric(plain.str.replace(r"(?<=[\d.])[dD](?=[+-]?\d)", "e", regex=True), errors="coerce")
    if cells.dtype == object:  # beside texts, what is a number already has no decimal sign
        stored = cells.map(kinds.is_number)
        values = values.mask(stored, as_numbers(cells))
    wrong = np.flatnonzero((values.isna() & text.notna()).to_numpy())
    return values.to_numpy(dtype=np.float64, na_value=np.nan), int(wrong[0]) if wrong.size else None


def _texts(cells: pd.Series) -> pd.Series:
    """Cells without blanks around them; nothing where one is empty."""
    text = cells.astype("string").str.strip()
    return text.mask(text == "")


def _plain_whens(cells: pd.Series) -> pd.Series:
    """Cells as `_plain_when`; where their zones are not all of one name, those that have one are no times.

    Of one zone for all, nothing need be known: only the time between the cells counts.
    """
    text = _texts(cells)
    zones = text.str.extract(_ZONE.pattern)[0]
    if zones[text.notna()].nunique(dropna=False) > 1:
        text = text.mask(zones.notna(), "?")
    return text.map(_plain_when, na_action="ignore").astype("string")


def whole_clocks(cells: pd.Series, first: str) -> pd.Series:
    """Times such as ``12:01`` with hours, minutes and seconds; the first of their numbers counts `first`."""
    return _texts(cells).str.replace(_SHORT_CLOCK, WHOLE_CLOCKS[first], regex=True)


def seconds(cells: pd.Series) -> tuple[np.ndarray, int | None]:
    """Dates and times in seconds, and the place of the first cell that is none.

    Dates count from the earliest one, times of day from midnight, and durations from zero.

    ``01.03.2026`` is the first of March (points part day, month and year); of ``01/03/2026`` and ``01-03-2026``
    nobody can tell, but where another has a number above 12: where such dates differ within a file they are refused,
    as if they were no dates.
    """
    import pandas as pd

    if cells.dtype.kind == "M":
        when = pd.to_datetime(cells, utc=True)
    elif cells.dtype.kind == "m":
        return cells.dt.total_seconds().to_numpy(dtype=np.float64), None
    else:
        text = _plain_whens(cells)
        clock = text.str.extract(_CLOCK.pattern)
        if 2 * clock.notna().any(axis=1).sum() >= text.notna().sum() > 0:
            of_day, first_wrong = _times_of_day(text, clock)
            return _past_midnight(of_day), first_wrong
        when = _dates(text)
    wrong = np.flatnonzero((when.isna() & cells.notna()).to_numpy())
    since = (when - when.min()).dt.total_seconds()
    return since.to_numpy(dtype=np.float64, na_value=np.nan), int(wrong[0]) if wrong.size else None


def _times_of_day(text: pd.Series, clock: pd.DataFrame) -> tuple[np.ndarray, int | None]:
    days, hours, minutes, rest, few, short = (
        clock[part].astype("Float64").to_numpy(dtype=np.float64, na_value=np.nan) for part in (0, 1, 2, 3, 5, 6)
    )
    half = clock[4].str.casefold()
    afternoon = (half == "p").fillna(False).to_numpy(dtype=bool)
    hours = np.where(half.notna(), hours % 12 + 12 * afternoon, hours)
    hours += 24 * np.nan_to_num(days)
    since = np.where(np.isnan(few), 3600 * hours + 60 * minutes + rest, 60 * few + short)
    wrong = np.flatnonzero(np.isnan(since) & text.notna().to_numpy())
    return since, int(wrong[0]) if wrong.size else None


def seconds_of_days(cells: pd.Series, days: pd.Series) -> tuple[np.ndarray, int | None, int | None]:
    """Times of day in `cells` on the `days` beside them, as seconds since midnight of the first day.

    Where all days are the same one, it may be that of the beginning: then midnights are counted as without it.

    Returns
    -------
    since : ndarray, shape (n,)
    wrong, wrong_day : int or None
        Place of the first cell that is no time of day, and of the first that is no date.
    """
    if cells.dtype.kind == "m":
        since, wrong = seconds(cells)
    else:
        text = _plain_whens(cells)
        since, wrong = _times_of_day(text, text.str.extract(_CLOCK.pattern))
    day_s, wrong_day = seconds(days)
    there = np.isfinite(day_s)
    if not there.any() or np.ptp(day_s[there]) == 0:
        return _past_midnight(np.where(there, since, np.nan)), wrong, wrong_day
    return since + day_s, wrong, wrong_day


def _past_midnight(since: np.ndarray) -> np.ndarray:
    """A time of day that falls back by more than half a day has passed midnight."""
    there = np.isfinite(since)
    days = np.zeros(len(since))
    days[there] = np.cumsum(np.diff(since[there], prepend=since[there][:1]) < -HALF_DAY_S)
    return since + 2 * HALF_DAY_S * days


def _dates(text: pd.Series) -> pd.Series:
    """Dates, with or without a time of day."""
    import pandas as pd

    when = pd.to_datetime(text, errors="coerce", format="ISO8601", utc=True)
    others = when.isna() & text.notna()
    return when.where(~others, _moments_of_days(text[others])) if others.any() else when


def _moments_of_days(text: pd.Series) -> pd.Series:
    """Dates, with or without a time of day: many moments lie in few days, each of which is read once."""
    import pandas as pd

    parts = text.str.extract(_DAY_AND_CLOCK.pattern)
    clock = whole_clocks(parts[1].str.replace(_BEFORE_HALF, WHOLE_CLOCKS["h"], regex=True), "h")
    since_s, _ = _times_of_day(clock, clock.str.extract(_CLOCK.pattern))
    number, days = parts[0].fillna(text).factorize()
    when = _days(pd.Series(days)).iloc[number].set_axis(text.index)
    return when + pd.to_timedelta(np.nan_to_num(since_s), unit="s")


def _days(text: pd.Series) -> pd.Series:
    """Different dates; none where the day cannot be told from the month."""
    import pandas as pd

    unclear = text.str.extract(_UNCLEAR_DAY.pattern)
    pointed = text.str.match(r"^\d{1,2}\.\d{1,2}\.\d{2,4}", na=False)
    day_first = _day_first(unclear) if unclear[0].nunique() > 1 else bool(pointed.any())
    if day_first is None:
        text = text.mask(unclear[0].notna(), "?")
    return pd.to_datetime(text, errors="coerce", format="mixed", utc=True, dayfirst=bool(day_first))


def _day_first(unclear: pd.DataFrame) -> bool | None:
    """Whether the day stands before the month in dates, the groups of `_UNCLEAR_DAY`: a number above 12 is no month.

    None where no number tells, or numbers contradict each other.
    """
    first, second = ((unclear[place].astype("Float64") > 12).fillna(False) for place in (1, 3))
    if first.any() == second.any():
        return None
    if second.any():
        return False
    return True if (unclear[4][first].str.len() == 4).any() else None  # 26-03-01 may begin with the year
