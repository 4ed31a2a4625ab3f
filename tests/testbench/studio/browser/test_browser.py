"""The flow in a real browser: Debian's chromium, driven by Playwright. Screenshots go to artifacts/."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from gcode.cli import main as gcode
from testbench.cli import main as run_testbench
from testbench.knit.catalogue import baseline, load_catalogue
from testbench.studio.jobs.jobs import interpreter_argv
from tests.testbench import builders
from tests.testbench.studio.browser.browsing import IN_CHROMIUM, samples, screen, shot, until

pytestmark = IN_CHROMIUM


def foreign_csv(folder: Path) -> Path:
    """As a tester writes it: two and a half minutes of a sensor whose stress relaxes."""
    model = builders.truth().plus(load_catalogue()["stress_relaxation"]().replaced(fraction=0.35, tau_s=12.0))
    return Path(builders.write_csv(builders.record(model, 150), folder / "lab.csv"))


def test_the_whole_loop_on_a_csv(running, page, tmp_path: Path) -> None:
    address, root = running.address, running.root
    page.goto(address)
    page.get_by_role("button", name="Import a file").click()
    page.get_by_label("File on this machine").fill(str(foreign_csv(tmp_path).resolve()))
    page.get_by_role("button", name="Read the file").click()
    page.get_by_label("Gauge length / mm").fill("40")
    page.get_by_label("Campaign name").fill("strip")
    shot(page, "import")
    page.get_by_role("button", name="Import", exact=True).click()
    page.wait_for_url("**/recording?c=strip")
    page.wait_for_selector(".js-plotly-plot .main-svg")
    shot(page, "recording")

    page.get_by_role("link", name="Compare").click()
    page.get_by_role("button", name="Fit the baseline").click()
    page.get_by_text("Where it fails, the worst first").wait_for()
    page.wait_for_selector(".js-plotly-plot .main-svg")
    shot(page, "compare")

    page.get_by_role("button", name="What is missing?").click()
    page.get_by_role("button", name="Find what is missing").click()
    page.get_by_text("Choose one to see what it would add.").wait_for()
    page.get_by_text("lie on the dashed line").wait_for()
    shot(page, "missing")
    page.get_by_role("button", name=re.compile("^Add (?!all )")).click()
    page.wait_for_url("**/ladder?c=strip")
    page.get_by_text("Through the history").wait_for()
    shot(page, "ladder")
    history = json.loads((root / "results" / "strip" / "model.json").read_text())["history"]
    assert len(history) >= 2
    first, last = history[0]["errors"]["held_out"], history[-1]["errors"]["held_out"]
    assert min(last[channel] / first[channel] for channel in first) < 1.0

    page.get_by_role("button", name="Report").click()
    page.get_by_role("link", name="Open the report").wait_for()
    assert (root / "results" / "strip" / "report.html").stat().st_size <= 6_000_000
    page.get_by_role("button", name="Undo the last step").click()
    model = root / "results" / "strip" / "model.json"
    until(page, lambda: len(json.loads(model.read_text())["history"]) == len(history) - 1)
    assert [step["step"] for step in json.loads(model.read_text())["history"]] == [
        step["step"] for step in history[:-1]
    ]


def truth(path: Path) -> None:
    model = baseline().plus(load_catalogue()["stress_relaxation"]().replaced(fraction=0.35, tau_s=12.0))
    path.write_text(json.dumps(model.to_dict()))


@pytest.fixture(scope="module")
def program(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("programs") / "five-minutes"
    options = ["--preset", "paper-1", "--seed", "7", "--gauge-length-mm", "25", "--duration-s", "300"]
    assert gcode(["generate", *options, "-o", str(folder)]) == 0
    return folder


def put_program(root: Path, program: Path) -> None:
    import shutil

    shutil.copytree(program, root / "programs" / program.name)


def test_a_minute_of_live_recording(running, page, program: Path) -> None:
    address, root = running.address, running.root
    put_program(root, program)
    page.goto(f"{address}/record")
    page.get_by_label("Force limit / N").fill("50")
    page.get_by_role("button", name="Record", exact=False).last.click()
    samples(page, 700)
    before = running.resident_MB()
    samples(page, 2_200)
    shot(page, "live")
    assert running.resident_MB() < before + 30
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("button", name="Open the recording").click()
    page.wait_for_selector(".js-plotly-plot .main-svg")
    assert (root / "recorded-1" / "recording.csv").read_text().count("\n") > 2_200
    assert run_testbench(["verify", str(root / "recorded-1")]) == 0


def test_the_port_gone_midway_is_said_and_the_samples_stay(running, page, program: Path) -> None:
    address, root = running.address, running.root
    put_program(root, program)
    link = root / "port"
    argv = ["testbench", "rig", "--sensor", "pes", "--program", str(root / "programs" / program.name / "program.tap")]
    rig = subprocess.Popen(interpreter_argv([*argv, "--link", str(link)]))
    try:
        while not link.exists():
            assert rig.poll() is None, "the rig ended at its start; see its words above"
            time.sleep(0.1)
        page.goto(f"{address}/record")
        page.get_by_label("Port").fill(str(link))
        page.keyboard.press("Tab")
        page.get_by_role("button", name="Record", exact=False).last.click()
        samples(page, 100)
    finally:
        os.kill(rig.pid, signal.SIGKILL)
        rig.wait()
    page.get_by_role("alert").filter(has_text=re.compile(r"port lost \(.*trying to get it back")).wait_for()
    shot(page, "port-gone")
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("button", name="Open the recording").wait_for()
    assert (root / "recorded-1" / "recording.csv").read_text().count("\n") > 100


def test_a_diagnosis_can_be_cancelled_and_two_tabs_share_it(
    running, page, browser, program: Path, tmp_path: Path
) -> None:
    address, root = running.address, running.root
    truth(tmp_path / "truth.json")
    argv = ["--model", str(tmp_path / "truth.json"), "--program", str(program / "program.tap")]
    assert run_testbench(["run", *argv, "--seed", "1", "-o", str(root / "knit")]) == 0
    folder = root / "results" / "knit"
    folder.mkdir(parents=True)
    assert run_testbench(["fit", str(root / "knit"), "-o", str(folder / "model.json")]) == 0
    page.goto(f"{address}/missing?c=knit")
    page.get_by_role("button", name="Find what is missing").click()
    page.get_by_role("button", name="Stop").wait_for()
    with screen(browser, 1280, 800) as other:
        other.goto(f"{address}/missing?c=knit")
        other.get_by_role("button", name="Stop").wait_for()
        page.get_by_role("button", name="Stop").click()
        page.get_by_text(re.compile("cancelled after")).wait_for()
        other.get_by_text(re.compile("cancelled after")).wait_for()
    assert not (folder / "diagnosis.json").exists()
    page.get_by_role("link", name="Campaigns").first.click()
    page.get_by_text("verified").wait_for()


def test_a_tablet_in_portrait_needs_no_sideways_scrolling(running, browser, program: Path) -> None:
    address, root = running.address, running.root
    argv = ["run", "--sensor", "pes", "--program", str(program / "program.tap"), "--seed", "1"]
    assert run_testbench([*argv, "-o", str(root / "knit")]) == 0
    with screen(browser, 800, 1280, has_touch=True) as tab:
        for path in ("/", "/recording?c=knit", "/plan", "/import", "/compare?c=knit", "/compensate?c=knit"):
            tab.goto(address + path)
            tab.wait_for_selector(".page h1")
            shot(tab, f"tablet{path.partition('?')[0].replace('/', '-')}")
            assert tab.evaluate("document.documentElement.scrollWidth") <= 800, path


def test_the_first_view_and_a_change_of_tab_are_timed(running, page, program: Path) -> None:
    """Ratios against a bare plotly page of this very machine and moment would be flaky; generous walls are not."""
    address, root = running.address, running.root
    argv = ["run", "--sensor", "pes", "--program", str(program / "program.tap"), "--seed", "1"]
    assert run_testbench([*argv, "-o", str(root / "knit")]) == 0
    page.goto(address)
    page.get_by_text("verified").wait_for()
    start = time.monotonic()
    page.get_by_role("link", name="knit").first.click()
    page.wait_for_selector(".js-plotly-plot .main-svg")
    first = time.monotonic() - start
    start = time.monotonic()
    page.get_by_role("link", name="Compensate").click()
    page.get_by_role("button", name="Train").wait_for()
    print(f"first view {first:.2f} s, tab change {time.monotonic() - start:.2f} s", file=sys.stderr)
