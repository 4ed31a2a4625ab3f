"""The pictures of docs/studio.md that show a diagnosis, drawn from the hidden effect of the demo.

python benchmarks/studio_pictures.py WORKSPACE [-o docs/images]

What is not in the workspace yet (recordings, baseline, diagnosis) is made; that takes some minutes, the pictures one.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

from datasets.demo import GAUGE_LENGTH_MM, HIDDEN, do
from tests.testbench.studio.browsing import screen
from tests.testbench.studio.served import CHROMIUM, served

NAMES = ("calibration", "held_out")
C = NAMES[0]
WIDTH, HEIGHT = 1280, 800


def made(root: Path) -> None:
    """Two campaigns of the demo's sensor, the first one fitted and diagnosed."""
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


def drawn(page: Page) -> None:
    """Wait until every plot on the screen stands still."""
    page.wait_for_selector(".js-plotly-plot[data-drawn]")
    page.wait_for_timeout(2000)


def pictures(page: Page, address: str, out: Path) -> None:
    """The verdict, a candidate, the experiment, the ladder; the last adds the first candidate."""
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
    page.goto(f"{address}/missing?c={C}")
    page.get_by_role("button", name="Add ").first.click()
    page.wait_for_url("**/ladder?c=*")
    page.get_by_text("Through the history").wait_for()
    drawn(page)
    page.screenshot(path=out / "studio-ladder.png")


def main() -> None:
    """Make what is missing, and draw."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("workspace", type=Path)
    parser.add_argument("-o", "--output", type=Path, default=Path("docs/images"))
    args = parser.parse_args()
    root = args.workspace.resolve()
    made(root)
    with served(root) as studio, sync_playwright() as play:
        browser = play.chromium.launch(executable_path=str(CHROMIUM), args=["--no-sandbox"])
        with screen(browser, WIDTH, HEIGHT) as page:
            page.set_default_timeout(600_000)
            pictures(page, studio.address, args.output)
        browser.close()


if __name__ == "__main__":
    main()
