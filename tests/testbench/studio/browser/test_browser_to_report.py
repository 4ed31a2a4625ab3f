"""From the file of a tester, a script or a spreadsheet to a verdict and a report, by the page alone; timed."""

from __future__ import annotations

import itertools
import json
import os
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.recordings.files import read_recording
from tests.testbench.importing import exports
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, SHOTS, choose, shot
from tests.testbench.studio.served import Served, opened_report

pytestmark = IN_CHROMIUM

COLUMNS = (("time", "2", "s"), ("displacement", "3", "mm"), ("force", "5", "N"), ("resistance", "1", "Ω"))


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> exports.Measured:
    """Four minutes of a sensor whose force relaxes, which the baseline does not know, as it is sampled."""
    folder = tmp_path_factory.mktemp("measured")
    motion = ["--preset", "paper-1", "--seed", "7", "--gauge-length-mm", "40", "--duration-s", "240"]
    assert gcode(["generate", *motion, "-o", str(folder / "program")]) == 0
    model = baseline().plus(load_catalogue()["stress_relaxation"]().replaced(fraction=0.35, tau_s=12.0))
    (folder / "truth.json").write_text(json.dumps(model.to_dict()))
    argv = ["--model", str(folder / "truth.json"), "--program", str(folder / "program" / "program.tap")]
    assert run_testbench(["run", *argv, "--seed", "1", "-o", str(folder / "knit")]) == 0
    recording = read_recording(folder / "knit")
    since_s = recording.time_s - recording.time_s[0]
    return exports.Measured(since_s, *(recording[name] for name in ("displacement_mm", "force_N", "resistance_ohm")))


def test_from_a_file_to_verdict_and_report(running, page, tmp_path: Path, measured: exports.Measured) -> None:
    steps = Steps(running)
    import_and_fit(running, page, exports.testxpert, exports.testxpert(tmp_path, measured), steps)
    page.get_by_role("button", name="What is missing?").click()
    page.get_by_role("button", name="Find what is missing").click()
    page.locator(".verdict").wait_for(timeout=900_000)
    steps.end("verdict")
    page.get_by_role("link", name="Error ladder").click()
    report = opened_report(page)
    steps.end("report")
    shot(report, "report-testxpert")
    assert "What is missing" in report.inner_text("main")
    diagnosis = json.loads((running.root / "results" / "knit" / "diagnosis.json").read_text())
    assert diagnosis["ranking"][0]["effect"] == "stress_relaxation"
    note("testxpert", steps)


@pytest.mark.parametrize("export", [exports.bluehill, exports.headerless, exports.workbook])
def test_from_another_file_to_where_the_model_fails(
    running, page, tmp_path: Path, measured: exports.Measured, export: Callable
) -> None:
    steps = Steps(running)
    import_and_fit(running, page, export, export(tmp_path, measured), steps)
    note(export.__name__, steps)


def import_and_fit(running: Served, page, export: Callable, path: Path, steps: Steps) -> None:
    """By the page alone: a file becomes a campaign, and the baseline is fitted to it."""
    page.goto(running.address)
    page.get_by_role("button", name="Import a file").click()
    page.get_by_label("File on this machine").fill(str(path))
    page.get_by_role("button", name="Read the file").click()
    page.get_by_text("Found: ").wait_for()
    if export is exports.headerless:
        say_what_is_what(page)
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_label("Campaign name").fill("knit")
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url("**/recording?c=knit")
    steps.end("import")
    page.get_by_role("link", name="Compare").click()
    page.get_by_role("button", name="Fit the baseline").click()
    page.get_by_text("Where it fails, the worst first").wait_for()
    steps.end("fit")


def say_what_is_what(page) -> None:
    """Without a header, the page asks; the position of this script falls with stretch."""
    for role, column, unit in COLUMNS:
        choose(page, f"Column of {role}", column)
        page.get_by_text("the file does not say the unit: choose it").wait_for()
        choose(page, f"Unit of {role}", unit)
        page.get_by_text("the file does not say the unit: choose it").wait_for(state="detached")
    page.get_by_role("checkbox", name="Turn the sign of the displacement").click()


class Steps:
    """How long each step took: on the clock, and of one core (the server and its jobs, whatever else runs)."""

    def __init__(self, studio: Served) -> None:
        self.studio = studio
        self.ends = [("", time.monotonic(), studio.busy_s())]

    def end(self, name: str) -> None:
        self.ends.append((name, time.monotonic(), self.studio.busy_s()))

    def busy_s(self) -> float:
        return self.ends[-1][2] - self.ends[0][2]

    def words(self) -> str:
        parts = [
            f"{name} {at_s - before_s:.0f} s ({busy_s - busy_before_s:.0f} of a core)"
            for (_, before_s, busy_before_s), (name, at_s, busy_s) in itertools.pairwise(self.ends)
        ]
        return f"{', '.join(parts)}; all {self.ends[-1][1] - self.ends[0][1]:.0f} s ({self.busy_s():.0f} of a core)"


def note(name: str, steps: Steps) -> None:
    """Print the times, and keep them among CI's artefacts; a busy machine makes no test fail."""
    words = f"{name}: {steps.words()}, load {os.getloadavg()[0]:.0f}"
    print(words, file=sys.stderr)
    with (SHOTS / "times-to-report.txt").open("a") as stream:
        stream.write(words + "\n")
