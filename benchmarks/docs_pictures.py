"""The pictures of README, tutorial and docs/studio.md.

    python benchmarks/docs_pictures.py WORKSPACE [-o docs/images]
    python benchmarks/docs_pictures.py WORKSPACE --studio        # those of the studio alone

What is not beside the workspace yet (recordings, models, diagnoses) is made; that takes some minutes, the pictures
one.
"""

from __future__ import annotations

import argparse
import shutil
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from datasets.demo import GAUGE_LENGTH_MM, HIDDEN, do
from testbench.studio.proposed_law import FOLDER, JSON, MODEL
from tests.testbench.studio.browser.browsing import screen
from tests.testbench.studio.served import CHROMIUM, served

NAMES = ("calibration", "held_out")
C = NAMES[0]
SIMULATED = {"pes-1": ("paper-1", 51), "pes-2": ("paper-2", 52)}  # one sensor, two motions
RECORDED_S = 40  # of the recording that is drawn while it runs
WIDTH, HEIGHT = 1280, 800
# What a report on each hidden case draws for README and tutorial: its figure, and the picture in the docs.
REPORTED = {
    "hidden-effect": (HIDDEN, {"at-a-glance": "at-a-glance"}),
    "tutorial": (("--seed", "3"), {"candidates": "tutorial-candidates", "ladder": "tutorial-ladder"}),
}


def reported(beside: Path, out: Path) -> None:
    """The figures of README and tutorial, as a report draws them."""
    gauge = ("--gauge-length-mm", GAUGE_LENGTH_MM)
    for name, (hidden, wanted) in REPORTED.items():
        case = beside / name
        if not case.exists():
            do("testbench", "hide", *hidden, "-o", case)
        first, held = (case / "recordings" / f"{each}.csv" for each in NAMES)
        pair = (first, "--held-out", held)
        diagnosis, model = case / "diagnosis.json", case / "model.json"
        if not diagnosis.exists():
            do("testbench", "diagnose", *pair, *gauge, "--json", diagnosis, "-o", model)
        told = ("--recording", *pair, *gauge, "--model", model, "--diagnosis", diagnosis)
        do("testbench", "report", *told, "--figures", case / "figures", "-o", case / "report.html")
        for figure, picture in wanted.items():
            shutil.copyfile(case / "figures" / f"{figure}.png", out / f"{picture}.png")


def made(root: Path) -> None:
    """Two campaigns of the demo's sensor, the first one fitted and diagnosed; and two of the simulated rig."""
    hidden, results = root.parent / "hidden-effect", root / "results" / C
    if not hidden.exists():
        do("testbench", "hide", *HIDDEN, "-o", hidden)
    for name in NAMES:
        if not (root / name).exists():
            csv = hidden / "recordings" / f"{name}.csv"
            do("testbench", "import", csv, "--gauge-length-mm", GAUGE_LENGTH_MM, "-o", root / name)
    results.mkdir(parents=True, exist_ok=True)
    pair, model = (root / C, "--held-out", root / NAMES[1]), results / "model.json"
    if not model.exists():
        do("testbench", "fit", *pair, "-o", model)
    if not (results / "diagnosis.json").exists():
        found = ("--json", results / "diagnosis.json", "-o", results / "diagnosed.json")
        do("testbench", "diagnose", *pair, "--model", model, *found)
    if not (results / "experiment.json").exists():
        asked = ("--diagnosis", results / "diagnosis.json", "--fit", *pair, "--strain-max", 30, "--duration-s", 600)
        program = root / "programs" / f"{C}-experiment"
        do("testbench", "experiment", *asked, "--json", results / "experiment.json", "-o", program)
    proposal = results / FOLDER
    if not (proposal / JSON).exists():
        proposal.mkdir(exist_ok=True)
        written = ("--json", proposal / JSON, "--save-model", proposal / MODEL, "-o", proposal / f"{C}_law.py")
        do("testbench", "propose", *pair, "--model", model, "--laws", 1, *written)
    for name, (preset, seed) in SIMULATED.items():
        planned = root.parent / preset
        if not (root / name).exists():
            words = ("--preset", preset, "--seed", seed, "--gauge-length-mm", GAUGE_LENGTH_MM)
            do("gcode", "generate", *words, "-o", planned)
            do("testbench", "run", "--sensor", "pes", "--program", planned / "program.tap", "-o", root / name)


def drawn(page: Page) -> None:
    """Wait until every plot on the screen stands still."""
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    page.wait_for_timeout(2000)


def pictures(page: Page, address: str, out: Path) -> None:
    """The verdict, a candidate, the experiment, a law, the ladder; the last adds the first candidate."""
    page.goto(f"{address}/missing?c={C}")
    page.get_by_text("lie on the dashed line").wait_for()
    drawn(page)
    page.screenshot(path=out / "studio-missing.png")
    page.get_by_text("Candidates", exact=True).evaluate("e => e.scrollIntoView({ block: 'start' })")
    drawn(page)
    page.screenshot(path=out / "studio-candidate.png")
    page.goto(f"{address}/experiment?c={C}")
    page.get_by_role("button", name="Download the Mach4 program").wait_for()
    drawn(page)
    page.screenshot(path=out / "studio-experiment.png")
    page.goto(f"{address}/propose?c={C}")
    page.locator(".verdict").wait_for()
    page.locator(".verdict").evaluate("e => e.scrollIntoView({ block: 'start' })")
    page.wait_for_timeout(2000)
    page.screenshot(path=out / "studio-propose.png")
    page.goto(f"{address}/missing?c={C}")
    page.get_by_role("button", name="Add ").first.click()
    page.wait_for_url("**/ladder?c=*")
    page.get_by_text("Through the history").wait_for()
    drawn(page)
    page.screenshot(path=out / "studio-ladder.png")


def pictures_before(page: Page, address: str, out: Path) -> None:
    """What comes before a diagnosis: campaigns, a plan and its clocks, a comparison, a compensator, a recording."""
    page.goto(f"{address}/compare?c={C}")
    drawn(page)
    page.screenshot(path=out / "studio-compare.png")
    page.goto(address)
    page.get_by_text("4 campaigns").wait_for()
    page.get_by_text("verified").nth(3).wait_for()
    page.screenshot(path=out / "studio-campaigns.png")
    page.goto(f"{address}/align?c=pes-1")
    drawn(page)
    page.screenshot(path=out / "studio-align.png")
    page.goto(f"{address}/plan")
    page.get_by_role("button", name="Plan", exact=True).click()
    drawn(page)
    page.screenshot(path=out / "studio-plan.png")
    page.goto(f"{address}/compensate?c=pes-1")
    page.get_by_role("button", name="Train").click()
    page.get_by_role("button", name="Compensator as JSON").wait_for()
    drawn(page)
    page.screenshot(path=out / "studio-compensate.png")
    page.goto(f"{address}/record")
    page.get_by_label("Force limit / N").fill("8")
    page.get_by_role("button", name="Record", exact=False).last.click()
    page.get_by_role("button", name="Stop").wait_for()
    page.wait_for_timeout(1000 * RECORDED_S)
    page.screenshot(path=out / "studio-record.png")
    page.get_by_role("button", name="Stop").click()
    page.get_by_role("button", name="Resume").wait_for()


def main() -> None:
    """Make what is missing, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workspace", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    parser.add_argument("--studio", action="store_true", help="only those of the studio")
    args = parser.parse_args()
    root = args.workspace.resolve()
    if not args.studio:
        reported(root.parent, args.output)
    made(root)
    with served(root) as studio, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        with screen(browser, WIDTH, HEIGHT) as page:
            page.set_default_timeout(600_000)
            pictures_before(page, studio.address, args.output)
            pictures(page, studio.address, args.output)
        browser.close()


if __name__ == "__main__":
    main()
