"""Every page in a real browser: a clean console, nothing from outside, by keyboard, and when things go wrong."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
from pathlib import Path

import pytest

import tests.testbench.report.samples as samples
from compensation.cli import main as compensation
from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from tests.testbench.studio.browsing import IN_CHROMIUM, browser, page, running, shot
from tests.testbench.studio.served import Served

pytestmark = IN_CHROMIUM
__all__ = ["browser", "page", "running"]  # pytest finds its fixtures by name

PAGES = {
    "/": "Campaigns",
    "/import": "Import a CSV",
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


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A workspace in which every step of one campaign has been made."""
    root = tmp_path_factory.mktemp("finished")
    program, knit, results = root / "programs" / "short", root / "knit", root / "results" / "knit"
    motion = ["--preset", "paper-1", "--seed", "7", "--gauge-length-mm", "25", "--duration-s", "240"]
    assert gcode(["generate", *motion, "-o", str(program)]) == 0
    sensor = ["--sensor", "pes", "--program", str(program / "program.tap"), "--seed", "1"]
    assert run_testbench(["run", *sensor, "-o", str(knit)]) == 0
    results.mkdir(parents=True)
    model, compensator = results / "model.json", results / "force.compensator.json"
    assert run_testbench(["fit", str(knit), "-o", str(model)]) == 0
    history = json.loads(model.read_text())["history"]
    (results / "diagnosis.json").write_text(json.dumps(samples.diagnosis() | {"history": history}))
    training = ["train", str(knit), "--target", "force", "--hidden", "4,2,2", "-o", str(compensator)]
    assert compensation(training) == 0
    assert compensation(["score", str(compensator), str(knit), "-o", str(results / "force.score.json")]) == 0
    return root


@pytest.fixture
def full(running: Served, finished: Path) -> Served:
    """A studio over a copy of that workspace."""
    shutil.copytree(finished, running.root, dirs_exist_ok=True)
    return running


def test_every_page_opens_by_its_address(full: Served, page) -> None:
    for path, words in PAGES.items():
        page.goto(full.address + path)
        page.get_by_text(words).first.wait_for()
        assert page.evaluate("document.documentElement.scrollWidth") <= 1280, path
        shot(page, f"page-{path.partition('?')[0].strip('/') or 'campaigns'}")


def test_every_page_fits_a_tablet(full: Served, browser) -> None:
    context = browser.new_context(viewport={"width": 820, "height": 1180}, has_touch=True)
    tab = context.new_page()
    for path, words in PAGES.items():
        tab.goto(full.address + path)
        tab.get_by_text(words).first.wait_for(timeout=60_000)
        shot(tab, f"tablet-{path.partition('?')[0].strip('/') or 'campaigns'}")
        assert tab.evaluate("document.documentElement.scrollWidth") <= 820, path
    context.close()


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


def test_the_whole_way_by_keyboard(full: Served, page) -> None:
    page.goto(full.address)
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
    page.goto(f"{full.address}/missing?c=knit")
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
    other = browser.new_page()
    for tab in (page, other):
        tab.goto(f"{full.address}/plan")
        tab.get_by_label("Duration / min").fill("2")
    for tab in (page, other):
        tab.get_by_role("button", name="Plan", exact=True).click()
    for tab in (page, other):
        tab.wait_for_url("**/plan?program=paper-1-seed51-25mm-2min", timeout=60_000)
    other.close()


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
