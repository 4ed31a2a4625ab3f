"""Importing in a real browser: what a tester, a script and a spreadsheet wrote, without reading a word of help."""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import pytest
from playwright.sync_api import expect

from testbench.recordings.files import read_recording
from tests.testbench.importing import exports
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, PHONE, choose, opened, screen, shot
from tests.testbench.studio.browser.seeing import nameless, unreadable

pytestmark = IN_CHROMIUM


BEYOND_THE_EDGE = """[...document.querySelectorAll('.page *')].filter(e => !e.closest('.rawbox'))
  .filter(e => e.checkVisibility() && e.getBoundingClientRect().right > innerWidth + 1)
  .map(e => e.outerHTML.slice(0, 120))"""


@pytest.mark.parametrize("export", [exports.testxpert, exports.bluehill, exports.workbook])
def test_a_file_needs_nothing_but_its_gauge_length(shared, page, tmp_path, export) -> None:
    opened(shared, page, export(tmp_path))
    read = {"workbook": "0.439377 MΩ read as 439 377 Ω"}.get(export.__name__, "439.377 kΩ read as 439 377 Ω")
    page.get_by_text(read).wait_for()
    assert page.get_by_label("Gauge length / mm").input_value() == ""
    page.get_by_role("button", name="Import", exact=True).click()
    page.get_by_text("“Gauge length / mm” is empty").wait_for()
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_text("“Gauge length / mm” is empty").wait_for(state="detached")
    page.get_by_label("Campaign name").fill(export.__name__)
    shot(page, f"import-{export.__name__}")
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url(f"**/recording?c={export.__name__}")
    recording = read_recording(shared.root / export.__name__)
    assert recording["resistance_ohm"] == pytest.approx(exports.RESISTANCE_OHM, rel=1e-6)
    assert recording["force_N"] == pytest.approx(exports.FORCE_N, abs=1e-5)


def test_a_file_without_header_is_asked_about_and_its_doubt_is_shown(shared, page, tmp_path) -> None:
    opened(shared, page, exports.headerless(tmp_path))
    page.get_by_text("no row of names").wait_for()
    page.get_by_text("choose its column, or fill in “Sampling rate / Hz”").wait_for()
    for role, column, unit in (
        ("time", "2", "s"), ("displacement", "3", "mm"), ("force", "5", "N"), ("resistance", "1", "Ω"),
    ):  # fmt: skip
        choose(page, f"Column of {role}", column)
        page.get_by_text("the file does not say the unit: choose it").wait_for()
        choose(page, f"Unit of {role}", unit)
        page.get_by_text("the file does not say the unit: choose it").wait_for(state="detached")
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_label("Campaign name").fill("raw")
    shot(page, "import-headerless")
    page.get_by_role("button", name="Import", exact=True).click()
    doubt = page.get_by_text("one of them runs the wrong way; choose “Turn the sign” at displacement")
    doubt.wait_for()
    expect(doubt).to_be_in_viewport()
    page.get_by_role("checkbox", name="Turn the sign of the displacement").click()
    page.get_by_label("Campaign name").fill("turned")
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url("**/recording?c=turned")
    assert read_recording(shared.root / "turned")["displacement_mm"].max() == pytest.approx(6.0, abs=0.01)


def test_header_and_encoding_can_be_changed(shared, page, tmp_path) -> None:
    path = tmp_path / "two.csv"
    rows = "".join(f"{0.1 * n:.1f},{n % 7}.5,{n % 5}.25\n" for n in range(50))
    path.write_text("Time [s],Extension [mm],Load [N]\nTime [ms],Extension [cm],Load [mN]\n" + rows)
    opened(shared, page, path)
    page.get_by_text("names in row 2").wait_for()
    page.get_by_label("Header row").fill("1")
    page.get_by_label("Units row").fill("0")
    page.get_by_text("names in row 1").wait_for()
    expect(page.locator("table.raw tr.names th").first).to_have_text("1 names")


def test_an_upload_leaves_nothing_behind(shared, page, tmp_path) -> None:
    def left() -> set[Path]:
        return set(Path(tempfile.gettempdir()).glob("knitbench-upload-*"))

    before = left()
    page.goto(f"{shared.address}/import")
    page.locator("input[type=file]").set_input_files(exports.testxpert(tmp_path))
    page.get_by_text("Found: ").wait_for()
    assert len(left() - before) == 1
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_label("Campaign name").fill("uploaded")
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url(re.compile("recording"))
    assert left() == before


def test_what_is_left_out_of_several_files_is_said(shared, page, tmp_path) -> None:
    first, second, third = exports.testxpert(tmp_path), tmp_path / "second.csv", tmp_path / "notes.pdf"
    second.write_text("a,b\n1,2\n")
    third.write_bytes(b"%PDF-1.4\n")
    page.goto(f"{shared.address}/import")
    page.locator("input[type=file]").set_input_files([first, second, third])
    page.get_by_text("notes.pdf: no file of a kind that can be read").wait_for()
    page.get_by_text("second.csv: left out, for one file is imported at a time").wait_for()
    page.get_by_text("Found: names in row 1").wait_for()


def test_a_decimal_comma_is_a_point_in_every_field(shared, page, tmp_path) -> None:
    opened(shared, page, exports.testxpert(tmp_path))
    field = page.get_by_label("Gauge length / mm")
    field.press_sequentially("25,5")
    assert field.input_value() == "25.5"


def test_a_row_that_cannot_be_used_is_said_with_the_pages_own_control(shared, page, tmp_path) -> None:
    path = exports.testxpert(tmp_path)
    text = path.read_text("latin-1").splitlines()
    text[50] = text[50].replace(";", ";?", 1)
    path.write_text("\n".join(text), "latin-1")
    opened(shared, page, path)
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_label("Campaign name").fill("damaged")
    page.get_by_role("button", name="Import", exact=True).click()
    said = page.locator(".trouble").filter(has_text="“Leave out rows that cannot be used” leaves such rows out")
    said.wait_for()
    expect(said).to_be_in_viewport()
    assert "--" not in said.inner_text()
    page.get_by_role("checkbox", name="Leave out rows that cannot be used").click()
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url(re.compile("recording"))


def test_the_page_with_a_file_fits_a_phone(shared, browser, tmp_path) -> None:
    with screen(browser, **PHONE) as tab:
        for export in (exports.testxpert, exports.bluehill, exports.headerless, exports.workbook):
            opened(shared, tab, export(tmp_path))
            tab.get_by_role("combobox", name="Column of force").wait_for()
            shot(tab, f"phone-import-{export.__name__}")
            assert tab.evaluate("document.documentElement.scrollWidth") <= 390, export.__name__
            assert tab.evaluate(BEYOND_THE_EDGE) == [], export.__name__
            assert not unreadable(tab) + nameless(tab)
