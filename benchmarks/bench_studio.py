"""The studio in real Chromium: first view of a 23 min campaign, zoom, change of tab; memory over an hour.

python benchmarks/bench_studio.py [--hour | --campaigns N] [--runs N]

Times are from the click (or the address) to the drawn plot, Playwright's own delay included; the load average of the
machine stands beside them. `--hour` records an hour of the simulated rig through its serial port and the live page,
20 times faster than it lasts. `--campaigns N` lists so many, in a studio that has never seen them and again, and
looks for one of them; beside it the time of a page of the studio without any list.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import os
import re
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from compensation.cli import main as compensation
from gcode.cli import main as gcode
from testbench.cli import main as testbench
from testbench.studio.jobs.jobs import interpreter_argv
from tests.testbench.studio.served import CHROMIUM, Served, served

HOUR_S, HASTE = 3600.0, 20
GOALS_S = {"first view": 2.0, "zoom": 0.3, "tab": 0.3}
# Every plot in view has lines or bars; the first one counts.
DRAWN = "() => document.querySelector('.js-plotly-plot .trace path[d]') !== null"
ZOOMED = """([from, to]) => { const plot = document.querySelector('.js-plotly-plot');
  const row = plot.calcdata[0]; return row[0].x > from - 5 && row[row.length - 1].x < to + 5; }"""


def quietly(command: Callable[[list[str]], int], *argv: object) -> None:
    """Run a command without its words."""
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        code = command([str(word) for word in argv])
    assert code == 0, argv


def prepared(root: Path, minutes: float) -> None:
    """Two campaigns of the paper's motion; the first one fitted, diagnosed and compensated."""
    program = root / "programs" / "paper"
    options = ["--preset", "paper-1", "--seed", 51, "--gauge-length-mm", 25, "--duration-s", 60 * minutes]
    quietly(gcode, "generate", *options, "-o", program)
    for seed in (1, 2):
        argv = ["--sensor", "pes", "--program", program / "program.tap", "--seed", seed]
        quietly(testbench, "run", *argv, "-o", root / f"knit-{seed}")
    results = root / "results" / "knit-1"
    results.mkdir(parents=True)
    knit, model, compensator = root / "knit-1", results / "model.json", results / "force.compensator.json"
    quietly(testbench, "fit", knit, "-o", model)
    found = ["--json", results / "diagnosis.json", "-o", results / "diagnosed.json"]
    quietly(testbench, "diagnose", knit, "--model", model, *found, "--quiet")
    quietly(compensation, "train", knit, "--target", "force", "--hidden", "4,2,2", "-o", compensator)
    quietly(compensation, "score", compensator, knit, root / "knit-2", "-o", results / "force.score.json")


def timed(page: Page, action: Callable[[], object], ready: str, argument: object = None) -> float:
    """Seconds from an action to a condition on the page."""
    start_s = time.perf_counter()
    action()
    page.wait_for_function(ready, arg=argument, polling="raf")
    return time.perf_counter() - start_s


def first_views(browser, studio: Served, runs: int) -> list[float]:
    """A deep link in a browser that has never seen the studio."""
    found = []
    for _ in range(runs):
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        page = context.new_page()
        visit = partial(page.goto, f"{studio.address}/recording?c=knit-1", wait_until="commit")
        found.append(timed(page, visit, DRAWN))
        context.close()
    return found


def opened(browser, studio: Served, runs: int) -> list[float]:
    """From the list of campaigns to the plot, by a click on a card."""
    found = []
    for _ in range(runs):
        context = browser.new_context(viewport={"width": 1280, "height": 800})
        page = context.new_page()
        page.goto(studio.address)
        page.get_by_text("verified").nth(1).wait_for()
        page.wait_for_timeout(500)
        found.append(timed(page, page.get_by_role("link", name="knit-1").click, DRAWN))
        context.close()
    return found


def zooms(page: Page, studio: Served, path: str, runs: int) -> list[float]:
    """Drag over a stretch; ready when every sample of it is drawn."""
    page.goto(studio.address + path)
    page.wait_for_function(DRAWN)
    page.wait_for_timeout(1500)
    found = []
    for run in range(runs):
        box = page.locator(".js-plotly-plot .nsewdrag").first.bounding_box()
        assert box
        left, right = 0.2 + 0.05 * (run % 4), 0.45 + 0.05 * (run % 4)
        y = box["y"] + box["height"] / 2
        page.mouse.move(box["x"] + left * box["width"], y)
        page.mouse.down()
        page.mouse.move(box["x"] + right * box["width"], y, steps=4)
        span = page.evaluate("() => document.querySelector('.js-plotly-plot')._fullLayout.xaxis.range")
        width = span[1] - span[0]
        inside = [span[0] + left * width, span[0] + right * width]
        found.append(timed(page, page.mouse.up, ZOOMED, inside))
        page.mouse.dblclick(box["x"] + 0.5 * box["width"], y)
        page.wait_for_timeout(1200)
    return found


TABS = ("Compare", "Missing effect", "Error ladder", "Compensate", "Recording")


def tab_changes(page: Page, studio: Served, runs: int) -> dict[str, list[float]]:
    """Through the tabs of a campaign, round and round."""
    page.goto(f"{studio.address}/recording?c=knit-1")
    page.wait_for_function(DRAWN)
    page.wait_for_timeout(2000)
    found: dict[str, list[float]] = {name: [] for name in TABS}
    for _ in range(runs):
        for name in TABS:
            tab = page.get_by_role("navigation", name="Steps").get_by_role("link", name=name)
            page.evaluate("() => document.querySelectorAll('.page').forEach(page => page.classList.add('stale'))")
            fresh = f"() => document.querySelector('.page:not(.stale)') !== null && ({DRAWN})()"
            found[name].append(timed(page, tab.click, fresh))
            page.wait_for_timeout(1500)
    return found


def tell(name: str, times_s: list[float], goal_s: float) -> None:
    """One line of the table."""
    median, worst = statistics.median(times_s), max(times_s)
    load = os.getloadavg()[0]
    print(f"{name:42} {median:7.2f} {worst:7.2f} {goal_s:7.2f}   {load:5.1f}", flush=True)


def speeds(browser, root: Path, runs: int) -> None:
    """First view, zoom, change of tab."""
    with served(root) as studio:
        print(f"{'seconds':42} {'median':>7} {'worst':>7} {'goal':>7}   load average (1 min)")
        time.sleep(3)
        tell("first view, deep link, new browser", first_views(browser, studio, runs), GOALS_S["first view"])
        tell("first view, from the list", opened(browser, studio, runs), GOALS_S["first view"])
        page = browser.new_page(viewport={"width": 1280, "height": 800})
        for name, path in (("recording", "/recording?c=knit-1"), ("comparison", "/compare?c=knit-1")):
            tell(f"zoom, {name}", zooms(page, studio, path, runs), GOALS_S["zoom"])
        for name, times_s in tab_changes(page, studio, runs).items():
            tell(f"tab, {name}, first time", times_s[:1], GOALS_S["tab"])
            tell(f"tab, {name}, again", times_s[1:], GOALS_S["tab"])
        page.close()


HEADED = "() => document.querySelector('.page h1') !== null"
LISTED = "([many]) => document.body.innerText.includes(many + ' campaigns')"
FOUND = "([many]) => document.body.innerText.includes('1 of ' + many)"


def crowded(root: Path, count: int) -> None:
    """So many campaigns, of one small recording each."""
    program = root / "programs" / "short"
    options = ["--preset", "paper-1", "--seed", 1, "--gauge-length-mm", 25, "--duration-s", 60]
    quietly(gcode, "generate", *options, "-o", program)
    quietly(testbench, "run", "--sensor", "pes", "--program", program / "program.tap", "-o", root / "run-0000")
    for number in range(1, count):
        shutil.copytree(root / "run-0000", root / f"run-{number:04d}")


def lists(browser, root: Path, count: int, runs: int) -> None:
    """Thousands of campaigns in the list."""
    print(f"{'seconds':42} {'median':>7} {'worst':>7} {'goal':>7}   load average (1 min)")
    first, again, found, bare = [], [], [], []
    for _ in range(runs):
        with served(root) as studio:
            time.sleep(3)
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            page.goto(f"{studio.address}/effects")
            bare.append(timed(page, partial(page.goto, f"{studio.address}/effects", wait_until="commit"), HEADED))
            for times in (first, again):
                times.append(timed(page, partial(page.goto, studio.address, wait_until="commit"), LISTED, [count]))
            wanted = f"run-{count // 2:04d}"
            found.append(timed(page, partial(page.get_by_label("Search").fill, wanted), FOUND, [count]))
            page.close()
    tell("another page of the studio", bare, 1.0)
    tell(f"{count} campaigns, never seen before", first, 1.0)
    tell(f"{count} campaigns, again", again, 1.0)
    tell("one of them searched, from the typing", found, 1.0)


def hour(browser, root: Path) -> None:
    """An hour of the simulated rig, through its port, the recorder and the live page."""
    program = root / "programs" / "hour"
    options = ["--preset", "paper-1", "--seed", 7, "--gauge-length-mm", 25, "--duration-s", HOUR_S + 60]
    quietly(gcode, "generate", *options, "-o", program)
    link = root.parent / "rig"
    argv = ["testbench", "rig", "--sensor", "pes", "--program", program / "program.tap"]
    argv += ["--link", link, "--speed", HASTE]
    rig = subprocess.Popen(interpreter_argv([str(word) for word in argv]), stdout=subprocess.DEVNULL)
    try:
        with served(root, refresh_s=0.5 / HASTE) as studio:
            page = browser.new_page(viewport={"width": 1280, "height": 800})
            _start_recording(page, studio, link)
            _watch(page, studio)
    finally:
        rig.terminate()
        rig.wait()


def _start_recording(page: Page, studio: Served, link: Path) -> None:
    while not link.exists():
        time.sleep(0.1)
    page.goto(f"{studio.address}/record")
    page.get_by_label("Port").fill(str(link))
    page.keyboard.press("Tab")
    page.get_by_label("Program").wait_for()
    page.get_by_role("button", name="Record", exact=False).last.click()


def _watch(page: Page, studio: Served) -> None:
    session = page.context.new_cdp_session(page)
    names = f"{'recorded':>10} {'samples':>9} {'redrawn':>8} {'server':>10} {'page, JS heap':>14} {'DOM nodes':>10}"
    print(f"{names}   load average (1 min)")
    start_s, next_s = time.perf_counter(), 300.0
    recorded = 0.0
    while recorded < HOUR_S and time.perf_counter() - start_s < 3 * HOUR_S / HASTE:
        page.wait_for_timeout(500)
        found = re.search(r"([\d.]+) / [\d.]+ s Time.*?(\d+) Samples", page.inner_text("body"), re.DOTALL)
        if not found or float(found.group(1)) < next_s:
            continue
        recorded, next_s = float(found.group(1)), min(next_s + 600.0, HOUR_S)
        session.send("HeapProfiler.collectGarbage")
        heap_MB = session.send("Runtime.getHeapUsage")["usedSize"] / 2**20
        nodes = session.send("Memory.getDOMCounters")["nodes"]
        drawn = page.evaluate("() => document.querySelector('.js-plotly-plot').dataset.drawn")
        memory = f"{studio.resident_MB():7.1f} MB {heap_MB:11.1f} MB {nodes:10}"
        print(f"{recorded:8.0f} s {found.group(2):>9} {drawn:>8} {memory}  {os.getloadavg()[0]:5.1f}", flush=True)
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("button", name="Open the recording").wait_for()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--hour", action="store_true", help="memory over an hour of recording (3 min) instead")
    parser.add_argument("--campaigns", type=int, metavar="N", help="a list of so many campaigns instead")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--minutes", type=float, default=23.0, help="length of the campaigns (default: 23)")
    args = parser.parse_args()
    if not CHROMIUM.exists():
        print(f"{CHROMIUM} is not installed: nothing measured")
        return
    with tempfile.TemporaryDirectory() as scratch, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        root = Path(scratch) / "ws"
        if args.hour:
            hour(browser, root)
        elif args.campaigns:
            crowded(root, args.campaigns)
            lists(browser, root, args.campaigns, args.runs)
        else:
            prepared(root, args.minutes)
            speeds(browser, root, args.runs)
        browser.close()


if __name__ == "__main__":
    main()
