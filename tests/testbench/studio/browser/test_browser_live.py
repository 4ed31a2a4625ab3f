"""A compensator follows a recording in a real browser: what it makes of the resistance, beside the measured force."""

from __future__ import annotations

import numpy as np
import pandas as pd

from tests.testbench.studio.browser.browsing import IN_CHROMIUM, choose, samples, shot

pytestmark = IN_CHROMIUM

DRAWN = (
    "() => [...document.querySelectorAll('.js-plotly-plot')].flatMap(plot => (plot.data || []).map(one => one.name))"
)


def test_the_compensated_force_stands_beside_the_measured_one(full, page) -> None:
    page.goto(f"{full.address}/record")
    choose(page, "Compensator", "knit, force")
    page.get_by_role("button", name="Record", exact=False).last.click()
    samples(page, 100)
    page.get_by_text("Orange-red: what the compensator makes").wait_for()
    page.wait_for_function(f"() => ({DRAWN})().includes('Compensated force (N)')")
    shot(page, "live-compensated")
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("button", name="Open the recording").wait_for()
    measured, made = (pd.read_csv(full.root / "recorded-1" / f"{name}.csv") for name in ("recording", "compensated"))
    np.testing.assert_allclose(made["time_s"], measured["time_s"][: len(made)], atol=1e-6)
    assert len(made) > 100
    assert made["force_N"].nunique() > 50
