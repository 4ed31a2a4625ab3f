"""Raw files of laboratories through the import page, as a person would: each comes out right, or the page asks."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from testbench.recordings.files import read_recording
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, opened, shot
from tests.testbench.studio.served import Served

SHARED = Path(__file__).parents[4] / "../shared/data"
WRITTEN = {"rel": 1e-6, "abs": 1e-6}  # a recording has six decimals
OTHERS = "Other quantities, and several clocks"
pytestmark = [
    *IN_CHROMIUM,
    pytest.mark.real_data,
    pytest.mark.skipif(not (SHARED / "foreign").is_dir(), reason="the measured recordings are not here"),
]


@dataclass(frozen=True)
class Said:
    """What a person says about a file; columns and units in the order in which they are chosen."""

    columns: dict[str, int] = field(default_factory=dict)
    units: dict[str, str] = field(default_factory=dict)
    numbers: dict[str, str] = field(default_factory=dict)
    clocks: dict[str, int] = field(default_factory=dict)
    boxes: tuple[str, ...] = ()


def read(shared: Served, page, file: str, said: Said = Said()) -> None:
    """Open a file on the page and say what has to be said."""
    opened(shared, page, (SHARED / file).resolve())
    for label, value in said.numbers.items():
        with looked_again(page):
            page.get_by_label(label).fill(value)
            page.keyboard.press("Tab")
    for role, number in said.columns.items():
        show(page, f"Column of {role}")
        pick(page, f"Column of {role}", rf"{number}( ·.*)?")
    for role, unit in said.units.items():
        show(page, f"Unit of {role}")
        pick(page, f"Unit of {role}", re.escape(unit))
    for role, number in said.clocks.items():
        show(page, f"Own times of {role}")
        pick(page, f"Own times of {role}", rf"{number}( ·.*)?")
    for label in said.boxes:
        page.get_by_role("checkbox", name=label).click()


def show(page, label: str) -> None:
    """What is used rarely is folded in."""
    field_of = page.get_by_role("combobox", name=label, exact=True)
    page.get_by_text(OTHERS).wait_for()
    if not field_of.is_visible():
        page.get_by_text(OTHERS).click()
    field_of.wait_for()


def pick(page, label: str, option: str) -> None:
    """Take an option."""
    with looked_again(page):
        page.get_by_role("combobox", name=label, exact=True).click()
        page.get_by_role("option", name=re.compile(f"^{option}$")).click()


@contextmanager
def looked_again(page) -> Iterator[None]:
    """Say something, and wait until the page has looked at the file again: it draws its lists anew, open ones too."""
    page.evaluate("document.querySelectorAll('.role').forEach(role => role.classList.add('stale'))")
    yield
    page.wait_for_function("() => document.querySelector('.role') && !document.querySelector('.role.stale')")


def imported(shared: Served, page, name: str, gauge_mm: float | None) -> None:
    """Press the button; what comes of it is the caller's to see."""
    if gauge_mm:
        page.get_by_label("Gauge length / mm").fill(f"{gauge_mm:g}")
    page.get_by_label("Campaign name").fill(name)
    page.get_by_role("button", name="Import", exact=True).click()


def arrived(shared: Served, page, name: str):
    page.wait_for_url(f"**/recording?c={name}")
    page.wait_for_selector(".js-plotly-plot .main-svg")
    return read_recording(shared.root / name)


def raw(file: str, **options) -> np.ndarray:
    """The numbers of a file by pandas alone, shape (n, columns)."""
    return pd.read_csv(SHARED / file, **options).to_numpy(dtype=float)


PLAIN = {
    "gbk": ("foreign/gbk-units-row.csv", 30, {"encoding": "gb18030", "skiprows": [0, 2]}, (1, 2, None)),
    "elastomer": ("real/vhb4910_elastomer/relax_2d0.csv", 80, {}, (1, 2, None)),
    "rubber": ("real/extra_rubber_relax_24h/rubber_relax_24h.csv", 25, {}, (1, 2, None)),
    "strip": ("real/cb_silicone_strip/cb7.5_s2_multisine_300s_a.csv", 40, {}, (1, 2, 4)),
}


@pytest.mark.parametrize("name", PLAIN)
def test_a_file_that_names_its_columns_needs_its_gauge_length_only(shared: Served, page, name: str) -> None:
    file, gauge_mm, options, columns = PLAIN[name]
    read(shared, page, file)
    imported(shared, page, name, gauge_mm)
    recording, wanted = arrived(shared, page, name), raw(file, **options)
    assert recording.time_s == pytest.approx(wanted[:, 0] - wanted[0, 0], **WRITTEN)
    for channel, column in zip(("displacement_mm", "force_N", "resistance_ohm"), columns, strict=True):
        assert recording.has(channel) == (column is not None)
        if column is not None:
            assert recording[channel] == pytest.approx(wanted[:, column], **WRITTEN)


def test_a_wrong_gauge_length_is_doubted_where_a_strain_says_another(shared: Served, page) -> None:
    read(shared, page, "real/vhb4910_elastomer/cycle_0d03_2d5.csv")
    imported(shared, page, "wrong-gauge", 40)
    page.get_by_text(re.compile("is that of a gauge length of 80 mm.*“Gauge length / mm” says 40")).wait_for()
    shot(page, "import-wrong-gauge")


def test_two_positions_and_doubled_times_are_asked_about(shared: Served, page) -> None:
    file = "foreign/electropuls-quoted-header.csv"
    read(shared, page, file)
    page.get_by_text("both fit: choose one").wait_for()
    pick(page, "Column of displacement", r"9 ·.*")
    imported(shared, page, "electropuls", 30)
    page.get_by_text("“Put rows in the order of time” puts rows in order").wait_for()
    page.get_by_role("checkbox", name="Put rows in the order of time").click()
    imported(shared, page, "electropuls", 30)
    page.get_by_text("a zero of its own, and strain is counted from 0").wait_for()
    page.get_by_role("button", name="Open electropuls").click()
    recording = arrived(shared, page, "electropuls")
    wanted = pd.DataFrame(raw(file)).drop_duplicates(0).to_numpy()
    assert recording.time_s == pytest.approx(wanted[:, 0], **WRITTEN)
    assert recording["displacement_mm"] == pytest.approx(wanted[:, 8], **WRITTEN)
    assert recording["force_N"] == pytest.approx(wanted[:, 7], **WRITTEN)


def test_three_clocks_without_a_header_and_leads_that_were_swapped(shared: Served, page) -> None:
    file = "foreign/headerless-7-columns.csv"
    columns = {"time": 3, "displacement": 4, "force": 6, "resistance": 2}
    units = {"time": "s", "displacement": "mm", "force": "N", "resistance": "Ω"}
    turned = ("Turn the sign of the displacement",)
    read(shared, page, file, Said(columns, units, clocks={"displacement": 5, "force": 7}, boxes=turned))
    imported(shared, page, "clocks", 40)
    page.get_by_text("if its leads were the other way round").wait_for()
    page.get_by_role("checkbox", name="Turn the sign of the resistance").click()
    imported(shared, page, "clocks", 40)
    recording, table = arrived(shared, page, "clocks"), raw(file, header=None)
    time_s = table[:, 2]
    inside = (time_s >= max(table[0, 4], table[0, 6])) & (time_s <= min(table[-1, 4], table[-1, 6]))
    time_s = time_s[inside]
    assert recording.time_s == pytest.approx(time_s - time_s[0], **WRITTEN)
    assert recording["resistance_ohm"] == pytest.approx(-table[inside, 1], **WRITTEN)
    assert recording["displacement_mm"] == pytest.approx(-np.interp(time_s, table[:, 4], table[:, 3]), **WRITTEN)
    assert recording["force_N"] == pytest.approx(np.interp(time_s, table[:, 6], table[:, 5]), **WRITTEN)


def test_neither_header_nor_time_needs_a_rate_and_a_resistance_to_relate_to(shared: Served, page) -> None:
    file = "foreign/bom-headerless-12-columns.csv"
    read(shared, page, file, Said(numbers={"Sampling rate / Hz": "100"}))
    page.get_by_text("choose its column, or those of force and resistance").wait_for()
    for label, option in (("Column of strain", "1"), ("Unit of strain", "%"), ("Column of (R-R0)/R0", "2")):
        show(page, label)
        pick(page, label, option)
    page.get_by_label("Resistance at rest R0 / Ω").fill("1000")
    page.keyboard.press("Tab")
    imported(shared, page, "sleeve", 40)
    recording, wanted = arrived(shared, page, "sleeve"), raw(file, header=None, encoding="utf-8-sig")
    assert recording.mean_rate_hz == pytest.approx(100)
    assert recording["resistance_ohm"] == pytest.approx(1000 * (1 + wanted[:, 1]), **WRITTEN)
    assert recording["displacement_mm"] == pytest.approx(0.4 * wanted[:, 0], **WRITTEN)


def test_what_has_no_unit_is_asked_for_each(shared: Served, page) -> None:
    file = "real/silver_nylon_thread/steps_inc_single_1.csv"
    read(shared, page, file)
    imported(shared, page, "thread", 40)
    page.get_by_text(re.compile("^Strain: the file does not say the unit")).wait_for()
    pick(page, "Unit of strain", "as a ratio")
    pick(page, "Unit of force", "N")
    page.get_by_label("Resistance at rest R0 / Ω").fill("100")
    page.keyboard.press("Tab")
    imported(shared, page, "thread", 40)
    recording, wanted = arrived(shared, page, "thread"), raw(file)
    assert recording["displacement_mm"] == pytest.approx(40 * wanted[:, 1], **WRITTEN)
    assert recording["force_N"] == pytest.approx(wanted[:, 2], **WRITTEN)
    assert recording["resistance_ohm"] == pytest.approx(100 * wanted[:, 3], **WRITTEN)


def test_a_pressure_film_has_no_gauge_length(shared: Served, page) -> None:
    file = "real/velostat_pressure/pike1_exp1.csv"
    read(shared, page, file, Said(units={"resistance": "Ω"}))
    imported(shared, page, "film", None)
    recording, wanted = arrived(shared, page, "film"), raw(file)
    assert not recording.has("displacement_mm")
    assert recording["force_N"] == pytest.approx(wanted[:, 1], **WRITTEN)
    assert recording["resistance_ohm"] == pytest.approx(wanted[:, 2], **WRITTEN)


def test_five_pulls_in_one_file_become_five_campaigns(shared: Served, page) -> None:
    file = "real/knit_fabric_uniaxial/acrylic_yarn_garter_x.csv"
    read(shared, page, file)
    imported(shared, page, "fabric", 91.6)
    page.get_by_role("button", name="Open fabric-5").wait_for()
    table = raw(file)
    for number in range(1, 6):
        recording, wanted = read_recording(shared.root / f"fabric-{number}"), table[table[:, 0] == number]
        assert recording["displacement_mm"] == pytest.approx(wanted[:, 3], **WRITTEN)
        assert recording["force_N"] == pytest.approx(wanted[:, 4], **WRITTEN)
    page.get_by_role("button", name="Open fabric-1").click()
    arrived(shared, page, "fabric-1")
