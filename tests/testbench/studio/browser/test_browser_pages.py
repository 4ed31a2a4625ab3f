"""Every page in a real browser: a clean console, nothing from outside, by keyboard, and when things go wrong."""

from __future__ import annotations

import itertools
import json
import os
import re
import shutil
import signal
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

import tests.testbench.report.samples as samples
from testbench.cli import main as run_testbench
from testbench.report.document import Picture, Report, Table
from testbench.report.figures import comparison_figures
from testbench.report.writing.page import to_html
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, PHONE, TABLET, screen, shot
from tests.testbench.studio.browser.seeing import nameless, unreadable
from tests.testbench.studio.served import Served, opened_report

pytestmark = IN_CHROMIUM

PAGES = {
    "/": "verified",
    "/side?a=knit&b=knit": "knit: six half minutes",
    "/import": "Import a file",
    "/plan?program=short": "Largest acceleration",
    "/record": "Campaign name",
    "/effects": "Save and check",
    "/recording?c=knit": "How often each value occurred",
    "/align?c=knit": "on the plan's clock",
    "/compare?c=knit": "Where it fails, the worst first",
    "/missing?c=knit": "lie on the dashed line",
    "/experiment?c=knit": "Find the motion",
    "/ladder?c=knit": "Through the history",
    "/compensate?c=knit": "Against the measurement",
}


def test_every_page_opens_by_its_address(standing: Served, page) -> None:
    for path, words in PAGES.items():
        page.goto(standing.address + path)
        page.get_by_text(words).first.wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 1280, path
        shot(page, f"page-{path.partition('?')[0].strip('/') or 'campaigns'}")


def test_every_page_fits_a_tablet(standing: Served, browser) -> None:
    with screen(browser, **TABLET) as tab:
        for path, words in PAGES.items():
            tab.goto(standing.address + path)
            tab.get_by_text(words).first.wait_for()
            shot(tab, f"tablet-{path.partition('?')[0].strip('/') or 'campaigns'}")
            assert tab.evaluate("document.documentElement.scrollWidth") <= 820, path


def test_every_page_fits_a_phone_and_names_itself(standing: Served, browser) -> None:
    with screen(browser, **PHONE) as tab:
        for path, words in PAGES.items():
            tab.goto(standing.address + path)
            tab.get_by_text(words).first.wait_for()
            tab.wait_for_function("() => document.title.includes(' · knitbench')")
            shot(tab, f"phone-{path.partition('?')[0].strip('/') or 'campaigns'}")
            assert tab.evaluate("document.documentElement.scrollWidth") <= 390, path
            assert tab.evaluate(IN_VIEW), f"{path}: the active tab is in view"
            assert tab.evaluate(
                "[...document.querySelectorAll('.js-plotly-plot')].every(e => e.ariaLabel?.length > 10)"
            )


IN_VIEW = """() => {
  const tab = document.querySelector('.tabs .here')?.getBoundingClientRect();
  return !tab || (tab.left >= 0 && tab.right <= window.innerWidth);
}"""


@pytest.mark.parametrize("width", [1280, 390])
def test_everything_can_be_read_and_has_a_name(standing: Served, browser, width: int) -> None:
    with screen(browser, width, 844) as tab:
        wrong: dict[str, list[str]] = {}
        for path, words in PAGES.items():
            tab.goto(standing.address + path)
            tab.get_by_text(words).first.wait_for()
            draw_all(tab)
            found = unreadable(tab) + nameless(tab)
            wrong |= {path: found} if found else {}
    assert not wrong


def draw_all(tab) -> None:
    """Bring every plot near the screen, and wait until it is drawn."""
    for plot in tab.locator(".js-plotly-plot").all():
        plot.scroll_into_view_if_needed()
        tab.wait_for_function("e => e.dataset.drawn", arg=plot.element_handle())


def test_panels_stack_on_a_phone_and_no_plot_overlaps_the_next(standing: Served, browser) -> None:
    with screen(browser, 390, 844) as tab:
        tab.goto(f"{standing.address}/recording?c=knit")
        tab.get_by_text("How often each value occurred").wait_for()
        draw_all(tab)
        widths = tab.evaluate(
            "[...document.querySelectorAll('.js-plotly-plot')]"
            ".map(e => [e.layout.xaxis.domain, e.layout.xaxis2?.domain])"
        )
        assert all(domain in (None, [0, 1]) for pair in widths for domain in pair)
        boxes = tab.evaluate(
            "[...document.querySelectorAll('figure')].map(e => [e.getBoundingClientRect().top, e.scrollHeight,"
            " Math.max(...[...e.querySelectorAll('svg')].map(s => s.getBoundingClientRect().bottom))])"
        )
        for (_, _, bottom), (top, _, _) in itertools.pairwise(boxes):
            assert bottom <= top + 1


def test_compare_opens_where_it_fails_and_every_place_is_a_link(full: Served, page) -> None:
    shutil.copytree(full.root / "knit", full.root / "other")
    path = full.root / "results" / "knit" / "model.json"
    model = json.loads(path.read_text()) | {"held_out": str(full.root / "other" / "recording.csv")}
    path.write_text(json.dumps(model))
    page.goto(f"{full.address}/compare?c=knit")
    page.get_by_text("Where it fails, the worst first").wait_for()
    page.get_by_text("other (held out)").wait_for()
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    opened = page.evaluate("document.querySelector('.js-plotly-plot').layout.xaxis.range")
    assert 5 < opened[1] - opened[0] < 100, "zoomed to the worst place"
    places = page.locator("button.finding")
    places.nth(1).click()
    page.wait_for_function("() => location.search.includes('start=')")
    shown = page.evaluate("document.querySelector('.js-plotly-plot').layout.xaxis.range")
    assert shown != opened
    page.reload()
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    again = page.evaluate("document.querySelector('.js-plotly-plot').layout.xaxis.range")
    assert again == pytest.approx(shown, abs=0.02), "the zoom is in the address"
    page.get_by_role("button", name="Resistance in kΩ").click()
    page.get_by_text("RMS error of the resistance").wait_for()
    page.get_by_role("link", name="Error ladder").click()
    page.get_by_text("held-out resistance").wait_for()
    page.wait_for_function("() => location.search.includes('show=resistance')")
    page.goto(f"{full.address}/compare?c=knit&start=130&end=100")
    page.get_by_text("the end must come after the start").wait_for()


@pytest.mark.parametrize(("start", "end", "said"), [("130", "100", "before 130 s"), ("5000", "6000", "it ends at")])
def test_a_wrong_stretch_is_said_in_place(standing: Served, page, start: str, end: str, said: str) -> None:
    page.goto(f"{standing.address}/recording?c=knit")
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    page.get_by_label("From / s").fill(start)
    page.get_by_label("to / s").fill(end)
    page.keyboard.press("Enter")
    page.get_by_text(said).wait_for()


def test_the_parameter_table_stands_on_compare_and_ladder(standing: Served, page) -> None:
    for path in ("/compare", "/ladder"):
        page.goto(f"{standing.address}{path}?c=knit")
        row = page.locator("tr", has_text="elasticity: stiffness")
        row.wait_for()
        assert "±" in row.inner_text()
        assert "to 10000 N" in row.inner_text()


def test_the_report_has_a_link_and_the_diagnosis_that_led_to_it(full: Served, page) -> None:
    page.goto(f"{full.address}/ladder?c=knit")
    report = opened_report(page)
    assert "What is missing" in report.inner_text("main")
    assert "SHA-256" in report.inner_text("main")
    page.reload()
    page.get_by_role("link", name="Open the report").wait_for()


def test_campaigns_are_searched_tagged_and_deleted_with_undo(full: Served, page) -> None:
    shutil.copytree(full.root / "knit", full.root / "strip")
    page.goto(full.address)
    page.get_by_text("2 campaigns").wait_for()
    page.get_by_role("button", name="Tags and note of strip").click()
    page.get_by_label("Tags, with commas between").fill("wet, first")
    page.get_by_role("button", name="Save").click()
    page.get_by_text("wet", exact=True).wait_for()
    page.get_by_label("Search").fill("wet")
    page.get_by_text("1 of 2").wait_for()
    page.wait_for_function("() => location.search.includes('q=wet')")
    page.reload()
    page.get_by_text("1 of 2").wait_for()
    page.get_by_role("button", name="Delete strip").click()
    page.get_by_text("strip was deleted.").wait_for()
    assert not (full.root / "strip").exists()
    page.get_by_role("button", name="Undo").click()
    page.get_by_text("1 of 2").wait_for()
    assert (full.root / "strip" / "recording.csv").is_file()


def test_the_c_header_is_exported_and_compiles(full: Served, page, tmp_path: Path) -> None:
    page.goto(f"{full.address}/compensate?c=knit")
    with page.expect_download() as download:
        page.get_by_role("button", name="Export for the chip").click()
    header = tmp_path / download.value.suggested_filename
    download.value.save_as(header)
    source = tmp_path / "chip.c"
    source.write_text(f'#include "{header.name}"\nint main(void) {{ return 0; }}\n')
    subprocess.run(["cc", "-std=c99", "-Wall", "-Werror", str(source), "-o", str(tmp_path / "chip")], check=True)


def test_a_tie_leads_to_an_experiment_and_its_program(full: Served, page) -> None:
    page.goto(f"{full.address}/missing?c=knit")
    page.get_by_role("button", name="Design the experiment that tells them apart").click()
    page.get_by_label("Duration / min").fill("2")
    page.get_by_role("button", name="Find the motion").click()
    page.get_by_role("button", name="Download the Mach4 program").wait_for()
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    shot(page, "experiment")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the Mach4 program").click()
    assert "G1" in download.value.path().read_text()
    page.get_by_role("button", name="Open in Plan and run").click()
    page.get_by_text("Run it on the simulated rig").wait_for()


def test_the_whole_way_by_keyboard(standing: Served, page) -> None:
    page.goto(standing.address)
    page.get_by_text("verified").wait_for()
    _tab_to(page, "knit")
    page.keyboard.press("Enter")
    page.get_by_label("From / s").wait_for()
    _tab_to(page, "Compare")
    outline = page.evaluate("getComputedStyle(document.activeElement).outlineStyle")
    assert outline == "solid", "the focus is seen"
    _tab_to(page, "From / s")
    page.keyboard.type("60")
    page.keyboard.press("Tab")
    page.keyboard.type("90")
    page.keyboard.press("Enter")
    page.wait_for_function(
        "() => { const row = document.querySelector('.js-plotly-plot').calcdata[0];"
        " return row[0].x > 55 && row[row.length - 1].x < 95; }"
    )
    page.goto(f"{standing.address}/missing?c=knit")
    page.get_by_text("lie on the dashed line").wait_for()
    _tab_to(page, "2. load cell creep")
    page.keyboard.press("Enter")
    page.get_by_role("button", name="Add load cell creep").wait_for()


def _tab_to(page, words: str) -> None:
    """Press Tab until what is focused says, or is labelled, `words`."""
    said = "(e => [e.ariaLabel, e.innerText, ...[...(e.labels ?? [])].map(l => l.innerText)].join(' '))"
    for _ in range(60):
        page.keyboard.press("Tab")
        if words in page.evaluate(f"{said}(document.activeElement)"):
            return
    raise AssertionError(f"no way to {words!r} by keyboard")


def test_a_job_that_is_killed_takes_nothing_down(full: Served, page) -> None:
    page.goto(f"{full.address}/missing?c=knit")
    page.get_by_role("button", name="Ask again").click()
    page.get_by_role("button", name="Stop").wait_for()
    job = subprocess.run(["pgrep", "-P", str(full.process.pid), "-f", "diagnose"], capture_output=True, text=True)
    os.kill(int(job.stdout.split()[0]), signal.SIGKILL)
    page.get_by_text("something outside the studio ended it (SIGKILL)").wait_for()
    shot(page, "job-killed")
    page.get_by_role("link", name="Error ladder").click()
    page.get_by_text("Through the history").wait_for()


def test_what_is_not_ours_or_was_changed_is_said(full: Served, page) -> None:
    (full.root / "foreign").mkdir()
    (full.root / "foreign" / "datapackage.json").write_text('{"name": "somebody else"}')
    with (full.root / "knit" / "recording.csv").open("a") as stream:
        stream.write("9999,0,0,0\n")
    page.goto(full.address)
    page.get_by_text("not ours").wait_for()
    page.get_by_text("changed", exact=True).wait_for()
    shot(page, "campaigns-in-trouble")
    page.goto(f"{full.address}/recording?c=knit")
    page.get_by_text("does not agree with its manifest").wait_for()
    shot(page, "changed")
    page.goto(f"{full.address}/recording?c=foreign")
    page.get_by_role("alert").wait_for()


def test_two_tabs_see_the_same_and_do_not_fight(full: Served, page, browser) -> None:
    with screen(browser, 1280, 800) as other:
        for tab in (page, other):
            tab.goto(f"{full.address}/plan")
            tab.get_by_label("Duration / min").fill("2")
        for tab in (page, other):
            tab.get_by_role("button", name="Plan", exact=True).click()
        for tab in (page, other):
            tab.wait_for_url(re.compile(r"/plan\?program=paper-1-seed51-25mm-2min&"))


def test_a_report_opens_without_a_network(finished: Path, page, tmp_path: Path) -> None:
    results = finished / "results" / "knit"
    inputs = ["--recording", str(finished / "knit"), "--model", str(results / "model.json")]
    inputs += ["--compensator", str(results / "force.score.json")]
    assert run_testbench(["report", *inputs, "-o", str(tmp_path / "report.html")]) == 0
    page.context.set_offline(True)
    page.goto((tmp_path / "report.html").as_uri())
    page.wait_for_selector(".plot[data-drawn] .main-svg")
    page.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    page.wait_for_function("() => document.querySelectorAll('.plot:not([data-drawn])').length === 0")
    shot(page, "report")
    page.emulate_media(media="print")
    left = "what => document.querySelector(what).getBoundingClientRect().left"
    assert page.evaluate(left, "section .plot") == page.evaluate(left, "main"), "nothing widens the paper"


LONG = "the_second_specimen-of-the-double-knit_polyester-and-lycra_with-a-name-that-goes-on_2023-11-27_run-42"


def test_long_names_do_not_widen_a_phone(full: Served, browser) -> None:
    shutil.copytree(full.root / "knit", full.root / LONG)
    (full.root / "programs" / "short").rename(full.root / "programs" / LONG)
    with screen(browser, **PHONE) as tab:
        for path, label in (("/compensate?c=knit", "Judged on"), ("/record", "Program")):
            tab.goto(full.address + path)
            tab.get_by_role("combobox", name=label).wait_for()
            tab.get_by_text(LONG).first.wait_for()
            assert tab.evaluate("document.documentElement.scrollWidth") <= 390, path
        unbroken = 176 * "k"
        (full.root / LONG).rename(full.root / unbroken)
        tab.goto(f"{full.address}/side?a=knit&b={unbroken}")
        tab.get_by_text(f"{unbroken}: six half minutes").wait_for()
        assert tab.evaluate("document.documentElement.scrollWidth") <= 390


def test_no_legend_lies_under_the_tools_of_its_plot_on_a_phone(standing: Served, browser) -> None:
    with screen(browser, **PHONE) as tab:
        for path in ("/recording?c=knit", "/compare?c=knit", "/compensate?c=knit"):
            tab.goto(standing.address + path)
            tab.get_by_text(PAGES[path]).first.wait_for()
            draw_all(tab)
            gaps = tab.evaluate(
                "[...document.querySelectorAll('.js-plotly-plot:has(.legend)')].map(e =>"
                " e.querySelector('.legend').getBoundingClientRect().top"
                " - e.querySelector('.modebar').getBoundingClientRect().bottom)"
            )
            assert gaps
            assert min(gaps) >= 0, path


def test_a_report_on_a_phone_cuts_no_name_off_and_breaks_no_word(browser, tmp_path) -> None:
    both = samples.overlay()
    named = replace(both, modelled={"+ contact relaxation asymmetric (after 2 steps)": both.modelled["baseline"]})
    picture = Picture("signals", comparison_figures.signals(named), "Both.")
    table = Table(("Effect",) * 8, [("relaxation",) * 8], "Words that go on for longer than a phone is wide, below.")
    (tmp_path / "report.html").write_text(to_html(Report("T", "V", [picture, table])), encoding="utf-8")
    with screen(browser, 390, 844) as tab:
        tab.goto((tmp_path / "report.html").as_uri())
        tab.wait_for_selector(".legendtext")
        right = "what => Math.max(...[...document.querySelectorAll(what)].map(e => e.getBoundingClientRect().right))"
        assert tab.evaluate(right, ".legendtext") <= 390
        assert tab.evaluate(right, "caption") <= 390
        assert tab.evaluate("document.querySelector('td').getBoundingClientRect().height") < 50, "one line"
