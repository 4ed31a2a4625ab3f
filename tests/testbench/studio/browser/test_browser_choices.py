"""What is chosen on a page: a second model, a quantity, a stretch of time; kept in the address, undone with Back."""

from __future__ import annotations

import json
import re
import shutil
import time

import pytest
from playwright.sync_api import expect

from testbench.studio.workspace import MANIFEST
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, shot, until
from tests.testbench.studio.served import Served

pytestmark = IN_CHROMIUM

LINES = "[...document.querySelector('.js-plotly-plot').data].map(trace => trace.name)"


def test_two_models_stand_side_by_side_over_one_recording(full: Served, page) -> None:
    shutil.copytree(full.root / "knit", full.root / "other")
    shutil.copytree(full.root / "results" / "knit", full.root / "results" / "other")
    path = full.root / "results" / "other" / "model.json"
    model = json.loads(path.read_text())
    elasticity = next(effect for effect in model["effects"] if effect["name"] == "elasticity")
    elasticity["parameters"]["stiffness_N"] *= 1.5
    model["fit"]["parameters"]["elasticity.stiffness_N"]["value"] *= 1.5
    path.write_text(json.dumps(model))
    page.goto(f"{full.address}/compare?c=knit")
    page.get_by_text("Where it fails, the worst first").wait_for()
    page.get_by_role("combobox", name="A second model beside it").click()
    page.get_by_role("option", name="that of other").click()
    page.wait_for_url(re.compile("beside=other"))
    page.get_by_text("RMS error of the force (that of other)").wait_for()
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    assert {"that of other", "baseline", "measured"} <= set(page.evaluate(LINES))
    row = page.locator("tr", has_text="elasticity: stiffness")
    row.wait_for()
    values = row.locator("td").all_inner_texts()
    assert len(values) == 3
    assert values[1] != values[2]
    shot(page, "two-models")
    page.goto(f"{full.address}/compare?c=knit&beside=7")
    page.get_by_text("there is no second model '7' for knit").wait_for()


def test_a_candidate_is_seen_as_resistance_and_its_stretch_is_in_the_address(standing: Served, page) -> None:
    page.goto(f"{standing.address}/missing?c=knit&pick=load_cell_creep&show=resistance&start=180&end=200")
    page.get_by_text("lie on the dashed line").wait_for()
    plots = page.locator(".js-plotly-plot")
    plots.nth(1).scroll_into_view_if_needed()
    title = "document.querySelectorAll('.js-plotly-plot')[1]?.layout?.yaxis2?.title.text"
    page.wait_for_function(f"() => {title} === 'Resistance<br>residual (kΩ)'")
    page.get_by_role("button", name="Add load cell creep").wait_for()
    shown = page.evaluate("[...document.querySelectorAll('.js-plotly-plot')][1].layout.xaxis.range")
    assert shown == pytest.approx([180, 200], abs=0.02)
    page.get_by_role("button", name="Conductance", exact=True).click()
    page.wait_for_function(f"() => {title} === 'Conductance<br>residual / ln S'")
    page.wait_for_function("() => location.search.includes('start=180')")
    page.wait_for_function("() => location.search.includes('pick=load_cell_creep')")


def test_a_stretch_that_is_not_there_is_said(standing: Served, page) -> None:
    said = page.get_by_role("alert").filter(has_text="the address asks for times from")
    for path in ("/recording", "/compare", "/align"):
        for asked in ("start=130&end=100", "start=5000&end=6000", "start=soon&end=later", "start=30"):
            page.goto(f"{standing.address}{path}?c=knit&{asked}")
            said.wait_for()


def test_what_runs_is_seen_and_ended_on_every_page(full: Served, page) -> None:
    page.goto(f"{full.address}/missing?c=knit")
    page.get_by_role("button", name="Ask again").click()
    page.get_by_role("button", name="Stop", exact=True).wait_for()
    page.get_by_role("link", name="Own effects").click()
    region = page.get_by_role("region", name="Running now")
    region.get_by_role("link", name="Looking for what is missing in knit").wait_for()
    expect(region).to_contain_text("so far")
    shot(page, "running-elsewhere")
    region.get_by_role("button", name="End: Looking for what is missing in knit").click()
    expect(region).to_be_hidden()


def test_a_training_that_nobody_watches_is_scored_too(full: Served, page) -> None:
    score = full.root / "results" / "knit" / "force.score.json"
    score.unlink()
    page.goto(f"{full.address}/compensate?c=knit")
    page.get_by_role("button", name="Train").click()
    page.get_by_role("button", name="Stop", exact=True).wait_for()
    page.goto("about:blank")
    until(page, score.exists)
    page.goto(f"{full.address}/compensate?c=knit")
    page.get_by_text("gained by compensation").wait_for()


def test_two_thousand_campaigns_are_listed_at_once(full: Served, page) -> None:
    made = (full.root / "knit" / MANIFEST).read_text()
    for number in range(2000):
        folder = full.root / f"run-{number:04d}"
        folder.mkdir()
        (folder / MANIFEST).write_text(made)
    seconds = []
    for _ in range(3):
        start_s = time.monotonic()
        page.goto(full.address)
        page.get_by_text("2001 campaigns").wait_for()
        seconds.append(time.monotonic() - start_s)
    print(f"2001 campaigns listed after {', '.join(f'{one:.2f}' for one in seconds)} s, the page itself included")
    page.get_by_label("Search").fill("run-1234")
    page.get_by_text("1 of 2001").wait_for()
