"""Units and header cells: known answers."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from gcode.support.errors import UserError
from testbench.importing.vocabulary.headings import read_heading
from testbench.importing.vocabulary.laboratory_units import (
    conversion,
    given_unit,
    number_in_words,
    unit_of,
    units_spelt,
)
from testbench.importing.vocabulary.notation import decimal_sign, seconds
from testbench.importing.vocabulary.roles import ROLES

EVERY = tuple(dict.fromkeys(quantity for quantities in ROLES.values() for quantity in quantities))
ONES = [
    ("ms", "time", 1e-3), ("ns", "time", 1e-9), ("min", "time", 60), ("Sek", "time", 1), ("µm", "length", 1e-3),
    ("μm", "length", 1e-3), ("m", "length", 1e3),
    ("mN", "force", 1e-3), ("kN", "force", 1e3), ("g", "force", 9.80665e-3),
    ("kgf", "force", 9.80665), ("kΩ", "resistance", 1e3), ("kΩ", "resistance", 1e3), ("KOHM", "resistance", 1e3),
    ("MΩ", "resistance", 1e6), ("mOhm", "resistance", 1e-3), ("MOhm", "resistance", 1e6), ("mS", "conductance", 1e-3),
    ("uS", "conductance", 1e-6), ("%", "ratio", 0.01), ("mm/mm", "ratio", 1), ("[N]", "force", 1),
]  # fmt: skip


@pytest.mark.parametrize(("text", "quantity", "factor"), ONES)
def test_units_are_read(text, quantity, factor):
    (unit,) = units_spelt(text)
    assert (unit.quantity, unit.factor) == (quantity, pytest.approx(factor, rel=1e-12))


@pytest.mark.parametrize("text", ["MN", "MOHM", "Ms2", "mm²", "N/mm", "N/s", "MPa", "V", "M", "k", "°", "", "foo"])
def test_what_is_no_unit_or_may_be_two_is_not_read(text):
    assert units_spelt(text) == []


def test_a_capital_s_is_seconds_only_for_a_time():
    assert unit_of("S", ("time",)).symbol == "s"
    assert unit_of("S", ("conductance",)).symbol == "S"
    assert unit_of("S", EVERY) is None
    assert unit_of("mS", ("time",)) is None


def test_temperatures_have_an_offset():
    found = [unit_of(text, ("temperature",)).converted(np.array([1.0]))[0] for text in ("°C", "K", "°F")]
    assert found == pytest.approx([1.0, -272.15, -31 / 1.8])


def test_conversions_in_words():
    assert conversion(439.377, unit_of("kOhm", EVERY)) == "439.377 kΩ read as 439 377 Ω"
    assert conversion(-0.25, unit_of("N", EVERY)) == "-0.25 N"
    assert conversion(2.5, unit_of("%", EVERY)) == "2.5 % read as 0.025"
    assert [number_in_words(value) for value in (0.0, -1234567.5, 1e-7)] == ["0", "-1 234 567.5", "1e-07"]


def test_a_unit_that_a_person_names_is_held_to_the_quantity():
    with pytest.raises(UserError, match=r"--force-unit must be one of N, mN, .*, got 'mm'"):
        given_unit("--force-unit", "mm", ("force",))


HEADINGS = [
    ("Kraft [N]", {"force"}, "N"),
    ("Weg / mm", {"displacement"}, "mm"),
    ("Kraft / [N]", {"force"}, "N"),
    ("R/(kOhm)", {"resistance"}, "kOhm"),
    ("\u200edL/µm\ufeff", {"displacement"}, "µm"),
    ("force.N", {"force"}, "N"),
    ("R.kOhm", {"resistance"}, "kOhm"),
    ("Strain.1", {"strain"}, ""),
    ("time_ms", {"time"}, "ms"),
    ("Load(ElectroPuls (0,1):Load) (N)", {"force"}, "N"),
    ("Zeit in s", {"time"}, "s"),
    ("位移（mm）", {"displacement"}, "mm"),
    ("Dehnung%", {"strain"}, "%"),
    ("Dehnung in %", {"strain"}, "%"),
    ("Strain 1", {"strain"}, ""),
    ("Strain_1", {"strain"}, ""),
    ("Strain / 1", {"strain"}, "1"),
    ("ΔR/R0 (%)", {"relative_change"}, "%"),
    ("R/R0", {"relative"}, ""),
    ("Force rate (N/s)", set(), "N/s"),
    ("应力(MPa)", set(), "MPa"),
    ("Load (1)", {"force"}, ""),
    ("F / foo", {"force"}, "foo"),
    ("F / mV/V", {"force"}, "mV/V"),
    ("Last", set(), ""),
    ("Sollweg [mm]", set(), "mm"),
    ("kOhm", set(), "kOhm"),
    ("# Zeit in s", {"time"}, "s"),
    ("R k Ohm", {"resistance"}, "k Ohm"),
    ("R (k Ohm)", {"resistance"}, "k Ohm"),
    ("R in kilo ohms", {"resistance"}, "kilo ohms"),
    ("Displacement u (mm)", {"displacement"}, "mm"),
    ("R_k_Ohm", {"resistance"}, ""),
    ("Kraft (in kN)", {"force"}, "in kN"),
    ("Load cell 100N [N]", {"force"}, "N"),
    ("max10 [mm]", set(), "mm"),
    ("forceN", {"force"}, "N"),
    ("timeMs", {"time"}, "ms"),
    ("xMm", {"displacement"}, "mm"),
    ("resKOhm", {"resistance"}, "kOhm"),
    ("resMohm", {"resistance"}, ""),  # a capital may be there but to part it
    ("posM", {"displacement"}, ""),
    ("posIn", {"displacement"}, ""),
    ("forceMax", set(), ""),
    ("X_MM", set(), "MM"),
    ("Last_kN", set(), "kN"),
    ("Time (s) Run #1", {"time"}, "s"),
    ("Load (N) Cell 2", {"force"}, "N"),
    ("Force (N) in kN", {"force"}, "N kN"),
    ("R_temp_comp [Ohm]", {"temperature", "resistance"}, "Ohm"),
    ("Time difference (s)", set(), "s"),
    ("Δ Force (N)", set(), "N"),
    ("Längenänderung [mm]", {"displacement"}, "mm"),
    ("dR/dt [Ohm/s]", set(), "Ohm/s"),
]
POWERS = [
    "R Ohm (x1000)",
    "R [10^3 Ohm]",
    "R [Ohm] x1000",
    "R [Ohm] (10³)",
    "R / 1000 Ohm",
    "R Ohm (*0,001)",
    "R*1e3 [Ohm]",
    "R (E+3 Ohm)",
    "R x1k (Ohm)",
    "R kilo (Ohm)",
    "R k (Ohm)",
    "R (k) Ohm",
    "R (k) [Ohm]",
    "Load in tenths (N)",
]


@pytest.mark.parametrize(("text", "roles", "unit_text"), HEADINGS)
def test_header_cells_are_parted(text, roles, unit_text):
    heading = read_heading(text)
    assert set(heading.roles) == roles
    assert heading.unit_text == unit_text


@pytest.mark.parametrize("text", POWERS)
def test_beside_a_power_of_ten_no_unit_can_be_told(text):
    """It may say what the numbers are to be multiplied by, or what they were."""
    heading = read_heading(text)
    assert heading.power in heading.unit_text
    assert heading.power
    assert heading.unit(heading.unit_text) is None


@pytest.mark.parametrize(
    ("cells", "sign"),
    [
        (["0,5", "1"], ","), (["0.5"], "."), (["12"], "."), (["1,234"], None), (["1,234", "0,5"], ","),
        (["1.234,5"], ","), (["1,234.5"], "."), (["0,5", "0.5"], None), (["1.234", "0.5"], "."),
        (["1.234"], None), (["−0,5"], ","),
    ],
)  # fmt: skip
def test_a_decimal_sign_must_be_proven(cells, sign):
    assert decimal_sign(cells) == sign


def test_noon_and_midnight_of_a_clock_of_twelve_hours():
    times = pd.Series(["11:59:59.5 AM", "12:00:00.5 PM", "11:59:59.5 PM", "12:00:00.5 AM"])
    assert seconds(times)[0] - 43_199.5 == pytest.approx([0, 1, 43_200, 43_201])
