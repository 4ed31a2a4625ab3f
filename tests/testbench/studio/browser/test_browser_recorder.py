"""A recording goes on whatever becomes of the studio, and is gone on with whatever becomes of the recorder."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import expect

from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, samples, shot, until
from tests.testbench.studio.served import Served, start_studio

pytestmark = IN_CHROMIUM

MINUTE_S, LONG_S = 60, 900  # the latter outlasts everything that a busy machine does meanwhile


@pytest.fixture
def planned(running: Served, request: pytest.FixtureRequest) -> Served:
    """A studio with a program; of a quarter of an hour unless the test says otherwise."""
    duration_s = getattr(request, "param", LONG_S)
    motion = ["--preset", "paper-1", "--seed", "7", "--gauge-length-mm", "25", "--duration-s", str(duration_s)]
    assert gcode(["generate", *motion, "-o", str(running.root / "programs" / "motion")]) == 0
    return running


def record(page, address: str) -> None:
    page.goto(f"{address}/record")
    page.get_by_role("button", name="Record", exact=False).last.click()
    samples(page, 100)


def lines(root: Path) -> list[str]:
    return (root / "recorded-1" / "recording.csv").read_text().splitlines()


def rows(root: Path) -> int:
    return len(lines(root))


def longest_gap_s(root: Path) -> float:
    """Between neighbouring samples; the last line may not be whole yet."""
    times_s = [float(line.partition(",")[0]) for line in lines(root)[1:-1]]
    return float(np.diff(times_s).max())


def status(root: Path) -> str:
    return json.loads((root / "recorded-1" / "datapackage.json").read_text())["knitbench"]["status"]


def test_the_recorder_outlives_a_killed_server_and_is_found_again(planned: Served, page) -> None:
    record(page, planned.address)
    page.goto("about:blank")  # the tab would complain that its server is gone
    planned.process.send_signal(signal.SIGKILL)
    planned.process.wait()
    before = rows(planned.root)
    until(page, lambda: rows(planned.root) > before + 60)
    assert longest_gap_s(planned.root) < 0.5, "about 37 samples a second go on being recorded, and none is lost"
    port = int(planned.address.rpartition(":")[2])
    again = start_studio(planned.root, port)
    try:
        page.goto(planned.address)
        page.get_by_text("recording now").wait_for()
        page.goto(f"{planned.address}/recording?c=recorded-1")
        page.get_by_role("button", name="Watch it live").click()
        samples(page, 100)
        shot(page, "found-again")
        page.get_by_role("button", name="Stop").click()
        page.get_by_role("button", name="Resume").wait_for()
        assert status(planned.root) == "interrupted"
        assert run_testbench(["verify", str(planned.root / "recorded-1")]) == 0
        page.goto("about:blank")
    finally:
        again.send_signal(signal.SIGINT)
        assert again.wait(180) in (0, 130)


@pytest.mark.parametrize("planned", [MINUTE_S], indirect=True)
def test_a_killed_recorder_leaves_an_unfinished_campaign_that_resumes(planned: Served, page) -> None:
    record(page, planned.address)
    about = json.loads((planned.root / "results" / "running" / "record" / "job.json").read_text())
    os.kill(about["pid"], signal.SIGKILL)
    page.get_by_text("something outside the studio ended it").wait_for()
    page.goto(planned.address)
    page.get_by_text("unfinished", exact=True).wait_for()
    shot(page, "unfinished-card")
    page.get_by_role("link", name="recorded-1").click()
    page.get_by_text("The recorder was cut off").wait_for()
    page.wait_for_selector(".js-plotly-plot .main-svg")
    shot(page, "unfinished")
    before = rows(planned.root)
    page.get_by_role("button", name="Resume").click()
    page.wait_for_url("**/record")
    page.get_by_text(re.compile("Recording recorded-1: complete")).wait_for()
    assert status(planned.root) == "complete"
    assert rows(planned.root) > before
    assert run_testbench(["verify", str(planned.root / "recorded-1")]) == 0
    page.goto(planned.address)
    page.get_by_text("verified").wait_for()
    expect(page.get_by_text("unfinished", exact=True)).to_have_count(0)


def test_ending_the_studio_says_that_the_recording_goes_on(planned: Served, page) -> None:
    record(page, planned.address)
    page.goto("about:blank")
    about = json.loads((planned.root / "results" / "running" / "record" / "job.json").read_text())
    planned.process.send_signal(signal.SIGINT)
    assert planned.process.wait(180) in (0, 130)
    assert subprocess.run(["kill", "-0", str(about["pid"])]).returncode == 0
    before = rows(planned.root)
    until(page, lambda: rows(planned.root) > before)
    os.kill(about["pid"], signal.SIGINT)
    until(page, lambda: status(planned.root) == "interrupted")
